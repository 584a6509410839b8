//! Roads that end at the edge of a network. They run on in a bend, behind trees, so that none ends in a meadow. In: a network and its paved
//! surfaces. Out: the same network with longer lanes, for the picture alone. Metres.

use super::road_surfaces::RoadSurfaces;
use crate::map::network::{EdgeId, JunctionId, LaneId, Network};
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;

/// Lateral acceleration in the bend at the speed limit, m/s2; it decides the bend's radius.
const LATERAL_MPS2: f64 = 2.0;
/// Smallest radius of the bend, metres.
const LEAST_RADIUS_M: f64 = 60.0;
/// Angle of the bend, radians: from the old end of the road, the new one is beside the view ahead.
const BEND_RAD: f64 = 1.2;
/// Length over which the bend begins: its curvature grows evenly, metres.
const BEGINS_M: f64 = 30.0;
/// Distance between points of the new line, metres.
const STEP_M: f64 = 4.0;
/// Free width beside the added road: to other roads, and to other added roads, metres.
const CLEAR_M: f64 = 5.0;
const BESIDE_ADDED_M: f64 = 1.0;
/// Least distance between the new end and the network, metres: it leads away from it. A dead end within a town does not.
const AWAY_M: f32 = 50.0;
/// Distance over which a grade at the end of a road levels out, metres.
const LEVELS_M: f64 = 40.0;
/// Cosine of the largest angle between lanes of one end.
const ONE_WAY_ON: f64 = 0.9;

/// Distance of a barrier from the road's end, metres: no car that ends there stands in it.
pub const BARRIER_BEYOND_M: f64 = 0.6;

/// End of a road: all lanes that end or begin at a junction from which no other road leads on.
#[derive(Debug)]
struct RoadEnd {
    /// Lanes, and true for those that end here.
    lanes: Vec<(LaneId, bool)>,
    /// Middle of the lanes' ends.
    middle: DVec2,
    /// Unit direction in which the road would run on.
    outwards: DVec2,
    half_width_m: f64,
    radius_m: f64,
    /// Length of the end's own paved area beyond the lanes, such as that of a turnaround.
    own_m: f64,
}

/// Course of an added road: the points in its middle, every [`STEP_M`], each with the direction there.
type Course = Vec<(DVec2, DVec2)>;

impl RoadEnd {
    /// Returns the end of a road at a junction with these streets, which end there if true; `None` if a road leads on, if they do not end side
    /// by side, or for a path.
    fn of(net: &Network, junction: JunctionId, streets: &[(EdgeId, bool)]) -> Option<Self> {
        let lanes: Vec<(LaneId, bool)> =
            streets.iter().flat_map(|(edge, ends)| net.edge(*edge).lanes().map(|lane| (lane, *ends))).collect();
        let leads_on = |lane: LaneId| net.connections_from(lane).iter().any(|way| !way.is_turnaround());
        let is_road = |lane: LaneId| net.lane(lane).admits_cars() || net.lane(lane).is_railway();
        if lanes.iter().any(|(lane, ends)| *ends && is_road(*lane) && leads_on(*lane))
            || !lanes.iter().any(|(lane, _)| is_road(*lane))
        {
            return None;
        }
        let places = lanes.iter().map(|(lane, ends)| end_of(net, *lane, *ends));
        let ends: Vec<(DVec3, DVec2)> = places.collect();
        let outwards = ends.iter().map(|(_, outwards)| *outwards).sum::<DVec2>().try_normalize()?;
        if ends.iter().any(|(_, own)| own.dot(outwards) < ONE_WAY_ON) {
            return None;
        }
        let middle = ends.iter().map(|(end, _)| end.truncate()).sum::<DVec2>() / ends.len() as f64;
        let aside_m = |end: DVec3| (end.truncate() - middle).dot(outwards.perp()).abs();
        let reach_m =
            |((lane, _), (end, _)): (&(LaneId, bool), &(DVec3, DVec2))| aside_m(*end) + net.lane(*lane).half_width_m();
        let half_width_m = lanes.iter().zip(&ends).map(reach_m).fold(0.0, f64::max);
        let inside = net.lanes().iter().filter(|lane| net.edge(lane.edge).junction == Some(junction));
        let of_lanes = inside.flat_map(|lane| {
            lane.line.points().iter().map(|at| (at.truncate() - middle).dot(outwards) + lane.half_width_m())
        });
        let of_outline = net.junction(junction).shape.iter().map(|at| (at.truncate() - middle).dot(outwards));
        let own_m = of_lanes.chain(of_outline).fold(0.0, f64::max);
        let limit_mps = lanes.iter().map(|(lane, _)| net.lane(*lane).speed_limit_mps).fold(0.0, f64::max);
        let radius_m = (limit_mps * limit_mps / LATERAL_MPS2).max(LEAST_RADIUS_M);
        Some(Self { lanes, middle, outwards, half_width_m, radius_m, own_m })
    }

