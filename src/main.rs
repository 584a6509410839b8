//! Program entry: arguments in, exit code out.

use std::io::Write;

fn main() -> std::process::ExitCode {
    // SAFETY: no code that could start a thread has run yet.
    unsafe { codrive::cli::prepare_environment() };
    // SUMO, Mesa and the libraries of figures and networks log much that does not concern users; RUST_LOG=info shows codrive's
    // own lines.
    let quiet = "warn,wgpu_hal=off,wgpu_core=error,naga=error,tract_onnx=error,egui_extras=error,usvg=error";
    let filter = env_logger::Env::default().default_filter_or(quiet);
    env_logger::Builder::from_env(filter).format(line).init();
    codrive::record::kill_point::arm();
    codrive::cli::main(std::env::args_os()).into()
}

/// Writes a line of the log, with control characters escaped. Warnings of this program look like its errors; all other lines have level
/// and module.
fn line(to: &mut env_logger::fmt::Formatter, record: &log::Record<'_>) -> std::io::Result<()> {
    let style = to.default_level_style(record.level());
    let (words, level) = (record.args().to_string(), record.level());
    let words = codrive::cli::visible(&words);
    if level == log::Level::Warn && record.target().starts_with("codrive") {
        return writeln!(to, "codrive: {style}warning{style:#}: {words}");
    }
    writeln!(to, "[{style}{level:<5}{style:#} {}] {words}", record.target())
}
