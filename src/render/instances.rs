//! Visible vehicles and trees: culled on the CPU, written into one instance buffer per pass. In: a view and a
//! visibility test. Out: [`InstanceBatches`], ranges of instances by mesh.

use super::{
    device::{
        cost::{CountedPass, CountedQueue},
        layout::Instance,
    },
    level_of_detail::{CarDetail, DetailShares, InstanceBatches, LEVELS, TreeDetail},
    models::{ModelMesh, ModelMeshes},
};
use crate::scene::{CarInstance, Cockpit, DriverSeat, LitLamp, MirroredLamp, SprayPuff, StaticScene, TreePlace};
use glam::{Affine3A, Quat, Vec3};
use std::f32::consts::PI;
use std::ops::Range;

/// Radius of the shade at a tree's foot as a share of the tree's bounding radius, and its maximum distance, m.
const ROOT: f32 = 0.62;
const ROOTS_M: f32 = 90.0;
/// Radius of a sphere that holds a car with its wheels, m.
const REACH_M: f32 = 3.3;
/// Maximum distance of lit lamps, m: a lamp further away is smaller than a pixel.
const LAMPS_M: f32 = 700.0;
/// Maximum distance of lamps that a wet road mirrors, m, and the radius of a sphere that holds the image of one.
const STREAKS_M: f32 = 200.0;
const STREAK_REACH_M: f32 = 8.0;
/// Smallest scale of a wheel, which is that of a vehicle; the models of people on foot have none that is seen.
const SMALLEST_WHEEL: f32 = 0.1;
/// Radius that stands for a car when its detail is chosen, m: near up to about 20 m in a picture of 1280 pixels.
const DETAIL_M: f32 = 1.9;

/// Visibility data of a tree or tuft; separate from the drawing data, because every picture tests all of them.
#[derive(Clone, Copy, Debug)]
struct BoundingSphere {
    centre: Vec3,
    radius_m: f32,
    kind: u32,
    /// True on the horizon: drawn without a shadow.
    distant: bool,
}

/// Drawing data of a tree or tuft.
#[derive(Clone, Copy, Debug)]
struct DrawnTree {
    instance: Instance,
    /// Patch of shade at a tree's foot.
    root: Option<Instance>,
}

/// A tree or tuft, prepared once.
#[derive(Clone, Copy, Debug)]
struct PlacedTree(BoundingSphere, DrawnTree);

impl PlacedTree {
    fn new(place: &TreePlace, model: &ModelMesh, distant: bool) -> Self {
        let turn = Quat::from_rotation_z(place.yaw_rad);
        let world = Affine3A::from_scale_rotation_translation(Vec3::splat(place.scale), turn, place.position);
        let (centre, radius_m) = (world.transform_point3(model.centre), model.radius_m * place.scale);
        let ball = BoundingSphere { centre, radius_m, kind: place.kind as u32, distant };
        Self(ball, DrawnTree { instance: Instance::new(world, place.tint, 1.0), root: None })
    }

    /// Adds the shade on the ground with this normal.
    fn rooted(self, ground: Vec3) -> Self {
        let turn = Quat::from_rotation_arc(Vec3::Z, ground);
        let Self(ball, drawn) = self;
        let foot = drawn.instance.origin() + 0.08 * ground;
        let reach = Vec3::splat(ROOT * ball.radius_m);
        let world = Affine3A::from_scale_rotation_translation(reach, turn, foot);
        Self(ball, DrawnTree { root: Some(Instance::new(world, [0.0; 3], 1.0)), ..drawn })
    }
}

/// Trees and tufts of grass, placed once.
#[derive(Clone, Debug)]
pub struct PlacedTrees {
    kinds: usize,
    /// Visibility and drawing data, of the same length and in the same order.
    trees: (Vec<BoundingSphere>, Vec<DrawnTree>),
    tufts: (Vec<BoundingSphere>, Vec<DrawnTree>),
}

