//! `codrive bench`: measurements of this program on this machine.

use crate::bench::{
    self, CardReport, CostGrowth, DriveTimes, ForceTimes, FrameTimes, LearningTimes, SimulationReport, StartupTimes,
    TimeStatistics,
};
use crate::cli::{CliError, flags, out};
use crate::scenario::Scenario;
use crate::scene::ViewKind;
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use serde_json::json;

/// Simulated time over which the force thread is measured, s.
const FORCE_S: f64 = 3.0;

pub(super) fn command() -> Command {
    Command::new("bench")
        .about("Measure steps, ticks, frames, start-up and memory on this machine")
        .arg(Arg::new("json").long("json").action(ArgAction::SetTrue).help("Print as JSON"))
        .arg(
            Arg::new("frames")
                .long("frames")
                .value_name("N")
                .default_value("20")
                .value_parser(value_parser!(u32).range(1..=100_000))
                .help("Number of frames for each view and size"),
        )
        .arg(
            Arg::new("view")
                .long("view")
                .value_name("VIEW")
                .value_parser(ViewKind::NAMED.map(|(name, _)| name))
                .help("View to measure [default: all]"),
        )
        .arg(
            Arg::new("minutes")
                .long("minutes")
                .value_name("MIN")
                .default_value("0")
                .value_parser(value_parser!(u32).range(0..=600))
                .help(
                    "Length of a drive to draw at the largest size and to search for late frames, min; in real time or \
                     faster",
                ),
        )
        .arg(
            Arg::new("small")
                .long("small")
                .action(ArgAction::SetTrue)
                .help("Measure only the smallest size, for a quick result"),
        )
        .arg(
            Arg::new("gpu")
                .long("gpu")
                .action(ArgAction::SetTrue)
                .conflicts_with_all(["frames", "view", "minutes", "small"])
                .help(
                    "Measure only the graphics card, by its own timestamps: each view and quality at 1920x1080 and \
                     3840x2160, in less than a minute; without a graphics card nothing is measured",
                ),
        )
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let scenario = flags::scenario(matches)?;
    if matches.get_flag("gpu") {
        return card(&scenario, matches.get_flag("json"));
    }
    let count = matches.get_one::<u32>("frames").copied().unwrap_or(20);
    let sizes: &[[u32; 2]] = if matches.get_flag("small") { &bench::SIZES[..1] } else { &bench::SIZES };
    // Start-up is measured first: later the shader cache and the map are warm.
    let (startup, mut picture) = bench::startup(&scenario)?;
    let wanted = matches.get_one::<String>("view");
    let views: Vec<_> =
        ViewKind::NAMED.into_iter().filter(|(name, _)| wanted.is_none_or(|view| view == name)).collect();
    let frames = picture.frames(&views, sizes, count)?;
    let minutes = matches.get_one::<u32>("minutes").copied().unwrap_or(0);
    let drive = (minutes > 0).then(|| drive(&mut picture, minutes, sizes[sizes.len() - 1])).transpose()?;
    let force = bench::force(&mut picture, FORCE_S, sizes[0])?;
    let adapter = picture.adapter();
    drop(picture);
    let growth = bench::growth(&scenario, sizes[0], count)?;
    let simulation = bench::simulation(&scenario)?;
    let recorder = bench::recording(&scenario)?;
    let learning = bench::learning();
    let memory_mb = bench::peak_memory_mb();
    if matches.get_flag("json") {
        let report = json!({
            "program": concat!("codrive ", env!("CARGO_PKG_VERSION")),
            "build": if cfg!(debug_assertions) { "dev" } else { "release" },
            "adapter": adapter,
            "scenario": scenario,
            "startup": startup,
            "frames": frames,
            "drive": drive,
            "force": force,
            "growth": growth,
            "simulation": simulation,
            "recorder_tick": recorder,
            "learning": learning,
            "peak_memory_mb": memory_mb,
            "program_mb": bench::program_mb(),
        });
        out::line(format_args!("{report:#}"))?;
    } else {
        out::text(report_text(&adapter, &startup, &frames, drive.as_ref(), &growth, &simulation, memory_mb))?;
        out::text(format_args!("{}{}", recorder_text(&recorder), learning_text(&learning)))?;
        out::text(force_text(force.as_ref()))?;
    }
    Ok(())
}

/// Prints the times of pictures on the graphics card.
fn card(scenario: &Scenario, as_json: bool) -> Result<(), CliError> {
    let report = bench::card_times(scenario)?;
    if as_json {
        let program = concat!("codrive ", env!("CARGO_PKG_VERSION"));
        out::line(format_args!("{:#}", json!({ "program": program, "scenario": scenario, "card": report })))?;
    } else {
        out::text(card_text(&report))?;
    }
    Ok(())
}

