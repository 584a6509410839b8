//! Kinds of road signs, with what they say. In: nothing. Out: [`SignKind`], with the numbers of German signs (`docs/references.md: roads`).

/// Speed limit above which junctions have no priority signs, m/s: 100 km/h. Such roads are motorways.
pub(super) const MOTORWAY_MPS: f64 = 28.0;

/// Kind of a sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum SignKind<'net> {
    /// Sign 206: stop and yield.
    Stop,
    /// Sign 205: yield.
    Yield,
    /// Sign 215: roundabout.
    Roundabout,
    /// Sign 350: zebra crossing.
    Zebra,
    /// Sign 306: priority road.
    Priority,
    /// Sign 274: speed limit, km/h or mph.
    SpeedLimit(u32),
    /// Sign 437: name of a street, to be read from both sides.
    StreetName(&'net str),
    /// Sign 310: name of a place where its streets begin.
    PlaceName(&'net str),
    /// Sign 332: board of an exit, with the name of the road that it leads to.
    ExitBoard(Option<&'net str>),
    /// Sign 333 without its word: exit.
    Exit,
    /// Sign 450: so many hundred metres to the lane of an exit, 1 to 3.
    ExitAhead(u32),
}