impl PlacedTrees {
    /// Places all trees and tufts of a static scene.
    pub fn new(static_scene: &StaticScene, models: &ModelMeshes) -> Self {
        let grown =
            |distant: bool| move |place: &TreePlace| PlacedTree::new(place, &models.trees[place.kind][0], distant);
        let near = static_scene.tree_places.iter().map(grown(false));
        let near = near.zip(&static_scene.tree_grounds).map(|(tree, ground)| tree.rooted(*ground));
        let parts = |PlacedTree(ball, drawn)| (ball, drawn);
        let trees = near.chain(static_scene.far_tree_places.iter().map(grown(true))).map(parts).unzip();
        let tufts =
            static_scene.tuft_places.iter().map(|place| PlacedTree::new(place, &models.tuft, false)).map(parts).unzip();
        Self { kinds: models.trees.len(), trees, tufts }
    }

    fn count(&self) -> usize {
        self.trees.0.len() + self.tufts.0.len()
    }
}

/// Contents of a picture besides the other vehicles' bodies.
#[derive(Clone, Copy, Debug, Default)]
pub struct SceneContents<'a> {
    /// Trees and tufts of grass.
    pub forest: Option<&'a PlacedTrees>,
    /// The ego, seen from inside.
    pub inside: Option<&'a DriverSeat>,
    /// Lamps that are lit.
    pub lamps: &'a [LitLamp],
    /// Lamps that a wet road mirrors.
    pub mirrored_lamps: &'a [MirroredLamp],
    /// Fine drops in the air behind vehicles.
    pub spray: &'a [SprayPuff],
}

/// Choice of the objects that a pass draws, and of their detail. Places and radii are metres.
pub trait Visibility {
    /// Returns the place from which distances count.
    fn eye(&self) -> Vec3;

    /// Checks whether any part of a sphere may be seen.
    fn sees(&self, centre: Vec3, radius_m: f32) -> bool;

    /// Returns the detail of a car that may be seen, by a smaller sphere that stands for its size; `None` if that is outside the picture.
    fn car_detail(&self, centre: Vec3, radius_m: f32) -> Option<CarDetail>;

    /// Returns the levels of a tree, none if it is not seen.
    fn tree_levels(&self, centre: Vec3, radius_m: f32) -> DetailShares;

    /// Checks whether a tuft of grass is drawn.
    fn shows_grass(&self, centre: Vec3, radius_m: f32) -> bool;
}

/// Instance buffer that is refilled for every picture. It grows when a picture holds more than any before it.
#[derive(Debug)]
pub struct InstanceCollector {
    buffer: wgpu::Buffer,
    instances: Vec<Instance>,
    /// Trees in the picture: kind and level, squared distance, index, share.
    found: Vec<(usize, f32, u32, f32)>,
}

impl InstanceCollector {
    /// Creates a buffer for all trees and for `cars` cars.
    pub fn new(device: &wgpu::Device, forest: &PlacedTrees, cars: usize) -> Self {
        // A tree between two levels is drawn twice.
        let capacity = 1 + 5 * cars + 3 * forest.count();
        Self {
            buffer: instance_buffer(device, capacity),
            instances: Vec::with_capacity(capacity),
            found: Vec::with_capacity(2 * forest.trees.0.len()),
        }
    }

