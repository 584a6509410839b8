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

/// Writes a line of the log: level, module, and the message with control characters escaped.
fn line(to: &mut env_logger::fmt::Formatter, record: &log::Record<'_>) -> std::io::Result<()> {
    let style = to.default_level_style(record.level());
    let words = record.args().to_string();
    writeln!(to, "[{style}{:<5}{style:#} {}] {}", record.level(), record.target(), codrive::cli::visible(&words))
}