    /// Returns a whole course: with 1 a bend to the left, with -1 to the right, with 0 straight on.
    fn course(&self, turn: f64) -> Course {
        let length_m = BEND_RAD * self.radius_m + BEGINS_M / 2.0;
        let turned_rad = |along_m: f64| {
            let begun_m = along_m.min(BEGINS_M);
            turn * (begun_m * begun_m / (2.0 * BEGINS_M) + along_m - begun_m) / self.radius_m
        };
        let direction = |along_m: f64| DVec2::from_angle(turned_rad(along_m)).rotate(self.outwards);
        let mut at = self.middle;
        let rows = (1..=(length_m / STEP_M) as usize).map(|k| {
            let along_m = k as f64 * STEP_M;
            at += direction(along_m - STEP_M / 2.0) * STEP_M;
            (at, direction(along_m))
        });
        rows.collect()
    }

    /// Returns the first course that is free of other roads and leads away from the network; `None` if there is none.
    fn free_course(&self, surfaces: &RoadSurfaces, added: &AddedRoads) -> Option<Course> {
        let is_free = |(k, (at, _)): (usize, &(DVec2, DVec2))| {
            // The road's own end is no obstacle.
            let clear_m = (self.half_width_m + CLEAR_M).min(0.85 * STEP_M * (k + 1) as f64 - 2.0 - self.own_m);
            f64::from(surfaces.border_m(at.as_vec2())) >= clear_m && added.leave_room(*at, self.half_width_m)
        };
        let leads_away = |course: &Course| {
            course.last().is_some_and(|(at, _)| surfaces.border_m(at.as_vec2()) >= AWAY_M)
                && course.iter().enumerate().all(is_free)
        };
        [1.0, -1.0, 0.0].into_iter().map(|turn| self.course(turn)).find(leads_away)
    }

    /// Returns the end of a road for cars from which it does not run on; `None` for a path or a railway.
    fn dead(&self, net: &Network) -> Option<DeadEnd> {
        let is_for_cars = |lane: LaneId| net.is_driven(lane) && net.lane(lane).admits_cars();
        self.lanes.iter().any(|(lane, _)| is_for_cars(*lane)).then_some(())?;
        let heights = self.lanes.iter().map(|(lane, ends)| end_of(net, *lane, *ends).0.z);
        // Beyond a turnaround, which is part of the end.
        let middle = (self.middle + self.outwards * self.own_m).extend(heights.fold(f64::NEG_INFINITY, f64::max));
        Some(DeadEnd { middle, outwards: self.outwards, half_width_m: self.half_width_m })
    }

    /// Returns the points that are added to a lane, from its end or its beginning outwards.
    fn added_points(&self, net: &Network, (lane, ends): (LaneId, bool), course: &Course) -> Vec<DVec3> {
        let line = net.lane(lane).line.points();
        let (end, _) = end_of(net, lane, ends);
        let before = if ends { line[line.len() - 2] } else { line[1] };
        let grade = (end.z - before.z) / end.truncate().distance(before.truncate());
        let from_middle = end.truncate() - self.middle;
        let (ahead_m, left_m) = (from_middle.dot(self.outwards), from_middle.dot(self.outwards.perp()));
        let point = |(k, (at, direction)): (usize, &(DVec2, DVec2))| {
            let along_m = STEP_M * (k + 1) as f64;
            let rise_m = grade * LEVELS_M * (1.0 - (-along_m / LEVELS_M).exp());
            (*at + *direction * ahead_m + direction.perp() * left_m).extend(end.z + rise_m)
        };
        course.iter().enumerate().map(point).collect()
    }
}