    /// Collects the visible objects and writes them to the device, the trees nearest to the eye first.
    pub fn gather<'a>(
        &mut self,
        (device, queue): (&wgpu::Device, &CountedQueue),
        models: &ModelMeshes,
        cars: impl Iterator<Item = &'a CarInstance>,
        around: SceneContents,
        visible: &impl Visibility,
    ) -> InstanceBatches {
        self.instances.clear();
        self.instances.push(Instance::new(Affine3A::IDENTITY, [1.0; 3], 0.0));
        let eye = visible.eye();
        // A full town has a thousand vehicles, of which few are in the picture.
        let cars: Vec<(&CarInstance, CarDetail)> = cars
            .filter_map(|car| {
                let size = car.scale.max_element();
                let detail = || visible.car_detail(car.position, DETAIL_M * size).unwrap_or(CarDetail::Far);
                visible.sees(car.position, REACH_M * size).then(|| (car, detail()))
            })
            .collect();
        let at = |level: usize| cars.iter().filter(move |(_, of)| *of as usize == level).map(|(car, _)| *car);
        let seat = around.inside;
        let cabin = seat.filter(|seat| seat.steering_wheel_rad.is_some());
        let inside = [
            self.fill(|list| list.extend(seat.map(|seat| body(&seat.car)))),
            self.fill(|list| list.extend(cabin.map(|seat| body(&seat.car)))),
            self.fill(|list| list.extend(seat.and_then(steering_wheel))),
            self.fill(|list| list.extend(seat.filter(|seat| seat.wiper_rad.is_none()).map(|seat| body(&seat.car)))),
            self.fill(|list| list.extend(seat.into_iter().flat_map(moving_wipers))),
        ];
        let housings = std::array::from_fn(|which| self.fill(|list| list.extend(housings(seat, which))));
        let first = self.instances.len() as u32;
        let bodies: Vec<_> = (0..models.bodies.len())
            .map(|style| {
                let of = |car: &&CarInstance| car.style == style;
                std::array::from_fn(|level| self.fill(|list| list.extend(at(level).filter(of).map(body))))
            })
            .collect();
        let all = first..self.instances.len() as u32;
        let [near, mid, far, shade] =
            [CarDetail::Near, CarDetail::Mid, CarDetail::Far, CarDetail::Shade].map(|level| at(level as usize));
        let wheels = [
            self.fill(|list| list.extend(near.flat_map(wheels))),
            self.fill(|list| list.extend(mid.flat_map(wheels))),
            self.fill(|list| list.extend(far.chain(shade).flat_map(wheels))),
        ];
        let faces = |lamp: &LitLamp, most_m: f32| {
            // A lamp that faces away has no visible face.
            let way = eye - lamp.position;
            way.length_squared() < most_m * most_m && way.dot(lamp.facing) > 0.0
        };
        let lit = around.lamps.iter();
        let lit = lit.filter(|lamp| faces(lamp, LAMPS_M) && visible.sees(lamp.position, lamp.radius_m));
        let lamps = self.fill(|list| list.extend(lit.map(lit_lamp)));
        // Their images are below the road, and longer than high.
        let mirrored = around.mirrored_lamps.iter().filter(|at| {
            let image = at.lamp.position - Vec3::Z * (2.0 * at.height_m);
            faces(&at.lamp, STREAKS_M)
                && visible.sees(image, STREAK_REACH_M)
                && !cars.iter().any(|(car, _)| at.is_hidden_by(car, eye))
        });
        let streaks = self.fill(|list| list.extend(mirrored.map(streak)));
        let puffs = around.spray.iter().filter(|puff| visible.sees(puff.position, puff.radius_m));
        let spray = self.fill(|list| list.extend(puffs.map(spray_puff)));
        let tufts = around.forest.iter().flat_map(|forest| forest.tufts.0.iter().zip(&forest.tufts.1));
        let wanted = |(tuft, _): &(&BoundingSphere, &DrawnTree)| visible.shows_grass(tuft.centre, tuft.radius_m);
        let tufts = self.fill(|list| list.extend(tufts.filter(wanted).map(|(_, drawn)| drawn.instance)));
        let trees = around.forest.map_or(Vec::new(), |forest| self.trees(forest, visible));
        let roots = self.roots(around.forest, eye);
        if (self.instances.len() * size_of::<Instance>()) as u64 > self.buffer.size() {
            self.buffer = instance_buffer(device, self.instances.len().next_power_of_two());
        }
        queue.write_buffer(&self.buffer, 0, bytemuck::cast_slice(&self.instances));
        InstanceBatches { inside, housings, cars: all, bodies, wheels, lamps, streaks, spray, tufts, roots, trees }
    }

    /// Binds the instances as the source of the pass's draws, in `slot`.
    pub fn bind(&self, pass: &mut CountedPass, slot: u32) {
        pass.set_vertex_buffer(slot, self.buffer.slice(..));
    }

    /// Adds the shade at the feet of the trees found, fainter with distance.
    fn roots(&mut self, forest: Option<&PlacedTrees>, eye: Vec3) -> Range<u32> {
        let start = self.instances.len() as u32;
        for &(_, _, number, share) in forest.iter().flat_map(|_| &self.found) {
            let Some((balls, drawn)) = forest.map(|forest| &forest.trees) else { break };
            // Horizontal distance, because parallel pictures are taken from far above.
            let distance = balls[number as usize].centre.truncate().distance(eye.truncate());
            let strength = (2.0 - 2.0 * distance / ROOTS_M).clamp(0.0, 1.0);
            // A tree between two levels has its shade once, with the finer level.
            if let Some(mut root) = drawn[number as usize].root.filter(|_| share > 0.0 && strength > 0.0) {
                root.colour_brake[3] = strength;
                self.instances.push(root);
            }
        }
        start..self.instances.len() as u32
    }

    /// Adds the trees' instances by kind and level, the nearest first.
    fn trees(&mut self, forest: &PlacedTrees, visible: &impl Visibility) -> Vec<[Range<u32>; LEVELS]> {
        let mut found = std::mem::take(&mut self.found);
        found.clear();
        for (number, tree) in (0..).zip(&forest.trees.0) {
            let levels = visible.tree_levels(tree.centre, tree.radius_m);
            let of = if tree.distant { distant(levels) } else { levels };
            for (detail, share) in of.into_iter().flatten() {
                let bin = tree.kind as usize * LEVELS + detail as usize;
                found.push((bin, tree.centre.distance_squared(visible.eye()), number, share));
            }
        }
        found.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        let first = self.instances.len();
        self.instances.extend(found.iter().map(|&(_, _, number, share)| {
            let mut instance = forest.trees.1[number as usize].instance;
            instance.colour_brake[3] = share;
            instance
        }));
        let end = |bin: usize| (first + found.partition_point(|tree| tree.0 < bin)) as u32;
        let ranges =
            (0..forest.kinds).map(|kind| [0, 1, 2, 3].map(|k| end(kind * LEVELS + k)..end(kind * LEVELS + k + 1)));
        let ranges = ranges.collect();
        self.found = found;
        ranges
    }

    fn fill(&mut self, fill: impl FnOnce(&mut Vec<Instance>)) -> Range<u32> {
        let start = self.instances.len() as u32;
        fill(&mut self.instances);
        start..self.instances.len() as u32
    }
}

