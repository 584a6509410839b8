//! `codrive evaluate`: compares policies for each hold and driver on the same rings, over whole horizons with transients.
//! Drives the fast ring, or whole drives on either traffic engine. Out: a table, CSV and figures.

mod benchmark;
mod checks;
#[cfg(test)]
mod columns_tests;
pub(super) mod plan;
pub(super) mod report;

use super::{CliError, flags, out, own_program::own_program, stop_on_ctrl_c};
use crate::{
    drive_loop::evaluation_drive,
    file,
    map::{self, RoadMap},
    metrics::EvaluationResult,
    policy,
    scenario::{AdvisedVehicles, PlannedDrive, Scenario, StartLayout},
    settings,
    sim::WorldError,
    traffic::{EngineChoice, FollowingModel},
    train::{TrainConfig, evaluate},
};
use clap::{Arg, ArgAction, ArgMatches, Command, parser::ValueSource, value_parser};
use indicatif::{ProgressBar, ProgressStyle};
use plan::{Engine, EvaluationCase, FollowingDriver};
use rayon::prelude::*;
use report::EvaluationRow;
use std::{
    io::Write,
    path::PathBuf,
    sync::{Arc, atomic::Ordering},
};

pub(super) fn command() -> Command {
    let option =
        |id: &'static str, name: &'static str, help: &'static str| Arg::new(id).long(id).value_name(name).help(help);
    let command = Command::new("evaluate")
        .about("Drive policies over whole horizons, for each hold and driver, and compare them with no advice")
        .arg(
            option(
                "policy",
                "NAME|FILE",
                "Policy to drive; auto is the shipped policy for --map; may be given several times [default: all \
                 built-in ones]",
            )
            .action(ArgAction::Append),
        )
        .arg(
            option("holds", "SECS,...", "Holds to drive with [default: the configuration's]")
                .value_delimiter(',')
                .value_parser(value_parser!(f64)),
        )
        .arg(
            option(
                "driver",
                "NAME|reaction=S,error=MPS,...",
                "Driver that follows the advice, on every engine: follow, perfect, sloppy, idm (ignores advice), \
                 guarded (follows exactly, but brakes when necessary), exact (follows exactly, regardless of vehicles \
                 ahead), or parameters: reaction, error, speed_bias, deadband. May be given several times [default: \
                 the driver of --config, else follow]",
            )
            .action(ArgAction::Append)
            .value_parser(plan::driver),
        )
        .arg(
            option(
                "benchmark",
                "NAME|FILE",
                "Benchmark to run on its sealed rings: ring, or a file like assets/benchmarks/ring.toml; combines only \
                 with --over, --out and --json",
            )
            .conflicts_with_all([
                "policy",
                "holds",
                "driver",
                "traffic",
                "config",
                "adherence",
                "policy-speed",
                "map",
                "other-model",
                "other-model-share",
            ]),
        )
        .arg(
            option(
                "traffic",
                "WORD",
                "Traffic; ring: the fast ring; native or sumo: whole drives in this traffic, physics and pedals included; \
                 FILE.csv: whole drives behind the vehicles of a file of trajectories, on an open lane",
            )
            .default_value("ring"),
        )
        .arg(
            option(
                "advised",
                "SHARE,...",
                "Numbers of advised vehicles for a curve of mean speed: shares (5%, 0.05; on a network of the vehicles \
                 that enter) or numbers (3). The curve includes 0 (traffic alone), and the same vehicles with drivers \
                 that ignore the advice",
            )
            .value_delimiter(',')
            .value_parser(value_parser!(AdvisedVehicles))
            .conflicts_with_all(["benchmark", "adherence"]),
        )
        .arg(
            option("other-model", "WORD", "Car-following model of a share of the other vehicles, with --traffic sumo")
                .default_value(FollowingModel::default().name())
                .value_parser(FollowingModel::ALL.map(FollowingModel::name)),
        )
        .arg(
            option(
                "other-model-share",
                "SHARE",
                "Share of the other vehicles that use --other-model, 0 to 1; drawn anew for each ring",
            )
            .default_value("1")
            .value_parser(value_parser!(f64)),
        )
        .arg(
            option(
                "map",
                "NAME",
                "Road of whole drives, and of --policy auto; for traffic ring, ring-250 or ring-641, each with its own \
                 traffic. A network, such as merge, needs --advised and --traffic sumo",
            )
            .default_value(Scenario::default().map),
        )
        .arg(
            option(
                "policy-speed",
                "MPS",
                "Target speed of the built-in policies; 0 is 98.5 % of the equilibrium speed of the ring",
            )
            .value_parser(value_parser!(f64))
            .default_value("0"),
        )
        .arg(
            option("over", "N", "Number of rings, each with its own seed, 2 to 100000; an interval needs two")
                .value_parser(value_parser!(u32).range(2..=100_000))
                .default_value("20"),
        )
        .arg(
            option("out", "DIR", "Folder for rings.csv, summary.csv and figures (SVG and PNG)")
                .value_parser(value_parser!(PathBuf)),
        )
        .arg(
            Arg::new("adherence")
                .long("adherence")
                .action(ArgAction::SetTrue)
                .requires("out")
                .help("Also draw figures of mean speed against the driver's reaction, error and deadband"),
        )
        .arg(Arg::new("json").long("json").action(ArgAction::SetTrue).help("Print as JSON, ring by ring"))
        .arg(Arg::new("worker").long("worker").action(ArgAction::SetTrue).hide(true))
        .arg(
            option("config", "FILE", "Configuration file (TOML), as for train; flags take precedence")
                .value_parser(value_parser!(PathBuf)),
        );
    flags::add_fields(command, &plan::config_fields(), "Configuration")
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    if matches.get_flag("worker") {
        return worker();
    }
    if let Some(name) = matches.get_one::<String>("benchmark") {
        let rings = matches.value_source("over").filter(|from| *from == ValueSource::CommandLine);
        let rings = rings.and_then(|_| matches.get_one::<u32>("over").copied());
        let dir = matches.get_one::<PathBuf>("out");
        return benchmark::main(name, rings, dir.map(PathBuf::as_path), matches.get_flag("json"));
    }
    let written = Scenario { map: plan::asked_map(matches), ..Scenario::default() };
    let road = Arc::new(written.load_map()?);
    let base = base_config(matches, &road)?;
    let config: TrainConfig = settings::changed(&base, &flags::changes(matches, &plan::config_fields()))?;
    let plan = plan::EvaluationPlan::new(matches, &config, road)?;
    for name in &plan.policies {
        let policy = plan.engage(name);
        // Do not warn about the policy chosen by `auto` at the default hold: the user chose neither.
        let is_auto = plan.resolved.iter().any(|resolved| resolved.name == *name && resolved.why.is_some());
        let holds_s = plan.holds_s.iter().filter(|hold_s| !is_auto || **hold_s != TrainConfig::default().advice.hold_s);
        let hold = holds_s
            .filter_map(|hold_s| {
                policy::untrained_hold(policy.as_deref()?, policy::Hold::nearest(*hold_s, config.ring.step_s))
            })
            .next();
        let vehicles = config.ring.vehicles_max;
        let advised = plan.advised.as_deref().unwrap_or(std::slice::from_ref(&config.ring.advised));
        let share = advised.iter().map(|advised| advised.share_of(vehicles)).fold(0.0, f64::max);
        let share = policy.as_deref().and_then(|policy| policy::untrained_share(policy, share, Some(vehicles)));
        for warning in hold.into_iter().chain(share).filter(|_| plan.engine == plan::Engine::FastRing) {
            log::warn!("{name}: {warning}");
        }
    }
    if let Some(dir) = &plan.out {
        report::claim(dir)?;
    }
    let rows = drive(&plan, &config)?;
    // Files are written first: the reader of the table may close the output.
    if let Some(dir) = &plan.out {
        report::write(dir, &plan, &config, &rows)?;
    }
    if matches.get_flag("json") {
        out::line(format_args!("{:#}", report::json(&plan, &config, &rows)))?;
    } else {
        out::text(report::table(&plan, &rows))?;
    }
    if let Some(dir) = &plan.out {
        out::line(format_args!("{}: rings.csv, summary.csv and figures", dir.display()))?;
    }
    Ok(())
}

