//! Fixed objects beside a road, which a car cannot pass: buildings, guard rails, parapets of bridges, barriers at dead ends, trees, poles of street
//! lamps and signals, parked cars, garden fences and walls. In: a roadside. Out: boxes in world axes, metres, and those near a point. Reflector
//! posts and signs are made to give way, and so do bushes and hedges: none is a fixed object.

use super::{
    Roadside,
    buildings::Buildings,
    guard_rails::GuardRail,
    house_plans::{FenceKind, FencePiece, HousePlan},
    parked_cars::ParkedCar,
    plots::Plot,
    road_ends::{BARRIER_BEYOND_M, DeadEnd},
    road_surfaces::RoadSurfaces,
    signal_places::{POLE_RADIUS_M, SignalPlace},
    trees::{Tree, TreeForm, Woods},
};
use crate::{
    map::{
        SHOULDER_M,
        network::{LaneId, LanePosition, Network},
    },
    space::{CAR_LENGTH_M, CAR_WIDTH_M, Pose, is_one_road},
};
use glam::{DVec2, DVec3, IVec2, Vec2, Vec3};
use std::{collections::BTreeMap, f64::consts::PI};

/// Side of the squares in which objects are looked up, metres.
const SQUARE_M: f64 = 32.0;
/// Distance from an object at which it is found, metres: two lengths of a car, and its way in a tick.
pub const REACH_M: f64 = 12.0;
/// Thickness of rails, parapets, barriers and the walls of blocks, metres. In a step of the physics (2.5 ms) a car at 60 m/s moves by half of
/// it.
const THICK_M: f64 = 0.3;
/// Greatest length of a box, and largest distance of a rail's posts from it, metres.
const LONGEST_M: f64 = 60.0;
const STRAIGHT_M: f64 = 0.02;
/// Greatest distance between two looks for a bridge along a lane, metres.
const BRIDGE_STEP_M: f64 = 4.0;
/// Distance beyond a road's edge at which another road is looked for, and the least distance from it, metres.
const BEYOND_EDGE_M: f64 = 0.5;
const FREE_M: f32 = 0.4;

/// Height over the foot of a tree at which a bumper meets its trunk, metres.
const BUMPER_M: f32 = 0.5;

/// Kind of a fixed object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FixedObjectKind {
    /// Wall of a building.
    Building,
    /// Guard rail of a motorway.
    GuardRail,
    /// Parapet of a bridge.
    Parapet,
    /// Barrier at the end of a road.
    Barrier,
    /// Trunk of a tree.
    Tree,
    /// Pole of a street lamp.
    StreetLamp,
    /// Pole of a signal.
    SignalPole,
    /// Car that stands parked.
    ParkedCar,
    /// Fence of boards before a garden.
    Fence,
    /// Wall before a garden.
    GardenWall,
}

impl FixedObjectKind {
    /// Returns the kind in words, as in recordings and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Building => "building",
            Self::GuardRail => "guard rail",
            Self::Parapet => "parapet",
            Self::Barrier => "barrier",
            Self::Tree => "tree",
            Self::StreetLamp => "street lamp",
            Self::SignalPole => "signal pole",
            Self::ParkedCar => "parked car",
            Self::Fence => "fence",
            Self::GardenWall => "garden wall",
        }
    }
}

/// Box that a car cannot pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedObject {
    pub kind: FixedObjectKind,
    /// Middle, and heading of the length.
    pub pose: Pose,
    pub length_m: f64,
    pub width_m: f64,
    /// Height of the road beside it; `None` for an object on land, over and under which there is no road.
    pub height_m: Option<f64>,
}

impl FixedObject {
    /// Returns the box along a line whose right side is the line.
    fn left_of(kind: FixedObjectKind, [from, to]: [DVec2; 2], height_m: Option<f64>) -> Self {
        let along = (to - from).normalize_or(DVec2::X);
        let middle = (from + to) / 2.0 + along.perp() * THICK_M / 2.0;
        let (pose, length_m) = (Pose::new(middle, along.to_angle()), from.distance(to));
        Self { kind, pose, length_m, width_m: THICK_M, height_m }
    }

    /// Returns the square with the area of a round trunk or pole.
    fn round(kind: FixedObjectKind, middle: Vec2, radius_m: f32, height_m: Option<f64>) -> Self {
        let side_m = f64::from(radius_m) * PI.sqrt();
        Self { kind, pose: Pose::new(middle.as_dvec2(), 0.0), length_m: side_m, width_m: side_m, height_m }
    }