/// Returns the point at which a lane ends, or begins, and the direction away from the lane there.
fn end_of(net: &Network, lane: LaneId, ends: bool) -> (DVec3, DVec2) {
    let line = &net.lane(lane).line;
    let points = line.points();
    if ends { (points[points.len() - 1], line.end_direction()) } else { (points[0], -line.start_direction()) }
}

/// Points in the middle of the added roads with half their widths, sorted into squares.
#[derive(Debug, Default)]
struct AddedRoads(BTreeMap<[i64; 2], Vec<(DVec2, f64)>>);

impl AddedRoads {
    /// Side of a square, metres. It is wider than two roads, so that roads which meet lie in the same or in neighbouring squares.
    const SIDE_M: f64 = 48.0;

    fn square(at: DVec2) -> [i64; 2] {
        (at / Self::SIDE_M).floor().as_i64vec2().to_array()
    }

    /// Returns true if a road of this half width meets none of them at a place.
    fn leave_room(&self, at: DVec2, half_width_m: f64) -> bool {
        let [x, y] = Self::square(at);
        let squares = (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).map(move |y| [x, y]));
        let mut near = squares.filter_map(|square| self.0.get(&square)).flatten();
        near.all(|(other, half_m)| other.distance(at) >= half_width_m + half_m + BESIDE_ADDED_M)
    }

    fn add(&mut self, course: &Course, half_width_m: f64) {
        for (at, _) in course {
            self.0.entry(Self::square(*at)).or_default().push((*at, half_width_m));
        }
    }
}

/// End of a road from which it does not run on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeadEnd {
    /// Middle of the end, beyond its turnaround if it has one.
    pub middle: DVec3,
    /// Unit direction in which the road would run on.
    pub outwards: DVec2,
    pub half_width_m: f64,
}

