//! A remote SUMO: here, a child process that listens.

use super::*;
use codrive::traffic::{
    TrafficError,
    sumo::{self, SumoTraffic},
};
use std::{
    io::{Read, Write},
    net::{TcpListener, TcpStream},
    process::{Child, Command, Stdio},
    sync::Mutex,
    thread::sleep,
    time::Duration,
};

/// Listening SUMO, ended on drop.
pub struct Remote {
    pub child: Child,
    pub port: u16,
}

impl Drop for Remote {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Sends a signal with the shell's own kill, because a bare Debian has no other.
pub fn signal(child: &Child, name: &str) {
    let sent = Command::new("sh").args(["-c", &format!("kill -{name} {}", child.id())]).status().unwrap();
    assert!(sent.success());
}

/// Returns a port without a listener that no other test of this program got: until SUMO has taken it, the system may assign it again.
fn free_port() -> u16 {
    static GIVEN: Mutex<Vec<u16>> = Mutex::new(Vec::new());
    loop {
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let mut given = GIVEN.lock().unwrap();
        if !given.contains(&port) {
            given.push(port);
            return port;
        }
    }
}

pub fn listen(map: &str) -> Remote {
    listen_for(map, 1)
}

/// Starts a listening SUMO for this number of clients.
fn listen_for(map: &str, clients: u32) -> Remote {
    let port = free_port();
    let net = RoadMap::load(map).unwrap().net_file;
    let child = Command::new(sumo::program(&sumo::home().unwrap()))
        .arg("--net-file")
        .arg(net)
        .args(["--remote-port", &port.to_string(), "--num-clients", &clients.to_string()])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    Remote { child, port }
}

/// Connects as soon as the child listens.
pub fn connect(remote: &Remote, setup: &FixedSetup) -> Result<SumoTraffic, TrafficError> {
    for _ in 0..400 {
        match SumoTraffic::connect("127.0.0.1", remote.port, setup.clone()) {
            Err(TrafficError::Unreachable { .. }) => sleep(Duration::from_millis(50)),
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
fn a_port_without_a_listener_is_an_error_with_a_remedy() {
    let _alone = alone();
    let port = free_port();
    let error = SumoTraffic::connect("127.0.0.1", port, ring(0.0)).err().expect("nobody listens").to_string();
    assert!(error.contains(&format!("no program listens at 127.0.0.1:{port}")), "{error}");
    assert!(error.contains("remedy: start SUMO there: sumo --net-file NET --remote-port PORT"), "{error}");
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
    traffic.step(&[]).unwrap();
    remote.child.kill().unwrap();
    remote.child.wait().unwrap();
    let error = traffic.step(&[]).unwrap_err();
    assert!(matches!(error, TrafficError::Lost { .. }), "{error}");
    let text = error.to_string();
    assert!(text.contains(&format!("127.0.0.1:{} is gone", remote.port)) && text.contains("a step"), "{text}");
}

/// Starts a client of SUMO that only watches: it takes its place and joins every step until SUMO ends.
fn watch(port: u16) -> std::thread::JoinHandle<usize> {
    std::thread::spawn(move || {
        let mut stream = (0..400)
            .find_map(|_| {
                sleep(Duration::from_millis(50));
                TcpStream::connect(("127.0.0.1", port)).ok()
            })
            .expect("SUMO listens for a second client");
        // The commands are: set the order to 2, then make one step.
        let order = [0, 0, 0, 10, 6, 3, 0, 0, 0, 2];
        let step = [0, 0, 0, 14, 10, 2, 0, 0, 0, 0, 0, 0, 0, 0];
        let mut steps = 0;
        stream.write_all(&order).unwrap();
        while answer(&mut stream).is_ok() && stream.write_all(&step).is_ok() {
            steps += 1;
        }
        steps
    })
}

/// Reads one complete message.
fn answer(stream: &mut TcpStream) -> std::io::Result<Vec<u8>> {
    let mut length = [0; 4];
    stream.read_exact(&mut length)?;
    let mut message = vec![0; u32::from_be_bytes(length) as usize - 4];
    stream.read_exact(&mut message)?;
    Ok(message)
}

#[test]
fn a_second_client_of_a_remote_sumo_watches_the_same_drive() {
    let _alone = alone();
    let setup = ring(0.2);
    let map = setup.map.clone();
    let drive =
        |traffic: &mut dyn Traffic| run(traffic, 100, |step, cars| (step >= 50).then(|| report(&map, &cars[0], 1.0)));
    let here = drive(&mut SumoTraffic::start(setup.clone()).unwrap());
    let mut remote = listen_for("ring-250", 2);
    let watcher = watch(remote.port);
    let mut traffic = connect(&remote, &setup).unwrap();
    let there = drive(&mut traffic);
    assert!(bits(&here) == bits(&there), "{:?}", differences(&map, &here, &there));
    drop(traffic);
    remote.child.kill().unwrap();
    let steps = watcher.join().unwrap();
    assert!(steps >= 100, "the watcher was there for {steps} steps");
}

#[test]
fn a_step_of_a_remote_sumo_can_be_begun_and_awaited_in_short_waits() {
    let _alone = alone();
    let setup = ring(0.0);
    let remote = listen("ring-250");
    let mut traffic = connect(&remote, &setup).unwrap();
    let before = traffic.cars().to_vec();
    // The system stops SUMO: the step does not arrive, and the wait lasts no longer than requested.
    signal(&remote.child, "STOP");
    traffic.begin_step(&[]).unwrap();
    assert!(!traffic.finish_step(Duration::from_millis(20)).unwrap());
    assert_eq!(traffic.cars(), before);
    signal(&remote.child, "CONT");
    while !traffic.finish_step(Duration::from_millis(20)).unwrap() {}
    assert_ne!(traffic.cars(), before);
}

#[test]
fn a_remote_sumo_that_falls_silent_is_an_error_after_the_time_out() {
    let _alone = alone();
    let setup = FixedSetup { timeout_s: 0.5, ..ring(0.0) };
    let remote = listen("ring-250");
    let mut traffic = connect(&remote, &setup).unwrap();
    traffic.step(&[]).unwrap();
    signal(&remote.child, "STOP");
    let begun = now();
    let error = traffic.step(&[]).unwrap_err();
    // The limit is the time-out and the delay of a loaded machine; without a time-out this test would not end.
    assert!(begun.elapsed() >= Duration::from_millis(500) && begun.elapsed() < Duration::from_secs(5));
    assert!(matches!(error, TrafficError::Silent { .. }), "{error}");
    let text = error.to_string();
    for part in [&format!("127.0.0.1:{} did not answer within 0.5 s", remote.port), "a step", "--traffic-timeout"] {
        assert!(text.contains(part), "{text}");
    }
}
