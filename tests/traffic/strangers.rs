//! Programs that listen in place of a SUMO, or a SUMO of another version: each is named, and in time.

use super::*;
use codrive::traffic::{
    TrafficError,
    sumo::{SumoTraffic, VERSION},
};
use std::{
    io::{BufRead, BufReader, Read, Write},
    net::{TcpListener, TcpStream},
    time::Duration,
};

/// Limit for a time-out of half a second on a loaded machine, including half a second for the name. Without time-outs these tests would not
/// end.
const SOON: Duration = Duration::from_secs(5);

/// Starts a server for one connection on this machine, which `serve` handles. Returns its port.
fn server(serve: impl FnOnce(TcpStream) + Send + 'static) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    std::thread::spawn(move || serve(listener.accept().unwrap().0));
    port
}

/// Returns the error of codrive on a program that listens at `port`.
fn refused(port: u16) -> TrafficError {
    let begun = now();
    let setup = FixedSetup { timeout_s: 0.5, ..ring(0.0) };
    let error = SumoTraffic::connect("127.0.0.1", port, setup).err().expect("it is no SUMO");
    assert!(begun.elapsed() < SOON, "{:?}: {error}", begun.elapsed());
    error
}

/// Reads until the other side ends.
fn keep_silent(mut stream: TcpStream) {
    let _ = stream.read_to_end(&mut Vec::new());
}

#[test]
fn a_silent_server_is_an_error_with_host_port_and_the_missing_reply() {
    let port = server(keep_silent);
    let error = refused(port);
    assert!(matches!(error, TrafficError::Silent { .. }), "{error}");
    let text = error.to_string();
    for part in [&format!("127.0.0.1:{port} did not answer within 0.5 s"), "its version", "--num-clients"] {
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn a_port_whose_queue_is_full_is_an_error_in_time() {
    // No program accepts the connection. No reply comes, even if the system itself takes the connection.
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let error = refused(listener.local_addr().unwrap().port());
    assert!(matches!(error, TrafficError::Silent { .. }), "{error}");
}

/// Behaves as HTTP servers do: waits for a line and replies that the request was bad.
fn http(stream: TcpStream) {
    let mut line = Vec::new();
    BufReader::new(&stream).read_until(b'\n', &mut line).unwrap();
    (&stream).write_all(b"HTTP/1.1 400 Bad Request\r\nConnection: close\r\n\r\n").unwrap();
    keep_silent(stream);
}

#[test]
fn a_web_server_is_not_sumo_at_all() {
    let port = server(http);
    let error = refused(port);
    assert!(matches!(error, TrafficError::NotSumo { .. }), "{error}");
    let text = error.to_string();
    for part in [&format!("127.0.0.1:{port} is not SUMO: it says"), "HTTP/1.1 400 Bad Request", "--remote-port"] {
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn a_server_that_speaks_first_is_not_sumo_at_all() {
    let port = server(|mut stream| {
        stream.write_all(b"SSH-2.0-OpenSSH_9.2p1\r\n").unwrap();
        keep_silent(stream);
    });
    let text = refused(port).to_string();
    assert!(text.contains("is not SUMO: it says \"SSH-2.0-OpenSSH_9.2p1\""), "{text}");
}

#[test]
fn a_server_that_replies_with_another_message_is_not_sumo() {
    let port = server(|mut stream| {
        stream.write_all(&[0, 0, 0, 9, 1, 2, 3, 4, 5]).unwrap();
        keep_silent(stream);
    });
    assert!(matches!(refused(port), TrafficError::NotSumo { .. }));
}

#[test]
fn a_server_that_claims_a_gigabyte_is_not_sumo_and_takes_no_memory() {
    let port = server(|mut stream| {
        stream.write_all(&[0x40, 0, 0, 0, 7]).unwrap();
        keep_silent(stream);
    });
    assert!(matches!(refused(port), TrafficError::NotSumo { .. }));
}

#[test]
fn a_server_that_hangs_up_is_an_error_with_the_missing_reply() {
    let port = server(drop);
    let error = refused(port);
    assert!(matches!(error, TrafficError::Lost { .. }), "{error}");
    assert!(error.to_string().contains("its version did not come"), "{error}");
}

#[test]
fn a_sumo_of_another_version_is_refused_with_both_versions() {
    let port = server(|mut stream| {
        let mut asked = [0; 10];
        stream.read_exact(&mut asked).unwrap();
        // A status, then protocol 20 and a name: the reply of SUMO 1.15.0.
        let mut answer = b"\0\0\0\x20\x07\0\0\0\0\0\0\x15\0\0\0\0\x14\0\0\0\x0bSUMO 1.15.0".to_vec();
        answer[3] = answer.len() as u8;
        stream.write_all(&answer).unwrap();
        let mut rest = Vec::new();
        let _ = stream.read_to_end(&mut rest);
        assert!(rest.is_empty(), "asked {rest:?} of a SUMO of another version");
    });
    let error = refused(port);
    assert!(matches!(error, TrafficError::OtherVersion { .. }), "{error}");
    let text = error.to_string();
    let ours = format!("SUMO {VERSION}");
    for part in ["SUMO 1.15.0", &ours, &format!("127.0.0.1:{port}"), "remedy: start that version there"] {
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn the_required_sumo_version_is_the_installed_one() {
    let setup = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/setup")).unwrap();
    assert!(setup.contains(VERSION), "scripts/setup does not install SUMO {VERSION}");
    let _alone = alone();
    let here = SumoTraffic::start(ring(0.0)).unwrap().describe();
    assert!(here.contains(VERSION), "{here}");
}
