//! **codrive-core**: the rows of [`codrive`](../codrive/index.html) up to `hud`. In: scenarios, maps, policies, controls. Out: the world
//! tick by tick, trained networks, figures; nothing drawn, recorded or heard. `codrive` re-exports all of it (docs/decisions.md: 17).

// println! panics if its reader has gone; `cli::out` prints instead.
#![deny(clippy::print_stdout, clippy::print_stderr)]

pub mod anticipation;
pub mod controls;
pub mod data_folders;
pub mod driver;
pub mod ego;
pub mod file;
pub mod foreign;
pub mod hud;
pub mod idm;
pub mod latin_letters;
pub mod lsl;
pub mod map;
pub mod metrics;
pub mod native_code;
pub mod optimal_velocity;
pub mod plot;
pub mod policy;
pub mod private;
pub mod rng;
pub mod roadside;
pub mod scenario;
pub mod settings;
pub mod sim;
pub mod snapshot;
pub mod space;
pub mod sumo_xml;
pub mod temporary;
pub mod time;
pub mod toml_text;
pub mod traffic;
pub mod train;
pub mod triggers;
pub mod units;