    /// Returns the distance of a point from the box, metres; 0 inside.
    pub fn distance_m(&self, point: DVec2) -> f64 {
        let (off, ahead) = (point - self.pose.position, self.pose.forward());
        let off = DVec2::new(off.dot(ahead), off.dot(ahead.perp())).abs();
        (off - DVec2::new(self.length_m, self.width_m) / 2.0).max(DVec2::ZERO).length()
    }

    /// Checks whether a car whose road has this height can touch the object.
    pub fn is_at_height(&self, height_m: f64) -> bool {
        self.height_m.is_none_or(|own_m| is_one_road(own_m, height_m))
    }

    /// Returns the corners of the box around it, parallel to the axes.
    fn bounds(&self) -> [DVec2; 2] {
        let ahead = self.pose.forward();
        let half = (ahead.abs() * self.length_m + ahead.perp().abs() * self.width_m) / 2.0;
        [self.pose.position - half, self.pose.position + half]
    }
}

/// Fixed objects of a network in world axes, sorted into squares.
#[derive(Debug, Default)]
pub struct FixedObjects {
    objects: Vec<FixedObject>,
    /// Numbers of the objects within [`REACH_M`] of each square.
    squares: BTreeMap<[i32; 2], Vec<u32>>,
}

impl FixedObjects {
    /// Returns the objects of a roadside.
    pub fn of(roadside: &Roadside) -> Self {
        let (net, surfaces) = (roadside.drawn_network(), roadside.surfaces());
        let mut objects = of_buildings(&roadside.buildings);
        objects.extend(roadside.guard_rails.iter().flat_map(of_rail));
        objects.extend(roadside.dead_ends.iter().map(of_dead_end));
        let pole = |kind: FixedObjectKind| {
            move |foot: Vec3| FixedObject::round(kind, foot.truncate(), POLE_RADIUS_M, Some(f64::from(foot.z)))
        };
        objects.extend(roadside.street_lamps.iter().map(|lamp| lamp.foot).map(pole(FixedObjectKind::StreetLamp)));
        objects.extend(roadside.signals.iter().flat_map(SignalPlace::poles).map(pole(FixedObjectKind::SignalPole)));
        objects.extend(roadside.parked_cars.iter().map(of_parked_car));
        objects.extend(roadside.buildings.plots.iter().filter(|plot| plot.has_fence).flat_map(of_fence));
        let Woods { trees, forms } = roadside.woods();
        objects.extend(trees.iter().filter_map(|tree| of_tree(tree, &forms[tree.kind])));
        if surfaces.level_m().is_none() {
            objects.extend(net.lane_ids().flat_map(|lane| parapets(net, surfaces, lane)));
        }
        for object in &mut objects {
            object.pose.position += roadside.origin.truncate();
            object.height_m = object.height_m.map(|height_m| height_m + roadside.origin.z);
        }
        Self::new(objects)
    }

    /// Sorts objects in world axes into squares.
    pub fn new(objects: Vec<FixedObject>) -> Self {
        let mut squares: BTreeMap<[i32; 2], Vec<u32>> = BTreeMap::new();
        for (number, object) in (0u32..).zip(&objects) {
            let [low, high] = object.bounds();
            let (from, to) = (square(low - REACH_M), square(high + REACH_M));
            for (x, y) in (from.y..=to.y).flat_map(|y| (from.x..=to.x).map(move |x| (x, y))) {
                squares.entry([x, y]).or_default().push(number);
            }
        }
        Self { objects, squares }
    }

    /// Returns all objects within [`REACH_M`] of a point, each with its number.
    pub fn near(&self, point: DVec2) -> impl Iterator<Item = (u32, &FixedObject)> {
        let numbers = self.squares.get(&square(point).to_array()).map_or(&[][..], Vec::as_slice);
        let objects = numbers.iter().map(|number| (*number, &self.objects[*number as usize]));
        objects.filter(move |(_, object)| object.distance_m(point) <= REACH_M)
    }

    /// Returns all objects, in the order of their numbers.
    pub fn iter(&self) -> impl Iterator<Item = &FixedObject> {
        self.objects.iter()
    }

    /// Returns an object by its number.
    pub fn get(&self, number: u32) -> Option<&FixedObject> {
        self.objects.get(number as usize)
    }
}

fn square(point: DVec2) -> IVec2 {
    (point / SQUARE_M).floor().as_ivec2()
}

