//! The program as its users call it: its arguments, its words, where it finds its data, what it writes. In: the built program and
//! folders of their own. Out: exit codes, messages, files.

mod advised;
mod anywhere;
mod benchmark;
mod cli;
mod film;
mod hostile_texts;
mod interrupts;
mod portable;
mod sweep;
#[cfg(feature = "tune")]
mod tune;