/// Returns the levels of a tree on the horizon: its picture, or its boughs where the picture would be enlarged; no
/// shadow.
fn distant(levels: DetailShares) -> DetailShares {
    match levels[0] {
        None | Some((TreeDetail::Shade, _)) => [None; 2],
        Some((TreeDetail::Near, _)) => [Some((TreeDetail::Mid, 1.0)), None],
        Some(_) => levels,
    }
}

fn instance_buffer(device: &wgpu::Device, capacity: usize) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("instances"),
        size: (capacity * size_of::<Instance>()) as u64,
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

fn body(car: &CarInstance) -> Instance {
    // Integer part: the number on the plates, or a person's posture; fraction: half of the lamps' light (`surface.wgsl`).
    let plate_brake = f32::from(car.plate) + 0.5 * car.brake.clamp(0.0, 1.0);
    // Negative: all lamps are dark.
    let plate_brake = if car.is_parked { -plate_brake } else { plate_brake };
    Instance::new(
        Affine3A::from_scale_rotation_translation(car.scale, car.rotation, car.position),
        car.colour,
        plate_brake,
    )
}

/// Returns a lit lamp in its own light.
fn lit_lamp(lamp: &LitLamp) -> Instance {
    let turn = Quat::from_rotation_arc(Vec3::X, lamp.facing);
    let world = Affine3A::from_scale_rotation_translation(Vec3::splat(lamp.radius_m), turn, lamp.position);
    Instance::new(world, lamp.light, 0.0)
}

/// Returns a lamp that a wet road mirrors as its place, radius, light and height over the road.
fn streak(MirroredLamp { lamp, height_m }: &MirroredLamp) -> Instance {
    let world = Affine3A::from_scale_rotation_translation(Vec3::splat(lamp.radius_m), Quat::IDENTITY, lamp.position);
    Instance::new(world, lamp.light, *height_m)
}

/// Returns a puff as its place, radius, height over the road (in the place of its scale along y) and opacity.
fn spray_puff(puff: &SprayPuff) -> Instance {
    let scale = Vec3::new(puff.radius_m, puff.height_m, puff.radius_m);
    let world = Affine3A::from_scale_rotation_translation(scale, Quat::IDENTITY, puff.position);
    Instance::new(world, [1.0; 3], puff.opacity)
}

/// Returns both wipers while they move, as in rain.
fn moving_wipers(seat: &DriverSeat) -> impl Iterator<Item = Instance> {
    let body = Affine3A::from_rotation_translation(seat.car.rotation, seat.car.position);
    let arms = seat.wiper_rad.map(Cockpit::body_from_wipers);
    arms.into_iter().flatten().map(move |arm| Instance::new(body * arm, [1.0; 3], 0.0))
}