/// Returns the configuration before the flags: that of `--config`, or of the road. Behind the vehicles of a file it has the length of the
/// lane, no warm-up, and the whole file as its horizon.
fn base_config(matches: &ArgMatches, road: &Arc<RoadMap>) -> Result<TrainConfig, CliError> {
    if let Some(path) = matches.get_one::<PathBuf>("config") {
        let mut config: TrainConfig = settings::from_file(path)?;
        config.advice.hold_max_s = 0.0;
        return Ok(config);
    }
    let mut config =
        map::known_as(road).and_then(|name| TrainConfig::of_ring(&name)).unwrap_or_else(TrainConfig::paper_ring);
    if let Engine::Traffic(traffic @ EngineChoice::Log(_)) = plan::engine(matches)? {
        let (map, vehicles) = (plan::asked_map(matches), 2);
        let scenario = Scenario { map, vehicles, traffic, duration_s: 0.0, ..Scenario::default() };
        let drive = PlannedDrive::on(&scenario, Arc::clone(road)).map_err(WorldError::from)?;
        let length_m = road.route.length_m();
        (config.ring.circumference_min_m, config.ring.circumference_max_m) = (length_m, length_m);
        (config.ring.warm_up_s, config.ring.horizon_s) = (0.0, drive.scenario().duration_s);
        config.ring.bunched_share = 0.0;
    }
    Ok(config)
}

