//! Picture of a snapshot: the poses of all cars between two ticks, the lit lamps and the colours. In: a [`Snapshot`], the clock's
//! fraction, options. Out: a [`View`] whose `dial` the caller fills in.

use super::{
    CarInstance, DriverSeat, LitLamp, SignalHead, StaticScene, View, ViewKind, ViewOptions, WiperMotion,
    camera::{birdseye_camera, chase_camera, driver_camera, driver_look, mirror_camera},
    car::number_plate,
    cockpit::mirrors,
    headlamps::headlamps,
    mirrored_lamps::mirrored_lamps,
    network::visible_part,
    spray::spray,
    traffic_parts::traffic_parts,
    vehicle_lamps::vehicle_lamps,
};
use crate::map::network::SignalStates;
use crate::space::wrap_angle;
use crate::traffic::EGO;
use crate::{controls::STEERING_RATIO, ego::EgoState};
use crate::{scenario::CockpitView, sim::Snapshot, snapshot::TaskPicture};
use glam::{Affine3A, DVec3, EulerRot, Quat, Vec3};

/// Period after which the wind's time starts again at 0, seconds: ten hours. Single precision has steps of 4 ms there; after
/// days, leaves would move in jerks.
const WIND_S: f64 = 36_000.0;

/// Returns the picture at `fraction` (0..1) of the interval from the tick before the snapshot to the snapshot.
pub fn view(
    snapshot: &Snapshot,
    fraction: f32,
    kind: ViewKind,
    options: &ViewOptions,
    static_scene: &StaticScene,
) -> View {
    let changed = snapshot.weather.map(|weather| options.in_weather(&weather));
    let options = changed.as_ref().unwrap_or(options);
    let before_s = (1.0 - f64::from(fraction)) * crate::time::TICK_S;
    let now_s = (snapshot.tick.seconds() - before_s).max(0.0);
    let ego = EgoAt::new(snapshot, fraction, static_scene.origin);
    let mut cars = vec![ego.instance(options.paint(EGO, kind))];
    for car in &snapshot.cars {
        cars.extend(traffic_parts(car, fraction, options.paint(car.id, kind), ego.position, static_scene));
    }
    let full = options.cockpit == CockpitView::Full;
    let seat = (options.cockpit != CockpitView::Off && kind == ViewKind::Driver).then(|| {
        let rotation = ego.steadied(options.body_motion);
        let body = Affine3A::from_rotation_translation(rotation, ego.position);
        DriverSeat {
            car: CarInstance { rotation, ..cars[0] },
            look: driver_look(options),
            steering_wheel_rad: full.then_some(ego.steering_wheel_rad),
            wiper_rad: WiperMotion::in_rain(options.rain_mmph).map(|wipers| wipers.angle_rad(now_s)),
            mirrors: full.then(|| mirrors::panes(body, mirror_camera(&ego, options), options)),
        }
    });
    let camera = match kind {
        ViewKind::Driver => driver_camera(&ego, options),
        ViewKind::Mirror => mirror_camera(&ego, options),
        ViewKind::Birdseye => birdseye_camera((!snapshot.is_without_ego).then_some(&ego), options, static_scene),
        ViewKind::Chase => chase_camera(&ego, snapshot.ego.yaw_rate as f32, static_scene),
    };
    let mut lamps = signal_lamps(snapshot, camera.eye, now_s, static_scene);
    lamps.extend(vehicle_lamps(snapshot, &cars, kind, now_s, options, static_scene));
    View {
        kind,
        camera,
        mirror: (kind == ViewKind::Driver).then(|| mirror_camera(&ego, options)),
        mirrored_lamps: mirrored_lamps(snapshot, &cars, &lamps, camera.eye, options, static_scene),
        lamps,
        headlamps: if options.headlamps_lit() { headlamps(snapshot, &cars, static_scene) } else { vec![] },
        spray: spray(snapshot, &cars, options.rain_mmph, now_s),
        cars,
        route_line: visible_part(&static_scene.route_line, snapshot.ego_s_m),
        seat,
        to_sun: options.to_sun(),
        visibility_m: options.sight_m(),
        rain_mmph: options.rain_mmph,
        velocity_mps: if kind == ViewKind::Birdseye { Vec3::ZERO } else { snapshot.ego.velocity },
        wind_mps: options.wind_mps,
        time_s: (now_s % WIND_S) as f32,
        dial: None,
        palette: options.palette,
        patch: None,
        task: if kind.has_dial() { snapshot.task.shown } else { TaskPicture::None },
        mirror_bend: options.mirror.bend(options.eye),
    }
}