fn card_text(report: &CardReport) -> String {
    let mut text = format!("{} ({}, {}, {})\n", report.adapter, report.kind, report.interface, report.driver);
    if let Some(why) = report.not_measured {
        return text + &format!("graphics card: not measured: {why}\n");
    }
    let [quality, median, late] = ["quality", "median", "99 % below"];
    text += &format!("{:<9} {:<9}  {quality:<7}  {median:>9}  {late:>12}   keeps\n", "view", "size");
    for row in &report.rows {
        let place = format!("{:<9} {:>4}x{:<4}  {:<7}", row.view, row.size[0], row.size[1], row.quality);
        text += &match (row.times, row.keeps_hz) {
            (None, _) => format!("{place}  not measured: the time is up\n"),
            (Some(times), hz) => format!(
                "{place}  {:>6.2} ms  {:>9.2} ms   {}\n",
                times.median_us / 1e3,
                times.p99_us / 1e3,
                hz.map_or("less than 60 Hz".into(), |hz| format!("{hz} Hz"))
            ),
        };
    }
    text + "keeps: usual refresh rate at which 99 of 100 pictures take at most three quarters of an interval on the card\n"
}

/// Draws the drive for some minutes behind a progress bar.
fn drive(picture: &mut bench::DrawnDrive, minutes: u32, size: [u32; 2]) -> Result<DriveTimes, CliError> {
    let bar = crate::cli::progress::progress(1000, format!("{minutes} min of driving"));
    let drive = picture.drive(60.0 * f64::from(minutes), size, |share| bar.set_position((1000.0 * share) as u64))?;
    bar.finish_and_clear();
    Ok(drive)
}

fn force_text(force: Option<&ForceTimes>) -> String {
    force.map_or(String::new(), |force| {
        format!(
            "force thread             every {:.0} ms, off by {:.2} ms (median), 99 % below {:.2}, at most {:.2}, while pictures take {:.0} ms\n",
            force.period_ms,
            force.jitter.median_us / 1e3,
            force.jitter.p99_us / 1e3,
            force.jitter.max_us / 1e3,
            force.frame_ms
        )
    })
}

fn recorder_text(times: &TimeStatistics) -> String {
    let outcome = if times.p99_us <= bench::RECORDER_LIMIT_US { "kept" } else { "NOT kept" };
    format!(
        "recorder, of a tick      {:.1} us, 99 % below {:.1}, longest {:.0}; limit {} for 99 %: {outcome}\n",
        times.median_us,
        times.p99_us,
        times.max_us,
        bench::RECORDER_LIMIT_US
    )
}

fn learning_text(times: &LearningTimes) -> String {
    let ms = |times: &TimeStatistics| times.median_us / 1e3;
    format!(
        "fast ring, one core      {:.1} million ring steps/s, {:.0} million vehicle updates/s\n\
         in rollouts, one core    {:.0} million vehicle updates/s, with a policy that estimates the driver {:.0}: \
         ratio {:.2}\n\
         TRPO update, batch 16000 {:.0} ms on one core, {:.0} ms on {cores}\n\
         iteration of training    {:.0} ms on {cores}: 500 in {:.0} s\n",
        times.ring_steps_per_s / 1e6,
        times.vehicle_updates_per_s / 1e6,
        times.rollout_updates_per_s / 1e6,
        times.asking_rollout_updates_per_s / 1e6,
        times.asking_rollout_updates_per_s / times.rollout_updates_per_s,
        ms(&times.update_one_core),
        ms(&times.update),
        ms(&times.iteration),
        ms(&times.iteration) * 0.5,
        cores = times.cores,
    )
}