/// Drives all cases in parallel. Ctrl-C ends it and discards what was driven.
fn drive(plan: &plan::EvaluationPlan, config: &TrainConfig) -> Result<Vec<EvaluationRow>, CliError> {
    let cases = plan.cases();
    let mut driven: Vec<EvaluationCase> = Vec::new();
    for case in cases.iter().map(|case| plan.driven_as(case)) {
        if !driven.contains(&case) {
            driven.push(case);
        }
    }
    let stop = stop_on_ctrl_c();
    let style = ProgressStyle::with_template("{bar:24} {pos}/{len} {elapsed}  {eta} left");
    let bar = ProgressBar::new((driven.len() * plan.rings) as u64);
    let bar = bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let one = |case: &EvaluationCase| {
        if stop.load(Ordering::Relaxed) {
            return Err(CliError::Failed("stopped; nothing was written".into()));
        }
        let Engine::Traffic(traffic) = &plan.engine else {
            let results = evaluate(&case.config(config), "evaluate", plan.rings, || plan.engage(&case.policy));
            bar.inc(plan.rings as u64);
            return Ok(results);
        };
        let ring = |ring| {
            let result = whole(traffic, plan, config, case, ring);
            bar.inc(1);
            result
        };
        (0..plan.rings).into_par_iter().map(ring).collect::<Result<Vec<_>, _>>()
    };
    let results: Vec<Vec<EvaluationResult>> = driven.par_iter().map(one).collect::<Result<_, _>>()?;
    bar.finish_and_clear();
    let row = |case: EvaluationCase| {
        let of = driven.iter().position(|d| *d == plan.driven_as(&case)).unwrap_or_default();
        EvaluationRow { results: results[of].clone(), case }
    };
    Ok(cases.into_iter().map(row).collect())
}

/// Runs one whole drive. SUMO runs once per process, so its drives run in worker processes of this program.
fn whole(
    traffic: &EngineChoice,
    plan: &plan::EvaluationPlan,
    config: &TrainConfig,
    case: &EvaluationCase,
    ring: usize,
) -> Result<EvaluationResult, CliError> {
    let scenario = Scenario {
        map: plan.drive.scenario().map.clone(),
        traffic: traffic.clone(),
        vehicles: config.ring.vehicles_min,
        traffic_drivers: config.ring.traffic_drivers.clone(),
        idm: config.ring.idm,
        other_model: plan.mixture.model,
        other_model_share: plan.mixture.share,
        start: if config.ring.bunched_share >= 0.5 { StartLayout::Bunched } else { StartLayout::Even },
        warm_up_s: config.ring.warm_up_s,
        duration_s: config.ring.horizon_s,
        step_s: config.ring.step_s,
        seed: config.seed + ring as u64,
        policy: case.policy.clone(),
        advised: case.advised,
        policy_speed_mps: plan.settings.aim_mps,
        hold_s: case.hold_s,
        range_mph: config.reward.range_mph,
        driver: match &case.driver {
            FollowingDriver::Named(named) => named.text.clone(),
            FollowingDriver::Configured | FollowingDriver::Population(_) => Scenario::default().driver,
        },
        ..Scenario::default()
    };
    if *traffic != EngineChoice::Sumo {
        return Ok(evaluation_drive::evaluate(&scenario)?);
    }
    let failed = |e: &dyn std::fmt::Display| {
        CliError::Failed(format!("a drive on SUMO: {}", e.to_string().trim_start_matches("codrive: ")))
    };
    let mut child = own_program()
        .map_err(|e| failed(&e))?
        .args(["evaluate", "--worker"])
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .map_err(|e| failed(&e))?;
    if let Some(mut stdin) = child.stdin.take() {
        stdin.write_all(scenario.to_toml().as_bytes()).map_err(|e| failed(&e))?;
    }
    let output = child.wait_with_output().map_err(|e| failed(&e))?;
    if !output.status.success() {
        return Err(failed(&String::from_utf8_lossy(&output.stderr).trim()));
    }
    serde_json::from_slice(&output.stdout).map_err(|e| failed(&e))
}

/// Drives the scenario on the standard input and prints its result as JSON.
fn worker() -> Result<(), CliError> {
    let text = file::read_text_from(std::io::stdin(), file::SETTINGS_BYTES)
        .map_err(|e| CliError::Input(format!("the scenario on the standard input: {e}")))?;
    let result = evaluation_drive::evaluate(&Scenario::from_toml(&text, "worker")?)?;
    let result = serde_json::to_string(&result).map_err(|e| CliError::Failed(e.to_string()))?;
    out::line(format_args!("{result}"))
}