/// Returns the steering wheel, if it is visible.
fn steering_wheel(seat: &DriverSeat) -> Option<Instance> {
    let body = Affine3A::from_rotation_translation(seat.car.rotation, seat.car.position);
    seat.steering_wheel_rad.map(|turn| Instance::new(body * Cockpit::body_from_wheel(turn), [1.0; 3], 0.0))
}

/// Returns the mirrors' housings of one mesh, in the order of [`Cockpit::housings`]. The foot of a housing points
/// inwards to the door. A mirror that is turned into the picture has its foot where the picture shows the door: down at
/// the left one, beyond the edge at the right one.
fn housings(seat: Option<&DriverSeat>, which: usize) -> impl Iterator<Item = Instance> {
    let panes = seat.and_then(|seat| Some((seat.car, seat.mirrors?)));
    panes.into_iter().flat_map(move |(car, panes)| {
        let body = Affine3A::from_rotation_translation(car.rotation, car.position);
        let of = [0, if panes[1].at_home { 1 } else { 3 }, if panes[2].at_home { 2 } else { 1 }];
        (0..3)
            .filter(move |&k| of[k] == which)
            .map(move |k| Instance::new(body * panes[k].body_from_glass, car.colour, 0.0))
    })
}

/// Returns the four wheels, none of a person on foot: the front ones steered, the right ones turned about so that their outer side shows, all
/// rolling forwards.
fn wheels(car: &CarInstance) -> impl Iterator<Item = Instance> + '_ {
    let world_from_body = Affine3A::from_rotation_translation(car.rotation, car.position);
    let hubs = if car.wheel_scale.x < SMALLEST_WHEEL { &[] } else { &car.hubs[..] };
    hubs.iter().enumerate().map(move |(i, hub)| {
        let steer = if i < 2 { car.steer_rad } else { 0.0 };
        let (about, roll) = if i % 2 == 0 { (0.0, car.spin_rad) } else { (PI, -car.spin_rad) };
        let turn = Quat::from_rotation_z(steer + about) * Quat::from_rotation_y(roll);
        let wheel = Affine3A::from_scale_rotation_translation(car.wheel_scale, turn, *hub);
        Instance::new(world_from_body * wheel, [1.0; 3], 0.0)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAR: CarInstance = CarInstance {
        position: Vec3::ZERO,
        rotation: Quat::IDENTITY,
        colour: [1.0; 3],
        brake: 0.0,
        scale: Vec3::ONE,
        wheel_scale: Vec3::ONE,
        hubs: [Vec3::ZERO; 4],
        steer_rad: 0.0,
        spin_rad: 0.3,
        style: 0,
        plate: 1234,
        is_parked: false,
        is_ego: false,
    };

    #[test]
    fn wheels_roll_forwards_and_show_their_outer_side() {
        let hubs = [(1.4, 0.8), (1.4, -0.8), (-1.4, 0.8), (-1.4, -0.8)].map(|(x, y)| Vec3::new(x, y, 0.3));
        let car = CarInstance { hubs, ..CAR };
        for (wheel, hub) in wheels(&car).zip(car.hubs) {
            let column = |i: usize| Vec3::from(wheel.rows.map(|row| row[i]));
            assert!((wheel.origin() - hub).length() < 1e-6);
            assert!((column(1).y - hub.y.signum()).abs() < 1e-6, "the outer side is {}", column(1));
            assert!(column(2).x > 0.2, "the top moves forwards: {}", column(2));
        }
        let steered: Vec<_> = wheels(&CarInstance { steer_rad: 0.4, spin_rad: 0.0, ..car }).collect();
        let axle = Vec3::from(steered[0].rows.map(|row| row[1]));
        assert!(axle.x < -0.3, "steering left turns the left wheel's outer side backwards: {axle}");
        assert_eq!(steered[2].rows[0][1], 0.0, "the rear wheels stay");
        assert_eq!(wheels(&CarInstance { wheel_scale: Vec3::splat(0.0125), ..car }).count(), 0, "on foot");
    }

    #[test]
    fn a_parked_car_has_its_number_and_the_sign_of_dark_lamps() {
        let of = |is_parked: bool| {
            let car = CarInstance { is_parked, ..CAR };
            body(&car).colour_brake[3]
        };
        assert_eq!((of(false), of(true)), (1234.0, -1234.0));
    }
}