fn report_text(
    adapter: &str,
    startup: &StartupTimes,
    frames: &[FrameTimes],
    drive: Option<&DriveTimes>,
    growth: &[CostGrowth],
    simulation: &SimulationReport,
    memory_mb: Option<f64>,
) -> String {
    let build = if cfg!(debug_assertions) { " (a dev build: use --release for figures)" } else { "" };
    let mut lines = vec![format!("{adapter}{build}")];
    lines.push(format!(
        "start to first frame     {:.0} ms: world {:.0}, device {:.0}, static scene {:.0}, renderer {:.0}, frame {:.0}",
        startup.total_ms,
        startup.world_ms,
        startup.device_ms,
        startup.static_scene_ms,
        startup.renderer_ms,
        startup.frame_ms
    ));
    for row in frames {
        let passes = row.passes.map_or(String::new(), |p| {
            format!("  (shadow {:.2}, main {:.2}, mirror {:.2}, tone map {:.2})", p[0], p[1], p[2], p[3])
        });
        let memory = row.device_mb.map_or(String::new(), |mb| format!("  {mb:.0} MB"));
        lines.push(format!(
            "{:<9} {:>4}x{:<4} {:<7} {:>8.2} ms a frame, 99 % below {:.2}{passes}{memory}",
            row.view,
            row.size[0],
            row.size[1],
            row.quality,
            row.times.median_us / 1e3,
            row.times.p99_us / 1e3
        ));
    }
    if let Some(drive) = drive {
        let [median, p99, max] = [drive.times.median_us, drive.times.p99_us, drive.times.max_us].map(|us| us / 1e3);
        let grown = drive.grown_mb.map_or(String::new(), |mb| format!("; memory {mb:+.1} MB"));
        lines.push(format!(
            "{:.0} s of driving at {}x{}: median {median:.2} ms, 99 % below {p99:.2}, longest {max:.2}; {} of {} frames above \
             three times the median{grown}",
            drive.seconds, drive.size[0], drive.size[1], drive.hitches, drive.times.samples
        ));
    }
    for row in growth {
        lines.push(format!(
            "{:<9} {:>4}x{:<4} {}, relative to {}: {:.2} over {:.2} ms, ratio {:.2}",
            row.view, row.size[0], row.size[1], row.places[0], row.places[1], row.large_ms, row.small_ms, row.ratio
        ));
    }
    if let Some(sumo) = &simulation.sumo_step {
        lines.push(format!(
            "step of {}   {:.1} us, bare {:.1} us: ratio {:.3}",
            sumo.engine, sumo.full.median_us, sumo.bare.median_us, sumo.ratio
        ));
    }
    if let Some((sumo, vehicles)) = &simulation.network_step {
        lines.push(format!(
            "SUMO step, {vehicles:.0} vehicles on a grid of 10 x 10   {:.0} us, bare {:.0} us: ratio {:.3}",
            sumo.full.median_us, sumo.bare.median_us, sumo.ratio
        ));
    }
    if let Some(loading) = &simulation.network_loading {
        lines.push(format!(
            "reading {} edges      {:.2} s for {:.1} MB",
            loading.edges, loading.seconds, loading.file_mb
        ));
    }
    let row =
        |name: &str, times: &TimeStatistics| format!("{name}{:.1} us, 99 % below {:.1}", times.median_us, times.p99_us);
    lines.push(row("step of native traffic   ", &simulation.native_step));
    lines.push(row("tick of the ego          ", &simulation.ego_tick));
    lines.push(row("tick of the whole world  ", &simulation.world_tick));
    lines.push(format!("full speed               {:.0} times real time", simulation.times_real_time));
    let mb = |mb: Option<f64>| mb.map_or("-".into(), |mb| format!("{mb:.1} MB"));
    lines.push(format!("peak memory              {}, program file {}", mb(memory_mb), mb(bench::program_mb())));
    lines.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{bench::CardTimes, scenario::QualityLevel};
    use std::time::Duration;

    #[test]
    fn a_report_of_the_card_names_adapter_times_and_rates() {
        let times = TimeStatistics::of(vec![Duration::from_micros(3_250); 60]);
        let row = |quality, times, keeps_hz| CardTimes { view: "driver", quality, size: [1920, 1080], times, keeps_hz };
        let rows = vec![
            row(QualityLevel::Low, Some(times), Some(165)),
            row(QualityLevel::Medium, Some(times), None),
            row(QualityLevel::High, None, None),
        ];
        let [adapter, kind, interface, driver] = ["Card", "DiscreteGpu", "Vulkan", "driver 1.2"].map(str::to_owned);
        let text = card_text(&CardReport { adapter, kind, interface, driver, not_measured: None, rows });
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "Card (DiscreteGpu, Vulkan, driver 1.2)");
        assert_eq!(lines[1], "view      size       quality     median    99 % below   keeps");
        assert_eq!(lines[2], "driver    1920x1080  low        3.25 ms       3.25 ms   165 Hz");
        assert_eq!(lines[3], "driver    1920x1080  medium     3.25 ms       3.25 ms   less than 60 Hz");
        assert_eq!(lines[4], "driver    1920x1080  high     not measured: the time is up");
        assert_eq!(lines.len(), 6);
    }
}