/// State of the ego between two ticks.
pub(super) struct EgoAt {
    pub(super) position: Vec3,
    rotation: Quat,
    pub(super) yaw_rad: f32,
    hubs: [Vec3; 4],
    steering_wheel_rad: f32,
    spin_rad: f32,
    braking: bool,
}

impl EgoAt {
    fn new(snapshot: &Snapshot, fraction: f32, origin: DVec3) -> Self {
        let (a, b): (&EgoState, &EgoState) = (&snapshot.ego_before, &snapshot.ego);
        let mix = |a: f32, b: f32| a + (b - a) * fraction;
        // A rolled angle may be wrapped to one turn, so the shorter direction is the one rolled in a tick.
        let spin = |i: usize| {
            let turn = wrap_angle(f64::from(b.wheels[i].spin_rad) - f64::from(a.wheels[i].spin_rad)) as f32;
            a.wheels[i].spin_rad + turn * fraction
        };
        let rotation = a.rotation.slerp(b.rotation, fraction);
        let forward = rotation * Vec3::X;
        Self {
            position: (a.position.lerp(b.position, f64::from(fraction)) - origin).as_vec3(),
            rotation,
            yaw_rad: forward.y.atan2(forward.x),
            hubs: std::array::from_fn(|i| a.wheels[i].hub.lerp(b.wheels[i].hub, fraction)),
            steering_wheel_rad: mix(a.steering_wheel_rad, b.steering_wheel_rad),
            // A rear wheel, because it rolls with the road whatever the brakes of the front axle do.
            spin_rad: spin(2),
            braking: b.braking,
        }
    }

    fn instance(&self, colour: [f32; 3]) -> CarInstance {
        CarInstance {
            position: self.position,
            rotation: self.rotation,
            colour,
            brake: f32::from(u8::from(self.braking)),
            scale: Vec3::ONE,
            hubs: self.hubs,
            wheel_scale: Vec3::ONE,
            steer_rad: self.steering_wheel_rad / STEERING_RATIO,
            spin_rad: self.spin_rad,
            style: 0,
            plate: number_plate::number(EGO.0),
            is_parked: false,
            is_ego: true,
        }
    }

    /// Returns the body's rotation with only `share` of its pitch and roll.
    pub(super) fn steadied(&self, share: f32) -> Quat {
        let (yaw, pitch, roll) = self.rotation.to_euler(EulerRot::ZYX);
        Quat::from_euler(EulerRot::ZYX, yaw, pitch * share, roll * share)
    }
}

