//! Live drive in a process of its own, with a wheel and a recorded stream of Lab Streaming Layer, both of which disappear and return. In:
//! the folder of a recording, and a seed that sets the times. Out: the recording, and an exit code as the program's.

use super::{
    checks::{self, Held},
    plan::Plan,
    program::{LIVE, LIVE_SEED, Workplace},
    scenario::Scenario,
};
use codrive::{
    input::{
        Devices, Rig,
        lamps::Lamps,
        profiles::{self, UnprofiledDevice},
        wheel::{FoundWheel, WheelMessage},
    },
    live_drive::{LiveDrive, lab::LabDevices},
    lsl::{Channel, ChannelFormat, Outlet, OutletInterface, StreamDescription},
    record::{self, Table, TableReader},
    render::Gpu,
    rng,
    scenario::{DisplaySettings, Scenario as DriveScenario},
    time::Pace,
    traffic::EngineChoice,
};
use std::{
    env,
    error::Error,
    path::{Path, PathBuf},
    process,
    sync::mpsc::Sender,
    thread::sleep,
    time::{Duration, Instant},
};

/// Name of the test below, used to start its process.
pub const TEST: &str = "live::a_wheel_and_a_stream_that_go_and_come_back_cost_no_row_of_the_drive";
/// Duration of the drive, s.
const DURATION_S: f64 = 2.0;

fn wheel() -> WheelMessage {
    let values = [(0, 32_767), (1, 255), (2, 255), (5, 255)].into_iter().collect();
    let device = UnprofiledDevice { name: "G29".into(), id: (0x046d, 0xc24f), values, ..Default::default() };
    let profile = profiles::named("g29").unwrap();
    let found = FoundWheel { device, profile, lamps: Lamps::default(), force: None, angle: Default::default() };
    WheelMessage::Connected(Box::new(found))
}

fn stream() -> Result<Outlet, Box<dyn Error>> {
    let description = StreamDescription {
        name: "heart".into(),
        content: "ECG".into(),
        rate_hz: 60.0,
        format: ChannelFormat::Numbers,
        source_id: "heart-1".into(),
        channels: vec![Channel { label: "ecg".into(), ..Channel::default() }],
    };
    Ok(Outlet::open(description, &OutletInterface::Loopback)?)
}

/// Devices of a drive, with the times at which each disappears and returns, seconds of wall time.
struct Coming {
    times_s: [[f64; 2]; 2],
    stream: Option<Outlet>,
    wheel: Sender<WheelMessage>,
    has_wheel: bool,
}

impl Coming {
    fn look(&mut self, now_s: f64) -> Result<(), Box<dyn Error>> {
        let [is_stream, is_wheel] = self.times_s.map(|[from, to]| !(from..to).contains(&now_s));
        if is_stream != self.stream.is_some() {
            self.stream = is_stream.then(stream).transpose()?;
        }
        if is_wheel != self.has_wheel {
            self.has_wheel = is_wheel;
            self.wheel.send(if is_wheel { wheel() } else { WheelMessage::Lost })?;
        }
        // The result is ignored: a full queue of the library is not checked here.
        self.stream.iter().for_each(|stream| drop(stream.push(&[now_s], now_s)));
        Ok(())
    }
}

#[allow(clippy::disallowed_methods, reason = "the loop of a window stands at the wall clock")]
fn drive(folder: &Path, seed: u64) -> Result<(), Box<dyn Error>> {
    let scenario = DriveScenario {
        traffic: EngineChoice::Native,
        vehicles: 6,
        warm_up_s: 0.0,
        duration_s: DURATION_S,
        display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
        ..DriveScenario::default()
    };
    let mut random = rng::stream(seed, "devices");
    let mut goes = || {
        let from = random.uniform(0.2, 1.0);
        [from, from + random.uniform(0.05, 0.3)]
    };
    let times_s = [goes(), goes()];
    let (to, messages) = std::sync::mpsc::channel();
    to.send(wheel())?;
    let mut coming = Coming { times_s, stream: Some(stream()?), wheel: to, has_wheel: true };
    let lab = LabDevices::open(&toml::from_str("[lsl]\noutlets = true\nrecord = [\"name='heart'\"]\nwait_s = 20.0")?)?;
    let mut live = LiveDrive::new(&scenario, Pace::RealTime, Devices::with_rig(Rig::fed_by(messages)))?;
    live.set_lab(lab);
    live.record(folder, Gpu::shared().expect("a graphics adapter is needed"))?;
    live.begin_trial("trial-1-wide")?;
    let (begun, mut flushed) = (Instant::now(), Instant::now());
    let mut last = begun;
    while live.drive.world.ended().is_none() {
        coming.look(begun.elapsed().as_secs_f64())?;
        sleep(Duration::from_millis(16).saturating_sub(last.elapsed()));
        let elapsed = last.elapsed();
        last += elapsed;
        let due = live.advance(elapsed, |_| ())?;
        live.shown(last - begun, elapsed, &due);
        live.take_news().iter().for_each(|news| println!("{news}"));
        if flushed.elapsed() > record::FLUSH_EVERY / 4 {
            flushed = Instant::now();
            live.flush()?;
        }
    }
    live.finish_recording()?;
    Ok(())
}

#[test]
fn a_wheel_and_a_stream_that_go_and_come_back_cost_no_row_of_the_drive() {
    if let Some(folder) = env::var_os(LIVE) {
        // Prints and exits like the program, without the test harness.
        let ended = drive(&PathBuf::from(folder), env::var(LIVE_SEED).unwrap().parse().unwrap());
        ended.iter().for_each(|()| println!("driven"));
        process::exit(ended.map_or_else(
            |why| {
                eprintln!("{why}");
                1
            },
            |()| 0,
        ));
    }
    if let Err(broken) = Scenario::Live.check(&Plan::default(), 1) {
        panic!("{}: {}", broken.promise, broken.outcome.text);
    }
    let work = Workplace::new();
    let outcome = work.run(Scenario::Live.arguments());
    // The library decides how long it looks for a returning stream, so the test does not require that message.
    for news in ["the LSL stream heart is gone", "unplugged", "the drive continues"] {
        assert!(outcome.text.contains(news), "{news}: {}", outcome.text);
    }
    let events = TableReader::parquet(&Table::Events.parquet(&work.file("p1"))).unwrap();
    let is_told = events.words("detail").iter().any(|detail| detail.contains("the LSL stream heart is gone"));
    assert!(is_told, "{:?}", events.words("event"));
}

/// Checks that a complete recording has all ticks, and the rows of the stream in their own table.
pub fn is_whole(recording: &Path) -> Held {
    let ticks = checks::hashes(recording)?.len();
    checks::holds(ticks as f64 == DURATION_S * 100.0, || format!("{ticks} ticks of a drive of {DURATION_S} s"))?;
    let events = TableReader::parquet(&Table::Events.parquet(recording)).map_err(|why| why.to_string())?;
    let (kinds, details) = (events.words("event"), events.words("detail"));
    let is_told = kinds.iter().any(|kind| kind == "wheel unplugged");
    checks::holds(is_told, || format!("no event tells of the wheel: {kinds:?}"))?;
    let is_noted =
        |word: &str| kinds.iter().zip(&details).any(|(kind, detail)| kind == "device" && detail.contains(word));
    let table = recording.join(record::streams::FOLDER).join("heart.parquet");
    let read = TableReader::parquet(&table).map_err(|why| format!("the stream beside a whole drive: {why}"));
    // If the disk refused the stream, only the stream is lost, and the recording says so.
    read.map(drop).or_else(|why| if is_noted("is not recorded") { Ok(()) } else { Err(why) })
}
