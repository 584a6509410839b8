//! `codrive analyse`: measures, figures and a report of recordings.

use super::{CliError, out};
use crate::{
    analysis::{AnalysisError, collect, find, report, tables},
    chart, record,
};
use clap::{Arg, ArgMatches, Command, value_parser};
use rayon::prelude::*;
use std::path::PathBuf;

pub(super) fn command() -> Command {
    Command::new("analyse")
        .about("Make tables of measures (CSV), figures (SVG, PNG) and a report (HTML) of recordings")
        .after_help("Made anew at every call; recordings are only read.")
        .arg(
            Arg::new("folder")
                .value_name("DIR")
                .required(true)
                .value_parser(value_parser!(PathBuf))
                .help("A recording, a participant of a study (.../sub-P03), or the folder of a study"),
        )
        .arg(
            Arg::new("out").long("out").value_name("DIR").value_parser(value_parser!(PathBuf)).help(
                "Where to write [default: analysis/ in a recording, derivatives/codrive/ in the folder of a study]",
            ),
        )
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let Some(folder) = matches.get_one::<PathBuf>("folder") else { return Ok(()) };
    let holdings = find(folder)?;
    let out = matches.get_one::<PathBuf>("out").unwrap_or(&holdings.out);
    let bar = super::progress(holdings.found.len() as u64, "drives".into());
    let drives = collect::analyse(&holdings.found, &|| bar.inc(1));
    bar.finish_and_clear();
    let drives = drives?;
    let made = report::report(&holdings.title, &drives)?;
    let put = |name: &str, text: &str| record::replace(&out.join(name), text.as_bytes());
    record::new_private_dir(&out.join("figures"))?;
    put("trials.csv", &tables::trials(&drives))?;
    put("advice.csv", &tables::advice(&drives))?;
    put("speed.csv", &tables::speed(&drives))?;
    put("conditions.csv", &tables::by_condition(&drives))?;
    put("columns.json", &tables::description(&drives))?;
    made.figures.par_iter().try_for_each(|(name, svg)| {
        put(&format!("figures/{name}"), svg)?;
        let path = out.join("figures").join(name).with_extension("png");
        let png = chart::png(svg).map_err(|why| CliError::Failed(format!("{}: {why}", path.display())))?;
        Ok::<(), CliError>(record::replace(&path, &png)?)
    })?;
    put("report.html", &made.html)?;
    out::line(format_args!(
        "{}: report.html, tables (CSV) and figures (SVG, PNG) of {} drives",
        out.display(),
        drives.len()
    ))?;
    Ok(())
}

impl From<AnalysisError> for CliError {
    fn from(error: AnalysisError) -> Self {
        match error {
            AnalysisError::Input(text) => Self::Input(text),
            AnalysisError::Record(error) => error.into(),
        }
    }
}
