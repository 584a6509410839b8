//! `codrive train`: trains a policy from a configuration and writes its learning curve. Ctrl-C ends it and writes the best
//! policy so far; `--resume` continues from the last checkpoint with bit-identical results.

use super::{CliError, flags, out, stop_on_ctrl_c};
use crate::{
    file::read_text,
    private,
    settings::{self, fields_of},
    train::{CHECKPOINT_BYTES, CheckpointClock, Learner, LearningCurveRow, TrainConfig, learning_curve},
};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use indicatif::{ProgressBar, ProgressStyle};
use std::{
    path::{Path, PathBuf},
    sync::atomic::Ordering,
    time::Duration,
};

/// Best policy so far.
const POLICY: &str = "policy.toml";
/// The policy as ONNX, in builds that read ONNX.
const ONNX: &str = "policy.onnx";
/// Estimator of the driver's traits, if the policy uses one.
#[cfg(feature = "onnx")]
const ESTIMATOR_ONNX: &str = "estimator.onnx";
const CONFIG: &str = "train.toml";
const CHECKPOINT: &str = "checkpoint.json";
const CURVE_CSV: &str = "curve.csv";
const CURVE_SVG: &str = "curve.svg";

pub(super) fn command() -> Command {
    let file = |id: &'static str, name: &'static str, help: &'static str| {
        Arg::new(id).long(id).value_name(name).value_parser(value_parser!(PathBuf)).help(help)
    };
    let command = Command::new("train")
        .about("Train a policy on the fast ring by TRPO")
        .arg(file("out", "DIR", "Folder for policy, configuration, curve and checkpoints").required(true))
        .arg(file("config", "FILE", "Configuration (TOML); flags take precedence"))
        .arg(
            Arg::new("resume")
                .long("resume")
                .action(ArgAction::SetTrue)
                .help("Continue from the checkpoint in --out; only --iterations may differ"),
        );
    flags::add_fields(command, &fields_of::<TrainConfig>(), "Configuration")
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let Some(dir) = matches.get_one::<PathBuf>("out") else { return Ok(()) };
    let mut learner = if matches.get_flag("resume") { resumed(matches, dir)? } else { fresh(matches, dir)? };
    let stop = stop_on_ctrl_c();
    let bar = progress(&learner);
    let mut clock = CheckpointClock::default();
    while learner.iteration() < learner.config().all_iterations() && !stop.load(Ordering::Relaxed) {
        let row = learner.iterate();
        bar.set_message(row_text(&row, learner.best().2));
        bar.set_position(u64::from(row.iteration));
        if clock.is_due() {
            save(dir, &learner)?;
        }
    }
    bar.finish_and_clear();
    save(dir, &learner)?;
    if let Some(learned) = learn_silence(&mut learner) {
        save(dir, &learner)?;
        out::line(format_args!("{learned}"))?;
    }
    let (_, iteration, judged_mps) = learner.best();
    let judged = judged_mps.map_or("not judged yet".into(), |v| format!("{v:.3} m/s over whole horizons"));
    out::line(format_args!("{}: update {iteration} of {}, {judged}", dir.join(POLICY).display(), learner.iteration()))?;
    Ok(())
}

/// Learns when to advise nothing, if the training includes that. Returns the result as text.
fn learn_silence(learner: &mut Learner) -> Option<String> {
    let rings = learner.config().silence.silence_rings;
    let spinner =
        ProgressBar::new_spinner().with_message(format!("{rings} rings with and without advice, to learn silence"));
    spinner.enable_steady_tick(Duration::from_millis(200));
    let learned = learner.learn_silence();
    spinner.finish_and_clear();
    let learned = learned?;
    Some(format!(
        "silence learned from {} pairs of drives: no advice in {:.1} % of the observations; the gain of one ring has \
         an error of {:.2} m/s",
        learned.pairs,
        100.0 * learned.silent_share,
        learned.error_mps
    ))
}

/// Returns the configuration that the command line asks for.
fn config(matches: &ArgMatches, base: TrainConfig) -> Result<TrainConfig, CliError> {
    let base = match matches.get_one::<PathBuf>("config") {
        Some(path) => settings::from_file(path)?,
        None => base,
    };
    Ok(settings::changed(&base, &flags::changes(matches, &fields_of::<TrainConfig>()))?)
}

