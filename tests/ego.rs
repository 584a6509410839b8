//! What must hold of the ego as a whole: it accelerates, brakes, corners and stands like a mid-size saloon, keeps out
//! of other cars, and does the same twice.

use codrive::{
    ego::{CarParams, Contact, Controls, Ego, EgoState, Everywhere, Obstacle, STEERING_RATIO, Selector, Surface},
    rng,
    space::{CAR_LENGTH_M, Pose},
    time::TICK_S,
};
use glam::{DVec2, dvec2};

const ROAD: Everywhere = Everywhere(Surface::Asphalt);
const MEADOW: Everywhere = Everywhere(Surface::Grass);
const BRAKE: Controls = Controls { throttle: 0.0, brake: 1.0, steering_wheel_rad: 0.0, selector: Selector::Drive };

fn car(speed_mps: f64) -> Ego {
    Ego::new(&CarParams::default(), Pose::default(), speed_mps, 0).unwrap()
}

fn throttle(throttle: f32) -> Controls {
    Controls { throttle, ..Controls::default() }
}

/// Runs `seconds` on asphalt and returns every state.
fn drive(ego: &mut Ego, controls: Controls, seconds: f64) -> Vec<EgoState> {
    drive_on(ego, controls, seconds, &ROAD)
}

fn drive_on(ego: &mut Ego, controls: Controls, seconds: f64, ground: &Everywhere) -> Vec<EgoState> {
    let ticks = (seconds / TICK_S).round() as usize;
    (0..ticks)
        .map(|_| {
            ego.tick(&controls, ground, &[]);
            *ego.state()
        })
        .collect()
}

#[test]
fn probe() {
    let mut ego = car(0.0);
    let states = drive(&mut ego, BRAKE, 60.0);
    for i in [0, 1, 5, 20, 50, 100, 200, 500, 5999] {
        let s = states[i];
        println!("{i} pos {:?} rot {:?} v {:?} rpm {}", s.position, s.rotation, s.velocity, s.engine_rpm);
    }
    let states = drive(&mut ego, throttle(0.0), 20.0);
    for i in (0..2000).step_by(100) {
        println!(
            "creep {i} v {:.3} a {:.3} rpm {:.0}",
            states[i].speed_mps, states[i].accel_mps2, states[i].engine_rpm
        );
    }
    for p in [0.05, 0.1, 0.15, 0.2, 0.3, 0.5] {
        let mut ego = car(0.0);
        let states = drive(&mut ego, throttle(p), 60.0);
        print!("p {p}: ");
        for i in [100, 200, 300, 500, 1000, 2000, 4000, 5999] {
            print!("{:.2}({}) ", states[i].speed_mps, states[i].gear);
        }
        println!();
    }
    let mut ego = car(0.0);
    let states = drive(&mut ego, throttle(1.0), 100.0);
    let mut last = 0;
    for (i, s) in states.iter().enumerate() {
        if s.gear != last || i % 1000 == 0 {
            println!(
                "full {:.2} s v {:.2} a {:.2} gear {} rpm {:.0}",
                i as f64 * TICK_S,
                s.speed_mps,
                s.accel_mps2,
                s.gear,
                s.engine_rpm
            );
            last = s.gear;
        }
    }
    println!("0-100 {:?}", states.iter().position(|s| s.speed_mps > 100.0 / 3.6));
    println!(
        "max accel change {:?}",
        states.windows(2).map(|w| (w[1].accel_mps2 - w[0].accel_mps2).abs()).fold(0.0, f64::max)
    );
    let states = drive(&mut ego, throttle(0.0), 100.0);
    last = 0;
    for (i, s) in states.iter().enumerate() {
        if s.gear != last || i % 1000 == 0 {
            println!(
                "coast {:.2} s v {:.2} a {:.2} gear {} rpm {:.0}",
                i as f64 * TICK_S,
                s.speed_mps,
                s.accel_mps2,
                s.gear,
                s.engine_rpm
            );
            last = s.gear;
        }
    }
    let mut ego = car(50.0 / 3.6);
    let states = drive(&mut ego, BRAKE, 4.0);
    println!(
        "brake {:?} {:?}",
        states.last().unwrap().position,
        states.iter().map(|s| s.accel_mps2).fold(0.0, f64::min)
    );
    for i in (0..250).step_by(10) {
        let s = states[i];
        println!(
            "brake {i} v {:.3} a {:.3} z {:.3} rot {:?}",
            s.speed_mps,
            s.accel_mps2,
            s.position.z,
            s.rotation.to_euler(glam::EulerRot::ZYX)
        );
    }
    for steer in [2.0f32, 4.0, 4.3, 5.0, 8.0] {
        let mut ego = car(10.0);
        let mut integral = 0.0;
        for i in 0..3000 {
            let e = 10.0 - ego.state().speed_mps;
            integral += e * TICK_S;
            let c = Controls {
                throttle: (0.25 + 0.3 * e + 0.1 * integral).clamp(0.0, 1.0) as f32,
                steering_wheel_rad: steer.to_radians() * STEERING_RATIO,
                ..Controls::default()
            };
            ego.tick(&c, &ROAD, &[]);
            if i == 2999 {
                let s = ego.state();
                println!(
                    "circle {steer} v {:.3} yaw rate {:.4} r {:.3} L/r {:.4} roll {:?} torque {:.2}",
                    s.speed_mps,
                    s.yaw_rate,
                    s.speed_mps / s.yaw_rate,
                    (2.8 / (s.speed_mps / s.yaw_rate)).to_degrees(),
                    s.rotation.to_euler(glam::EulerRot::ZYX),
                    s.steering_torque_nm
                );
            }
        }
    }
    let mut ego = car(0.0);
    let states = drive_on(&mut ego, throttle(1.0), 40.0, &MEADOW);
    for i in (0..4000).step_by(400) {
        println!("grass {i} v {:.3} a {:.3} g {}", states[i].speed_mps, states[i].accel_mps2, states[i].gear);
    }
    let mut ego = car(0.0);
    let states = drive(&mut ego, Controls { throttle: 0.3, selector: Selector::Reverse, ..Controls::default() }, 5.0);
    println!("reverse {:.3}", states.last().unwrap().speed_mps);
    let mut ego = car(0.0);
    let states = drive(&mut ego, Controls { selector: Selector::Neutral, ..Controls::default() }, 60.0);
    println!("neutral {:?}", states.last().unwrap().position);
    let _ = (CAR_LENGTH_M, dvec2(0.0, 0.0), DVec2::ZERO, rng::stream(1, "a"), Obstacle::default(), None::<Contact>);
}