/// Returns the buildings: rectangles as boxes, the walls of others one by one.
fn of_buildings(buildings: &Buildings) -> Vec<FixedObject> {
    let kind = FixedObjectKind::Building;
    let plots = buildings.plots.iter().map(|plot| {
        let pose = Pose::new(plot.middle().as_dvec2(), f64::from(plot.inwards.to_angle()));
        let (length_m, width_m) = (f64::from(plot.depth_m), f64::from(plot.width_m));
        FixedObject { kind, pose, length_m, width_m, height_m: None }
    });
    let walls = buildings.blocks.iter().flat_map(|block| {
        let corners = block.outline.iter().zip(block.outline.iter().cycle().skip(1));
        // Counter-clockwise, the inside is on the left.
        corners.map(|(from, to)| FixedObject::left_of(kind, [from.as_dvec2(), to.as_dvec2()], None))
    });
    plots.chain(walls).collect()
}

/// Returns a rail as boxes, each as long as the rail is straight.
fn of_rail(rail: &GuardRail) -> Vec<FixedObject> {
    let feet: Vec<DVec3> = rail.posts.iter().map(|post| post.foot.as_dvec3()).collect();
    let is_straight = |from: usize, to: usize| {
        let (a, b) = (feet[from].truncate(), feet[to].truncate());
        let along = (b - a).normalize_or_zero();
        let off_m = |foot: &DVec3| along.perp_dot(foot.truncate() - a).abs();
        a.distance(b) <= LONGEST_M && feet[from..to].iter().all(|foot| off_m(foot) < STRAIGHT_M)
    };
    let (mut boxes, mut from) = (Vec::new(), 0);
    while from + 1 < feet.len() {
        let mut to = from + 1;
        while to + 1 < feet.len() && is_straight(from, to + 1) {
            to += 1;
        }
        let to_road = rail.posts[from].to_road.truncate().as_dvec2();
        let [a, b] = [from, to].map(|k| feet[k].truncate());
        let road_is_left = (b - a).perp_dot(to_road) > 0.0;
        let height_m = Some((feet[from].z + feet[to].z) / 2.0);
        let line = if road_is_left { [b, a] } else { [a, b] };
        boxes.push(FixedObject::left_of(FixedObjectKind::GuardRail, line, height_m));
        from = to;
    }
    boxes
}

fn of_dead_end(end: &DeadEnd) -> FixedObject {
    let middle = end.middle.truncate() + end.outwards * BARRIER_BEYOND_M;
    let half = end.outwards.perp() * end.half_width_m;
    // Seen along the road, the left of a line to its right is beyond the end.
    FixedObject::left_of(FixedObjectKind::Barrier, [middle + half, middle - half], Some(end.middle.z))
}

fn of_parked_car(car: &ParkedCar) -> FixedObject {
    FixedObject {
        kind: FixedObjectKind::ParkedCar,
        pose: Pose::new(car.position.truncate().as_dvec2(), f64::from(car.yaw_rad)),
        length_m: CAR_LENGTH_M,
        width_m: CAR_WIDTH_M,
        height_m: None,
    }
}

/// Returns the pieces of a plot's fence or garden wall; none of a hedge.
fn of_fence(plot: &Plot) -> Vec<FixedObject> {
    let piece = |&FencePiece { kind, left_m, right_m }: &FencePiece| {
        let [near_m, far_m] = kind.sides_m();
        let middle = plot.point((left_m + right_m) / 2.0, (near_m + far_m) / 2.0 - plot.garden_m);
        let kind = match kind {
            FenceKind::Hedge(_) => return None,
            FenceKind::Boards => FixedObjectKind::Fence,
            FenceKind::GardenWall => FixedObjectKind::GardenWall,
        };
        let pose = Pose::new(middle.as_dvec2(), f64::from(plot.along().to_angle()));
        let [length_m, width_m] = [right_m - left_m, far_m - near_m].map(f64::from);
        Some(FixedObject { kind, pose, length_m, width_m, height_m: None })
    };
    HousePlan::of(plot).fence.iter().filter_map(piece).collect()
}

/// Returns the trunk of a tree; `None` for a bush.
fn of_tree(tree: &Tree, form: &TreeForm) -> Option<FixedObject> {
    let (off, radius_m) = form.trunk?.at(BUMPER_M / tree.scale);
    let middle = tree.at + Vec2::from_angle(tree.yaw_rad).rotate(off * tree.scale);
    Some(FixedObject::round(FixedObjectKind::Tree, middle, radius_m * tree.scale, None))
}

