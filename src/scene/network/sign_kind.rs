//! Kinds of road signs, with what they say and where they stand. In: nothing. Out: [`SignKind`], with the numbers of German signs
//! (`docs/references.md: roads`), and [`Sign`].

use crate::{
    map::network::{LaneId, Network},
    roadside::{road_surfaces::RoadSurfaces, town::Town},
};
use glam::Vec3;

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

/// Sign, and the one below it on the same pole.
pub(super) type Plates<'net> = (SignKind<'net>, Option<SignKind<'net>>);

/// Sign beside a lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sign<'net> {
    pub kind: SignKind<'net>,
    /// Second sign below the first one, on the same pole.
    pub below: Option<SignKind<'net>>,
    /// Outermost lane of the street.
    pub lane: LaneId,
    /// Foot of the pole, world axes, metres.
    pub foot: Vec3,
    /// Direction in which the sign faces, towards those who drive there, a unit vector; that of a street's name across the street.
    pub facing: Vec3,
}

/// Network with all that decides where signs stand and what they say.
#[derive(Clone, Copy)]
pub(in crate::scene) struct SignedRoads<'net> {
    pub net: &'net Network,
    /// Network whose roads run on beyond its edge.
    pub drawn: &'net Network,
    pub surfaces: &'net RoadSurfaces,
    pub town: &'net Town,
    /// Name of the town, if it has one.
    pub place: Option<&'net str>,
}
