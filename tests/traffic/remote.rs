//! A SUMO that runs elsewhere: here, a child process that listens.

use super::*;
use codrive::traffic::{
    TrafficError,
    sumo::{self, SumoTraffic},
};
use std::{
    net::TcpListener,
    process::{Child, Command, Stdio},
    thread::sleep,
    time::Duration,
};

/// A listening SUMO, ended when dropped.
struct Remote {
    child: Child,
    port: u16,
}

impl Drop for Remote {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

fn listen(map: &str) -> Remote {
    let port = free_port();
    let net = RoadMap::load(map).unwrap().net_file;
    let child = Command::new(sumo::program(&sumo::home().unwrap()))
        .arg("--net-file")
        .arg(net)
        .args(["--remote-port", &port.to_string()])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    Remote { child, port }
}

/// Connects as soon as the child listens.
fn connect(remote: &Remote, setup: &TrafficSetup) -> Result<SumoTraffic, TrafficError> {
    for _ in 0..400 {
        match SumoTraffic::connect("127.0.0.1", remote.port, setup.clone()) {
            Err(TrafficError::Sumo(message)) if message.contains("nobody listens") => sleep(Duration::from_millis(50)),
            other => return other,
        }
    }
    panic!("SUMO does not listen after 20 s");
}

#[test]
fn a_remote_sumo_drives_bit_for_bit_as_the_one_in_process() {
    let _alone = alone();
    let setup = ring(0.2);
    let map = setup.map.clone();
    let drive = |traffic: &mut dyn Traffic| {
        run(traffic, 400, |step, cars| {
            (step >= 100).then(|| report(&map, &cars[0], if step < 250 { 1.0 } else { 4.0 }))
        })
    };
    let here = drive(&mut SumoTraffic::start(setup.clone()).unwrap());
    let remote = listen("ring-250");
    let mut traffic = connect(&remote, &setup).unwrap();
    let there = drive(&mut traffic);
    assert!(bits(&here) == bits(&there), "{:?}", differences(&map, &here, &there));
    assert!(traffic.describe().contains(&format!("at 127.0.0.1:{}", remote.port)), "{}", traffic.describe());
}

#[test]
fn a_port_where_nobody_listens_is_an_error_with_the_remedy() {
    let _alone = alone();
    let port = free_port();
    let error = SumoTraffic::connect("127.0.0.1", port, ring(0.0)).err().expect("nobody listens").to_string();
    assert!(error.contains(&format!("nobody listens at 127.0.0.1:{port}")), "{error}");
    assert!(error.contains(&format!("--remote-port {port}")), "{error}");
}

#[test]
fn a_remote_sumo_with_another_network_is_refused() {
    let _alone = alone();
    let remote = listen("ring-641");
    let error = connect(&remote, &ring(0.0)).err().expect("its lanes are longer").to_string();
    assert!(error.contains("lane e0_0 is 160.225 m long instead of 62.5 m"), "{error}");
    assert!(error.contains("remedy"), "{error}");
}

#[test]
fn a_remote_sumo_that_dies_is_an_error_and_not_a_hang() {
    let _alone = alone();
    let mut remote = listen("ring-250");
    let mut traffic = connect(&remote, &ring(0.0)).unwrap();
    traffic.step(None).unwrap();
    remote.child.kill().unwrap();
    remote.child.wait().unwrap();
    let error = traffic.step(None).unwrap_err();
    assert!(matches!(error, TrafficError::Sumo(_)), "{error}");
}
