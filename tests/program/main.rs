//! The program as its users call it: arguments, messages, places of its data, and files that it writes. In: the built program and temporary
//! folders. Out: exit codes, messages, files.

mod advised;
mod anywhere;
mod benchmark;
mod cli;
mod film;
mod graphics;
mod hostile_texts;
mod interrupts;
mod packaging;
mod portable;
mod roads;
#[cfg(feature = "desktop")]
mod schemas;
mod sweep;
#[cfg(feature = "tune")]
mod tune;
mod validate;