/// Returns the lit lamps of signals. Without signal states, as in a picture without a drive, they follow their first programs.
fn signal_lamps(snapshot: &Snapshot, eye: Vec3, now_s: f64, static_scene: &StaticScene) -> Vec<LitLamp> {
    let mut lamps = Vec::new();
    if !static_scene.signal_heads.is_empty() {
        let known = static_scene.signal_heads.iter().any(|head| !snapshot.signals.letters(head.signal).is_empty());
        let by_program;
        let states = if known {
            &snapshot.signals
        } else {
            by_program = SignalStates::by_first_program(&static_scene.network, now_s);
            &by_program
        };
        let seen = |head: &SignalHead| head.seen_from(eye);
        lamps.extend(static_scene.signal_heads.iter().filter_map(seen).flat_map(|head| head.lit(states, now_s)));
    }
    lamps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::RoadMap;
    use crate::scene::Camera;
    use crate::scene::car::materials::WHEEL_RADIUS_M;
    use crate::scene::static_scene::tests::{circuit, ring};
    use crate::sim::VehicleSnapshot;
    use crate::space::CAR_LENGTH_M;
    use crate::space::Pose;
    use crate::time::Tick;
    use crate::traffic::{VehicleId, VehicleLamps};
    use glam::Vec2;

    const ASPECT: f32 = 16.0 / 9.0;

    /// Returns a snapshot of the ego with its front bumper at `s_m`, and of cars at distances `ahead_m` from it (front bumper to
    /// front bumper).
    fn snapshot(map: &RoadMap, s_m: f64, ahead_m: &[f64]) -> Snapshot {
        let ego = |s_m: f64| {
            let pose = map.route.pose_of_front(s_m, CAR_LENGTH_M);
            let rotation = Quat::from_rotation_z(pose.yaw_rad as f32);
            let mut ego = EgoState { position: pose.position.extend(0.0), rotation, ..EgoState::default() };
            for (wheel, hub) in ego.wheels.iter_mut().zip(crate::scene::car::hubs()) {
                wheel.hub = hub;
                wheel.spin_rad = (s_m / f64::from(WHEEL_RADIUS_M)) as f32;
            }
            ego
        };
        let car = |(k, ahead_m): (usize, &f64)| VehicleSnapshot {
            id: VehicleId(k as u32 + 1),
            pose: map.route.pose_of_front(s_m + ahead_m, CAR_LENGTH_M),
            pose_before: map.route.pose_of_front(s_m + ahead_m - 0.1, CAR_LENGTH_M),
            s_m: Some(s_m + ahead_m),
            speed_mps: 10.0,
            accel_mps2: 0.0,
            odometer_m: 100.0,
            lamps: VehicleLamps { brake: k == 0, ..VehicleLamps::default() },
            ..VehicleSnapshot::default()
        };
        Snapshot {
            tick: Tick(200),
            ego: ego(s_m),
            ego_before: ego(s_m - 0.1),
            ego_s_m: s_m,
            lane_offset_m: 0.0,
            cars: ahead_m.iter().enumerate().map(car).collect(),
            mean_speed_mps: 10.0,
            ..Snapshot::default()
        }
    }

    fn see(map: &RoadMap, snapshot: &Snapshot, fraction: f32, kind: ViewKind) -> View {
        view(snapshot, fraction, kind, &ViewOptions::default(), &StaticScene::with_trees(map, 1, 0))
    }

    #[test]
    fn a_frame_interpolates_between_ticks_and_equals_them_at_its_ends() {
        let map = ring(250.0);
        let snapshot = snapshot(&map, 50.0, &[20.0]);
        let at = |fraction| see(&map, &snapshot, fraction, ViewKind::Driver);
        let (start, half, end) = (at(0.0), at(0.5), at(1.0));
        assert!(start.cars[0].position.distance(snapshot.ego_before.position.as_vec3()) < 1e-6);
        assert!(end.cars[0].position.distance(snapshot.ego.position.as_vec3()) < 1e-6);
        assert!(end.cars[0].rotation.angle_between(snapshot.ego.rotation) < 1e-3);
        assert!(end.cars[1].position.truncate().distance(snapshot.cars[0].pose.position.as_vec2()) < 1e-5);
        assert!(start.cars[1].position.truncate().distance(snapshot.cars[0].pose_before.position.as_vec2()) < 1e-5);
        for k in 0..2 {
            let middle = (start.cars[k].position + end.cars[k].position) / 2.0;
            assert!(half.cars[k].position.distance(middle) < 1e-4);
        }
        assert_eq!((start.time_s, end.time_s), (1.99, 2.0));
        // After a week, too, frames differ by the time between them.
        let late = Snapshot { tick: Tick::at_seconds(604_000.0), ..snapshot.clone() };
        let [start, end] = [0.0, 1.0].map(|fraction| see(&map, &late, fraction, ViewKind::Driver).time_s);
        assert!((end - start - 0.01).abs() < 0.004, "{start} to {end}");
    }

    #[test]
    fn wheels_roll_with_the_distance_and_steer_with_the_bend() {
        let map = ring(250.0);
        let snapshot = snapshot(&map, 50.0, &[20.0]);
        let at = |fraction| see(&map, &snapshot, fraction, ViewKind::Chase).cars;
        let (start, end) = (at(0.0), at(1.0));
        for k in 0..2 {
            let rolled = wrap_angle(f64::from(end[k].spin_rad - start[k].spin_rad)) as f32;
            assert!((rolled * WHEEL_RADIUS_M - 0.1).abs() < 1e-3, "{rolled}");
        }
        // r = 39.8 m to the left: 2.8 / 39.8 rad.
        assert!((end[1].steer_rad - 0.0703).abs() < 0.001, "{}", end[1].steer_rad);
        assert_eq!((end[1].brake, end[0].brake), (1.0, 0.0));
    }

    #[test]
    fn the_steering_wheel_shows_the_commanded_angle() {
        use crate::{
            controls::Controls,
            ego::{CarParams, EgoCar, GroundModel, GroundSurface},
        };
        struct Flat;
        impl GroundModel for Flat {
            fn surface(&self, _: glam::DVec2) -> GroundSurface {
                GroundSurface::Asphalt
            }
        }
        let map = ring(250.0);
        let static_scene = StaticScene::with_trees(&map, 1, 0);
        for degrees in [0.0f32, -90.0, 180.0, 360.0, 450.0] {
            let mut car = EgoCar::new(&CarParams::default(), Pose::default(), 0.0, 0).expect("a car");
            let controls = Controls { steering_wheel_rad: degrees.to_radians(), ..Controls::default() };
            car.tick(&controls, &Flat, &[]);
            let snapshot = Snapshot { ego: *car.state(), ego_before: *car.state(), ..snapshot(&map, 50.0, &[]) };
            let options = ViewOptions { cockpit: CockpitView::Full, ..ViewOptions::default() };
            let seat = view(&snapshot, 1.0, ViewKind::Driver, &options, &static_scene).seat.expect("a seat");
            let shown = seat.steering_wheel_rad.expect("a wheel").to_degrees();
            assert!((shown - degrees).abs() < 0.01, "{shown} for {degrees}");
        }
    }

    #[test]
    fn the_leader_is_drawn_at_its_gap_and_grows_as_the_gap_shrinks() {
        let map = circuit();
        let mut width_before = 0.0;
        for gap_m in [60.0, 30.0, 10.0, 5.0, 2.0] {
            // On the first straight, which begins after the bend of 188.5 m.
            let view = see(&map, &snapshot(&map, 250.0, &[gap_m + CAR_LENGTH_M]), 1.0, ViewKind::Driver);
            let leader = view.cars[1];
            let at = |y: f32, z: f32| {
                let corner = leader.position + leader.rotation * Vec3::new(-2.5, y, z);
                view.camera.project(corner, ASPECT).expect("in front")
            };
            // From the eye, 0.10 m before the middle and 0.36 m left of it, at 1.18 m.
            let distance = gap_m as f32 + 2.5 - 0.10;
            let screen = 2.0 * (ViewOptions::default().fov_x_rad() / 2.0).tan() * distance;
            for y in [-0.9, 0.9] {
                assert!((at(y, 1.0).x - (0.5 - (y - 0.36) / screen)).abs() < 2e-4, "{gap_m} m: {}", at(y, 1.0));
            }
            assert!((at(0.0, 0.5).y - (0.5 + (1.18 - 0.5) * ASPECT / screen)).abs() < 2e-4);
            let width = at(-0.9, 1.0).x - at(0.9, 1.0).x;
            assert!(width > width_before);
            width_before = width;
        }
    }

    #[test]
    fn only_the_drivers_view_has_a_mirror_and_it_looks_back() {
        let map = circuit();
        let snapshot = snapshot(&map, 250.0, &[-15.0, 15.0]);
        for kind in [ViewKind::Mirror, ViewKind::Birdseye, ViewKind::Chase] {
            assert_eq!(see(&map, &snapshot, 1.0, kind).mirror, None);
        }
        let view = see(&map, &snapshot, 1.0, ViewKind::Driver);
        let mirror = view.mirror.expect("a mirror");
        assert_eq!(mirror, see(&map, &snapshot, 1.0, ViewKind::Mirror).camera);
        let (behind, ahead) = (view.cars[1].position + Vec3::Z, view.cars[2].position + Vec3::Z);
        assert!(mirror.project(ahead, 4.0).is_none() && view.camera.project(behind, ASPECT).is_none());
        let found = mirror.project(behind, 4.0).expect("seen in the mirror");
        assert!((found.x - 0.5).abs() < 1e-3 && (0.3..0.7).contains(&found.y), "{found}");
        // In the unflipped picture an object on the ego's left behind is on the right; the renderer's flip puts it left.
        let left = view.cars[0].rotation * Vec3::Y;
        assert!(mirror.project(behind + left, 4.0).expect("seen").x > 0.55);
    }

    #[test]
    fn the_drivers_camera_follows_only_a_share_of_pitch_and_roll() {
        let map = circuit();
        let mut snapshot = snapshot(&map, 250.0, &[]);
        let level = see(&map, &snapshot, 1.0, ViewKind::Driver).camera;
        let (pitch, roll) = (0.04, 0.03);
        let tilt = Quat::from_rotation_y(pitch) * Quat::from_rotation_x(roll);
        snapshot.ego.rotation *= tilt;
        let tilted = see(&map, &snapshot, 1.0, ViewKind::Driver).camera;
        let share = ViewOptions::default().body_motion;
        assert!((level.forward.angle_between(tilted.forward) - share * pitch).abs() < 1e-3);
        assert!((tilted.forward.z + share * pitch).abs() < 1e-3, "nose down is a look down");
        let yaw = |camera: &Camera| camera.forward.y.atan2(camera.forward.x);
        assert!((yaw(&level) - yaw(&tilted)).abs() < 1e-4);
    }

    #[test]
    fn the_birds_eye_view_shows_the_whole_route_with_north_up() {
        for map in [ring(250.0), circuit()] {
            let static_scene = StaticScene::with_trees(&map, 1, 0);
            let snapshot = snapshot(&map, 50.0, &[20.0]);
            let camera = see(&map, &snapshot, 1.0, ViewKind::Birdseye).camera;
            for aspect in [0.6, 1.0, ASPECT] {
                for k in 0..100 {
                    let s_m = map.route.length_m() * f64::from(k) / 100.0;
                    let p = camera.project(map.route.point_at(s_m).as_vec2().extend(0.0), aspect).expect("below");
                    assert!(p.min_element() > 0.01 && p.max_element() < 0.99, "{p}");
                }
                let at = |d: Vec2| camera.project((static_scene.centre + d * 10.0).extend(0.0), aspect).expect("below");
                assert!(at(Vec2::Y).y < at(Vec2::ZERO).y && at(Vec2::X).x > at(Vec2::ZERO).x);
            }
            let options = ViewOptions { birdseye_follow_m: Some(30.0), ..ViewOptions::default() };
            let followed = view(&snapshot, 1.0, ViewKind::Birdseye, &options, &static_scene);
            let middle = followed.camera.project(followed.cars[0].position, ASPECT).expect("below");
            assert!(middle.distance(Vec2::splat(0.5)) < 1e-4);
        }
    }

    #[test]
    fn the_birds_eye_view_follows_the_ego_through_a_wide_scene() {
        let map = ring(3000.0);
        let [here, there] = [50.0, 1500.0].map(|s_m| see(&map, &snapshot(&map, s_m, &[20.0]), 1.0, ViewKind::Birdseye));
        for view in [here, there] {
            let seen = |car: usize| view.camera.project(view.cars[car].position, ASPECT).expect("below");
            assert!(seen(0).distance(Vec2::splat(0.5)) < 1e-4, "{}", seen(0));
            // 20 m of the 200 m that the picture is high.
            let apart = (seen(1) - seen(0)) * Vec2::new(ASPECT, 1.0);
            assert!((apart.length() - 0.1).abs() < 0.005, "{apart}");
        }
    }

    #[test]
    fn a_car_has_twelve_of_720_lines_in_the_birds_eye_view_of_streets() {
        let of_tests = ["grid-signals", "town", "random-3", "random-8", "spider", "roundabout", "ramps", "crossing"];
        let of_tests = of_tests.map(|name| format!("tests/data/networks/{name}.net.xml"));
        let shipped = ["town", "figure-eight", "merge", "bottleneck", "grid"].map(str::to_owned);
        for name in of_tests.iter().chain(&shipped) {
            let network = crate::map::network::Network::load(name).expect("a network");
            let static_scene = StaticScene::of_network(&network.into(), 1, 0);
            let ego = EgoAt::new(&snapshot(&ring(250.0), 50.0, &[]), 1.0, static_scene.origin);
            let camera = birdseye_camera(Some(&ego), &ViewOptions::default(), &static_scene);
            let crate::scene::Lens::Parallel { half_extent_m } = camera.lens else { panic!("a parallel lens") };
            let lines = 720.0 * crate::space::CAR_LENGTH_M as f32 / (2.0 * half_extent_m);
            assert!(lines >= 12.0, "{name}: {lines}");
        }
    }

    #[test]
    fn the_chase_view_shows_the_whole_ego_also_in_a_bend() {
        let map = ring(250.0);
        let mut snapshot = snapshot(&map, 50.0, &[]);
        for yaw_rate in [0.0, 0.25, -0.8] {
            snapshot.ego.yaw_rate = yaw_rate;
            let view = see(&map, &snapshot, 1.0, ViewKind::Chase);
            let ego = view.cars[0];
            for (x, y, z) in [(2.5, 0.9, 0.0), (2.5, -0.9, 0.0), (-2.5, 0.9, 0.0), (-2.5, -0.9, 0.3), (0.0, 0.0, 1.45)]
            {
                let corner = ego.position + ego.rotation * Vec3::new(x, y, z);
                let p = view.camera.project(corner, ASPECT).expect("in front");
                assert!(p.min_element() > 0.05 && p.max_element() < 0.99, "{p}");
            }
        }
    }
}
