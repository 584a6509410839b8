//! Names of the maps that come with the program. In: nothing. Out: the names, for `catalog` and for the build, which puts these maps into the
//! program.

/// Names of the maps that come with the program; they mean the same map on every machine.
pub const SHIPPED: [&str; 12] = [
    "bottleneck",
    "figure-eight",
    "grid",
    "lane-10km",
    "merge",
    "motorway",
    "practice",
    "ring-250",
    "ring-260",
    "ring-641",
    "town",
    "two-lane-ring",
];