/// Starts a training in a folder that holds none.
fn fresh(matches: &ArgMatches, dir: &Path) -> Result<Learner, CliError> {
    let config = config(matches, TrainConfig::default())?;
    let corrected = config.corrected_advice().map_err(CliError::Input)?;
    private::folder(dir).map_err(|e| CliError::Failed(format!("{}: {e}", dir.display())))?;
    if let Some(name) = [POLICY, ONNX, CHECKPOINT, CURVE_CSV].iter().find(|name| dir.join(name).exists()) {
        let text = format!(
            "{} already holds a training ({name}); name another folder with --out, or continue with --resume",
            dir.display()
        );
        return Err(CliError::Input(text));
    }
    write(dir, CONFIG, toml::to_string(&config).unwrap_or_default().as_bytes())?;
    Ok(Learner::beside(&config, corrected))
}

/// Loads the training of the checkpoint in `dir`; the command line may change the number of iterations only.
fn resumed(matches: &ArgMatches, dir: &Path) -> Result<Learner, CliError> {
    let path = dir.join(CHECKPOINT);
    let text = read_text(&path, CHECKPOINT_BYTES)
        .map_err(|e| CliError::Input(format!("{}: cannot be read: {e}; --resume needs it", path.display())))?;
    let mut learner =
        Learner::from_checkpoint(&text).map_err(|e| CliError::Input(format!("{}: {e}", path.display())))?;
    let asked = config(matches, learner.config().clone())?;
    learner.set_iterations(asked.run.iterations);
    if asked != *learner.config() {
        let (is, was) = (toml::to_string(&asked).unwrap_or_default(), toml::to_string(learner.config()));
        let was = was.unwrap_or_default();
        let change = is.lines().zip(was.lines()).find(|(a, b)| a != b);
        let (is, was) = change.unwrap_or(("another configuration", ""));
        let text = format!("{}: was trained with `{was}`, not `{is}`; --resume cannot change that", path.display());
        return Err(CliError::Input(text));
    }
    Ok(learner)
}

fn progress(learner: &Learner) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:24} {pos}/{len} {elapsed} {msg}  {eta} left");
    let bar = ProgressBar::new(u64::from(learner.config().all_iterations()));
    bar.set_position(u64::from(learner.iteration()));
    bar.reset_eta();
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

fn row_text(row: &LearningCurveRow, best_mps: Option<f64>) -> String {
    let best = best_mps.map_or("-".into(), |v| format!("{v:.3}"));
    if let Some(loss) = row.estimator_loss {
        return format!("{:.3} m/s; the estimator of the driver: loss {loss:.3} nat", row.mean_mps);
    }
    format!(
        "{:.3} m/s, best {best}, KL {:.4}, entropy {:.2}, crashes {}",
        row.mean_mps, row.kl, row.entropy, row.crashes
    )
}

/// Writes policy, curve and checkpoint of the training's present state.
fn save(dir: &Path, learner: &Learner) -> Result<(), CliError> {
    let (network, iteration, _) = learner.best();
    let rows = learner.curve();
    let [shortest, longest] = learner.config().holds_s();
    let holds = if shortest < longest { format!("{shortest} to {longest}") } else { shortest.to_string() };
    let title = format!("{} advice held {holds} s: best after {iteration} updates", action(learner));
    let checkpoint = learner.to_checkpoint().map_err(CliError::Failed)?;
    write(dir, CHECKPOINT, checkpoint.as_bytes())?;
    write(dir, POLICY, network.to_toml().as_bytes())?;
    #[cfg(feature = "onnx")]
    {
        write(dir, ONNX, &crate::policy::onnx::write(&network))?;
        if let Some(estimator) = &network.estimator {
            write(dir, ESTIMATOR_ONNX, &crate::policy::onnx::write_estimator(estimator))?;
        }
    }
    write(dir, CURVE_CSV, learning_curve::csv(rows).as_bytes())?;
    write(dir, CURVE_SVG, learning_curve::svg(rows, &title).as_bytes())
}

fn action(learner: &Learner) -> String {
    serde_json::to_value(learner.config().advice.action)
        .ok()
        .and_then(|v| v.as_str().map(str::to_owned))
        .unwrap_or_default()
}

/// Writes a file by renaming a new one: a full disk or a power cut leaves the old file whole.
fn write(dir: &Path, name: &str, bytes: &[u8]) -> Result<(), CliError> {
    let path = dir.join(name);
    private::replace(&path, bytes)
        .map_err(|e| CliError::Failed(format!("{}: {e}; the previous file is kept", path.display())))
}