/// Returns the network with roads that run on beyond their ends, where there is room, and the other ends of roads for cars; `None` if no road
/// runs on.
pub fn running_on(net: &Network, surfaces: &RoadSurfaces) -> (Option<Network>, Vec<DeadEnd>) {
    let mut streets: BTreeMap<JunctionId, Vec<(EdgeId, bool)>> = BTreeMap::new();
    for id in net.edge_ids().filter(|id| net.edge(*id).kind.is_street()) {
        for (junction, ends) in [(net.edge(id).from, false), (net.edge(id).to, true)] {
            junction.into_iter().for_each(|junction| streets.entry(junction).or_default().push((id, ends)));
        }
    }
    let (mut added, mut lines, mut dead) = (AddedRoads::default(), BTreeMap::new(), Vec::new());
    for end in streets.iter().filter_map(|(junction, streets)| RoadEnd::of(net, *junction, streets)) {
        let Some(course) = end.free_course(surfaces, &added) else {
            dead.extend(end.dead(net));
            continue;
        };
        added.add(&course, end.half_width_m);
        for (lane, ends) in &end.lanes {
            let mut points = end.added_points(net, (*lane, *ends), &course);
            let line = lines.entry(*lane).or_insert_with(|| net.lane(*lane).line.points().to_vec());
            if *ends {
                line.append(&mut points);
            } else {
                line.splice(..0, points.into_iter().rev());
            }
        }
    }
    ((!lines.is_empty()).then(|| net.with_lines(lines)), dead)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(name: &str) -> Network {
        Network::load(name).unwrap_or_else(|fault| panic!("{fault}"))
    }

    #[test]
    fn a_road_with_pavements_runs_on_with_them() {
        let net = load("town");
        let longer = running_on(&net, &RoadSurfaces::of(&net)).0.expect("the town has ends");
        // The pavement and the lane on which the path begins, at the southern edge of the town.
        for id in ["K-K1_0", "K-K1_1"] {
            let lane = net.lane_ids().find(|lane| net.lane(*lane).id == id).expect(id);
            let added_m = longer.lane(lane).line.drawn_m() - net.lane(lane).line.drawn_m();
            // A bend of 1.2 rad with a radius of at least 60 m.
            assert!(added_m > 70.0, "{id} has {added_m} m more");
        }
    }

    #[test]
    fn all_roads_of_the_grid_run_on_and_keep_clear_of_other_roads() {
        let net = load("grid");
        let longer = running_on(&net, &RoadSurfaces::of(&net)).0.expect("the grid has ends");
        let is_longer = |lane: &LaneId| longer.lane(*lane).line != net.lane(*lane).line;
        let lanes: Vec<LaneId> = net.lane_ids().filter(is_longer).collect();
        // A lane in and a lane out at each of three ends of four sides.
        assert_eq!(lanes.len(), 24);
        for lane in &lanes {
            let (old, new) = (net.lane(*lane), longer.lane(*lane));
            // A bend of 1.2 rad with a radius of 13.9^2 / 2 m and 15 m more, as it begins over 30 m, in steps of 4 m; lanes are up to 3 m
            // beside its middle.
            let added_m = new.line.drawn_m() - old.line.drawn_m();
            assert!((added_m - 128.0).abs() < 4.0, "{} has {added_m} m more", old.id);
            let declared = [old, new].map(|lane| lane.length_m / lane.line.drawn_m());
            assert!((declared[0] - declared[1]).abs() < 1e-9, "{}: {declared:?}", old.id);
            let [from, to] = [old.line.end_direction(), new.line.end_direction()];
            let [begins, began] = [old.line.start_direction(), new.line.start_direction()];
            let turn_rad = from.angle_to(to).abs().max(begins.angle_to(began).abs());
            assert!((turn_rad - 1.18).abs() < 0.05, "{} turns by {turn_rad}", old.id);
        }
        // Each point that was added lies clear of all roads that were there.
        let surfaces = RoadSurfaces::of(&net);
        for lane in &lanes {
            let old = net.lane(*lane).line.points();
            let added = longer.lane(*lane).line.points().iter().filter(|point| !old.contains(point));
            let far = added.filter(|point| old.iter().all(|own| own.distance(**point) > 12.0));
            far.for_each(|point| assert!(surfaces.border_m(point.truncate().as_vec2()) > 5.0, "{point}"));
        }
    }

    #[test]
    fn a_road_whose_end_has_a_turnaround_runs_on() {
        // Two streets between two dead ends, each with a turnaround that reaches 4 m beyond it.
        let street = |id: &str, [from, to]: [&str; 2], shape: &str| {
            format!(
                "<edge id=\"{id}\" from=\"{from}\" to=\"{to}\"><lane id=\"{id}_0\" index=\"0\" speed=\"14\" length=\"200\" shape=\"{shape}\"/></edge>"
            )
        };
        let node = |id: &str, x: f64, outline: &str| {
            format!(
                "<junction id=\"{id}\" type=\"dead_end\" x=\"{x}\" y=\"0\" incLanes=\"\" intLanes=\"\" shape=\"{outline}\"/>"
            )
        };
        let text = [
            "<net version=\"1.20\">".to_owned(),
            street("there", ["a", "b"], "0,-1.6 200,-1.6"),
            street("back", ["b", "a"], "200,1.6 0,1.6"),
            node("a", 0.0, "0,3.2 0,-3.2 -4,0"),
            node("b", 200.0, "200,-3.2 200,3.2 204,0"),
            "</net>".to_owned(),
        ];
        let net = Network::read(std::path::Path::new("t.net.xml"), &text.concat()).expect("a network");
        let (longer, dead) = running_on(&net, &RoadSurfaces::of(&net));
        let longer = longer.expect("both ends run on");
        assert!(longer.lanes().iter().all(|lane| lane.line.drawn_m() > 300.0), "by at least 60 m at either end");
        assert!(dead.is_empty(), "{dead:?}");
    }

    #[test]
    fn a_road_without_an_end_stays_as_it_is() {
        for name in ["ring-250", "figure-eight"] {
            let net = load(name);
            assert!(running_on(&net, &RoadSurfaces::of(&net)).0.is_none(), "{name}");
        }
    }

    #[test]
    fn added_roads_are_no_steeper_than_the_road_that_ends() {
        let net = load("tests/data/networks/hill.net.xml");
        let longer = running_on(&net, &RoadSurfaces::of(&net)).0.expect("the road through the tunnel has ends");
        let steepest = |line: &[DVec3]| {
            let grade = |pair: &[DVec3]| (pair[1].z - pair[0].z) / pair[0].truncate().distance(pair[1].truncate());
            line.windows(2).map(|pair| grade(pair).abs()).fold(0.0, f64::max)
        };
        for (old, new) in net.lanes().iter().zip(longer.lanes()) {
            let [was, is] = [old, new].map(|lane| steepest(lane.line.points()));
            assert!(is <= was + 1e-6, "{}: a grade of {is} instead of {was}", old.id);
        }
    }
}