/// Returns the parapets of a lane on a bridge, where no other road is beside it.
fn parapets(net: &Network, surfaces: &RoadSurfaces, lane: LaneId) -> Vec<FixedObject> {
    let of = net.lane(lane);
    let is_paved = net.edge_of(lane).kind.is_street() && (net.is_driven(lane) || of.is_footway());
    let count = (of.line.drawn_m() / BRIDGE_STEP_M).ceil().max(1.0) as usize;
    let edge_m = of.half_width_m() + if of.is_footway() { 0.0 } else { SHOULDER_M };
    let place = |row: f64, offset_m: f64| {
        let s_m = of.length_m * row / count as f64;
        net.pose(LanePosition { lane, s_m, offset_m }).position
    };
    let rows =
        (0..if is_paved { count } else { 0 }).filter(|k| surfaces.is_on_bridge(place(*k as f64 + 0.5, 0.0).as_vec3()));
    let sides = rows.flat_map(|k| [-1.0, 1.0].map(|side| (k as f64, side)));
    let is_free = |(row, side): &(f64, f64)| {
        let beyond = place(row + 0.5, side * (edge_m + BEYOND_EDGE_M));
        surfaces.border_m(beyond.truncate().as_vec2()) > FREE_M
    };
    let parapet = |(row, side): (f64, f64)| {
        let [from, to] = [row, row + 1.0].map(|row| place(row, side * edge_m));
        let line = if side > 0.0 { [from, to] } else { [to, from] };
        let height_m = Some((from.z + to.z) / 2.0);
        FixedObject::left_of(FixedObjectKind::Parapet, line.map(DVec3::truncate), height_m)
    };
    sides.filter(is_free).map(parapet).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::roadside::guard_rails::RailPost;
    use glam::{Vec3, dvec2, dvec3};

    /// Returns the corners of the box around an object, parallel to the axes.
    fn corners(object: &FixedObject) -> [[f64; 2]; 2] {
        object.bounds().map(|at| at.to_array().map(|m| (m * 1000.0).round() / 1000.0))
    }

    #[test]
    fn a_barrier_stands_across_the_end_of_its_road() {
        let end = DeadEnd { middle: dvec3(60.0, 5.0, 2.0), outwards: DVec2::X, half_width_m: 1.6 };
        let barrier = of_dead_end(&end);
        // 0.6 m beyond the end, 0.3 m thick, as wide as the road.
        assert_eq!(corners(&barrier), [[60.6, 3.4], [60.9, 6.6]]);
        assert!(
            barrier.is_at_height(2.0) && !barrier.is_at_height(7.0),
            "under a bridge it stops no car on the bridge"
        );
    }

    #[test]
    fn a_straight_rail_is_one_box_behind_its_line_and_a_bend_has_several() {
        let post = |x: f32, y: f32| RailPost { foot: Vec3::new(x, y, 0.0), along: Vec3::X, to_road: Vec3::Y };
        let straight = (0..=10).map(|k| post(4.0 * k as f32, 0.0)).collect();
        let [only] = of_rail(&GuardRail { posts: straight, into_ground: [false; 2] })[..] else { panic!("one box") };
        assert_eq!(corners(&only), [[0.0, -0.3], [40.0, 0.0]]);
        let bend = (0..=10).map(|k| post(4.0 * k as f32, 0.01 * (k * k) as f32)).collect();
        let boxes = of_rail(&GuardRail { posts: bend, into_ground: [false; 2] });
        assert!((3..=10).contains(&boxes.len()), "{}", boxes.len());
        // Each begins where the one before it ends.
        for pair in boxes.windows(2) {
            let end = |of: &FixedObject, share: f64| of.pose.position + of.pose.forward() * share * of.length_m / 2.0;
            let [before, after] = [&pair[0], &pair[1]];
            let ways = [1.0, -1.0].map(|share| end(before, share).distance(end(after, -share)));
            assert!(ways[0].min(ways[1]) < 0.05, "{ways:?}");
        }
    }

    #[test]
    fn objects_are_found_within_reach_of_their_boxes() {
        let at = |x: f64, length_m: f64| FixedObject {
            kind: FixedObjectKind::Building,
            pose: Pose::new(dvec2(x, 0.0), 0.0),
            length_m,
            width_m: 10.0,
            height_m: None,
        };
        let objects = FixedObjects::new(vec![at(0.0, 60.0), at(500.0, 10.0)]);
        let near = |x: f64, y: f64| objects.near(dvec2(x, y)).map(|(number, _)| number).collect::<Vec<_>>();
        // The long one ends at x = 30; the reach is 12 m, and squares have sides of 32 m.
        assert_eq!([near(41.0, 0.0), near(-41.0, 8.0), near(495.0, 3.0)], [vec![0], vec![0], vec![1]]);
        assert!(near(43.0, 0.0).is_empty() && near(0.0, 18.0).is_empty());
    }
}
