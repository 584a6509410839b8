//! **codrive**: a driving simulator for studies of people in traffic, in one program with one clock.
//!
//! wheel → ego physics ([`ego`], rapier) → traffic ([`traffic`], SUMO in process) → policy ([`policy`]) → advice on the
//! speedometer ([`hud`]) → picture ([`render`], wgpu).
//!
//! codrive was built for the study of **HC22**: Hasan, Chakraborty, Wu, Driggs-Campbell, "Towards Co-operative Congestion
//! Mitigation" (arXiv 2302.09140). Comments cite works and figures of `docs/references.md` by author and year or by topic, and
//! reasons of `docs/decisions.md` by number.
//!
//! # Words
//! * **tick**: 10 ms of simulation, the step of the ego's physics ([`time::Tick`]). **step**: 0.1 s (ten ticks; a
//!   scenario may change it), the step of traffic and policy. **hold**: duration of one advice, a whole number of
//!   steps. **frame**: one picture. **space**: a frame of reference ([`space`]).
//! * **ego**: the participant's own vehicle. **traffic**: all other vehicles. **leader/follower**: the vehicle ahead/behind
//!   in the lane.
//! * **network**: all roads of a file. **edge**: lanes side by side in one direction. **lane**: a centre line with width, speed limit and
//!   permissions. **junction**: an area where lanes meet, crossed on **internal lanes**. **connection**: from lane to lane, with right of way
//!   and signal. **signal**: a program of phases over links ([`map::network`]).
//! * **lane position**: lane, declared metres from its start, offset to the left. **path**: consecutive lanes, open or closed.
//!   **route**: the path that the ego drives ([`map::Route`]). **demand**: the vehicles that enter a network, with origin and destination.
//! * **gap**: own front bumper to the leader's rear bumper. **headway**: front bumper to front bumper (SAE J2944).
//! * **action**: the output of a policy, an acceleration or a speed. **advice**: the target shown to the driver with
//!   its acceptable **range**, its issue time and its hold ([`policy::Advice`]).
//! * **agent**: a vehicle with its own driver, pedals, advice and view: the participant's, and every other advised vehicle
//!   ([`sim::Agent`]).
//! * **trait**: a characteristic of a driver: reaction time, bias, error, time gap, willingness. **teacher**: a policy in training
//!   that observes the driver's traits; **estimator**: a network that estimates them from the driver's behaviour; **student**: a policy
//!   that observes the estimates ([`policy::identification`]).
//! * **episode**: a ring or a whole drive that a learner advises, from a seed to its end ([`drive_loop::episode`]).
//! * **scenario**: everything that defines a drive: map, traffic, policy, driver, display, seed, duration
//!   ([`scenario::Scenario`]). **planned drive**: a scenario with its road, loaded once ([`scenario::PlannedDrive`]).
//!
//! # Layers, bottom first
//! A module names only modules of lower rows (`tests/layers.rs` checks `src/`). The rows up to `hud` are a package of their own,
//! `codrive-core` (`src/core.rs`, `src/Cargo.toml`), so that an edit above them does not build them again (docs/decisions.md: 17):
//! ```text
//! space  time  units  rng      frames of reference / Tick, Clock, Pace / SI inside, mph outside / seeded streams
//! idm  controls  plot  file    car-following model / pedals, wheel, selector / figures as SVG and PNG / bounded reading of files
//! foreign  private  toml_text  panics of libraries as errors / files private to the user / faults in TOML
//! native_code optimal_velocity places of libraries and programs / car-following model of people
//! anticipation  latin_letters  a leader as a driver anticipates it who sees it late / letters of names (these five lines are one row)
//! temporary  lsl               folders for temporary files / Lab Streaming Layer: streams of this program and of other devices
//! data_folders  settings       folders of maps, policies, questionnaires / a struct as file, flags and widgets
//! triggers  sumo_xml           bytes on a serial port, for amplifiers / checks of SUMO's input files (in one row with the line above)
//! map                          road networks as data: SUMO net.xml, parametric rings; lane <-> world
//! roadside                     what stands beside roads: asphalt, towns, land, buildings, rails; boxes that a car cannot pass
//! ego  policy                  rapier car, Controls in / Observation -> Action; hold; controllers; networks
//! traffic  metrics             trait Traffic: SUMO, native IDM / results of a drive, means with intervals, figures
//! snapshot                     the world at one tick, seen from one vehicle
//! driver                       simulated drivers: perception, pedals, steering, decisions on networks
//! scenario                     everything that defines a drive, as a file, flags and widgets
//! sim  train                   World::tick(&Controls) -> Events, Snapshot / TRPO on the fast ring
//! hud                          the dial as data; the last row of the package codrive-core
//! scene  record  audio         contents of the picture, on the CPU / every tick on disk: journal, tables, manifest / sound
//! input  signing               devices -> Controls / signatures by a key of the lab (in one row with the line above)
//! render  analysis             wgpu passes / plan of the analysis, measures, mixed models, power, figures, report
//! study                        study files, orders, sessions, questionnaires, data set, preregistration
//! panel  doctor  drive_loop    egui: panels and pages / fitness of a rig for a study / the loop without a window: off-line drives,
//!                              rehearsals, episodes
//! live_drive  sweep            a drive with a person: devices, picture and sound / many runs from one plan
//! desktop                      windows, displays, keys, the event loop
//! replay  drive_window         a recording driven again and proven / `codrive drive`
//! session                      a participant's session of a study (in one row with the line above)
//! bench                        measurements of this program on this machine
//! cli  main                    the command line
//! ```
//! Nothing below `render` uses wgpu, winit or egui, except `plot`, which uses egui for its fonts. Other libraries are used by one
//! module only: gilrs and evdev by `input`, SUMO by `traffic::sumo`, rapier by `ego`, Arrow and Parquet by `record`, liblsl by `lsl`,
//! resvg and skrifa by `plot`, and cpal, fundsp and hound by `audio`.
//!
//! # Conventions
//! World axes are SUMO's: x east, y north, z up, metres; angles in radians, counter-clockwise, yaw 0 = east. `f64` in
//! map and traffic, `f32` in physics and picture. Seconds, metres, m/s inside; mph and km/h only at the edge
//! ([`units`]). The same seed and inputs give the same bits: named random streams ([`rng`]), no wall clock below [`drive_loop`].

// println! panics if its reader has gone; `cli::out` prints instead.
#![deny(clippy::print_stdout, clippy::print_stderr)]

pub use codrive_core::*;

pub mod analysis;
#[cfg(feature = "desktop")]
pub mod audio;
#[cfg(feature = "desktop")]
pub mod bench;
#[cfg(feature = "command")]
pub mod cli;
#[cfg(feature = "desktop")]
pub mod desktop;
#[cfg(feature = "desktop")]
pub mod doctor;
pub mod drive_loop;
#[cfg(feature = "desktop")]
pub mod drive_window;
#[cfg(feature = "desktop")]
pub mod input;
#[cfg(feature = "desktop")]
pub mod live_drive;
#[cfg(feature = "desktop")]
pub mod panel;
pub mod record;
#[cfg(feature = "desktop")]
pub mod render;
#[cfg(feature = "command")]
pub mod replay;
#[cfg(feature = "desktop")]
pub mod scene;
#[cfg(feature = "desktop")]
pub mod session;
#[cfg(feature = "command")]
pub mod signing;
pub mod study;
pub mod sweep;
