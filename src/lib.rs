//! **codrive**: a driving simulator for studies of people in traffic, in one program with one clock.
//!
//! wheel → ego physics ([`ego`], rapier) → traffic ([`traffic`], SUMO in process) → policy ([`policy`]) → advice on the
//! speedometer ([`hud`]) → picture ([`render`], wgpu).
//!
//! It was built for the study of **HC22**: Hasan, Chakraborty, Wu, Driggs-Campbell, "Towards Co-operative Congestion
//! Mitigation" (arXiv 2302.09140). Works and figures that comments cite are in `docs/references.md`, by author and year or by
//! topic; reasons are in `docs/decisions.md`, by number.
//!
//! # Words
//! * **tick**: 10 ms of simulation, the step of the ego's physics ([`time::Tick`]). **step**: 0.1 s (ten ticks; a
//!   scenario may change it), the step of traffic and policy. **hold**: how long one advice stands, a whole number of
//!   steps. **frame**: one picture. **space**: a frame of reference ([`space`]).
//! * **ego**: the participant's car. **traffic**: all other cars. **leader/follower**: the car ahead/behind in the lane.
//! * **network**: all roads of a file. **edge**: lanes side by side in one direction. **lane**: a centre line with width, speed limit and
//!   permissions. **junction**: an area where lanes meet, crossed on **internal lanes**. **connection**: from lane to lane, with right of way
//!   and signal. **signal**: a program of phases over links ([`map::network`]).
//! * **lane position**: lane, declared metres from its start, offset to the left. **path**: lanes that follow each other, open or closed.
//!   **route**: the path that the ego drives ([`map::Route`]). **demand**: which vehicles come to a network, where from and where to.
//! * **gap**: own front bumper to the leader's rear bumper. **headway**: front bumper to front bumper (SAE J2944).
//! * **action**: what a policy puts out, an acceleration or a speed. **advice**: the target shown to the driver with
//!   its acceptable **range**, its issue time and its hold ([`policy::Advice`]).
//! * **agent**: a vehicle with physics, advice and a view of its own: the participant's, and every other that is advised
//!   ([`sim::Agent`]).
//! * **trait**: what sets one driver apart: reaction time, bias, error, time gap, willingness. **teacher**: a policy in training
//!   that is told the driver's traits; **estimator**: what tells them from what the driver does; **student**: a policy that is
//!   told the estimates ([`policy::identification`]).
//! * **episode**: a ring or a whole drive that a learner advises, from a seed to its end ([`drive_loop::episode`]).
//! * **scenario**: everything that makes one drive: map, traffic, policy, driver, display, seed, duration
//!   ([`scenario::Scenario`]).
//!
//! # Layers, bottom first
//! A module names only modules of lower rows (`tests/layers.rs` walks `src/` and fails otherwise):
//! ```text
//! space  time  units  rng  idm frames of reference / Tick, Clock, Pace / SI inside, mph outside / seeded streams
//! controls  plot  file         / the car-following model / pedals, wheel, selector / figures as SVG and PNG / files read
//! foreign  private  toml_text  within limits / panics of libraries that read them as errors / files written for the user
//! temporary  native_code  lsl  alone / mistakes in TOML / folders for temporary files / places of libraries and programs of others / Lab
//!                              Streaming Layer: streams of this program and of other devices
//! data_folders  settings       where maps, policies, questionnaires lie on this machine / a struct as file, flags, widgets /
//! triggers  signing            bytes on a serial port, for amplifiers / signatures of files by a key of the lab / the gate in front of
//! sumo_xml                     SUMO: what its files may hold
//! map                          road networks as data: SUMO net.xml, parametric rings; lane <-> world
//! ego  policy                  rapier car, Controls in / Observation -> Action; hold; controllers; networks
//! input  traffic  driver       devices -> Controls / trait Traffic: SUMO, native IDM / simulated drivers
//! metrics                      results of a drive, means with intervals, figures
//! scenario                     everything that makes one drive, as a file, flags and widgets
//! sim  train                   World::tick(&Controls) -> Events, Snapshot / TRPO on the fast ring
//! hud                          the dial as data
//! scene  record  audio         what is to be seen, on the CPU / every tick on disk: journal, tables, manifest / sound
//! render  analysis             wgpu passes / plan of the analysis, measures, mixed models, power, figures, report
//! study                        study files, orders, sessions, questionnaires, data set, preregistration
//! panel  doctor  drive_loop    egui: panels and pages / is this rig fit for a study / the one loop without a window:
//!                              off-line drives, rehearsals, episodes
//! live_drive  sweep            a drive with a person in it: devices in, what is seen and heard out / many runs from one plan
//! desktop                      windows, displays, keys, the event loop
//! replay  drive_window         a recording driven again and proven / `codrive drive` / a participant's session of a study
//! session
//! bench                        measurements of this program on this machine
//! cli  main
//! ```
//! Nothing below `render` knows wgpu, winit or egui; nothing but `input` knows gilrs and evdev; nothing but
//! `traffic::sumo` knows SUMO; nothing but `ego` knows rapier; nothing but `record` knows
//! Arrow and Parquet; nothing but `lsl` knows liblsl; nothing but `plot` knows resvg and skrifa (and of egui the fonts);
//! nothing but `audio` knows cpal, fundsp and hound.
//!
//! # Conventions
//! World axes are SUMO's: x east, y north, z up, metres; angles in radians, counter-clockwise, yaw 0 = east. `f64` in
//! map and traffic, `f32` in physics and picture. Seconds, metres, m/s inside; mph and km/h only at the edge
//! ([`units`]). Same seed, same inputs, same bits: named random streams ([`rng`]), no wall clock below [`drive_loop`].

// println! ends the program with a panic where its reader has gone; cli::out says what there is to say.
#![deny(clippy::print_stdout, clippy::print_stderr)]

pub mod analysis;
#[cfg(feature = "desktop")]
pub mod audio;
#[cfg(feature = "desktop")]
pub mod bench;
#[cfg(feature = "command")]
pub mod cli;
pub mod controls;
pub mod data_folders;
#[cfg(feature = "desktop")]
pub mod desktop;
#[cfg(feature = "desktop")]
pub mod doctor;
pub mod drive_loop;
#[cfg(feature = "desktop")]
pub mod drive_window;
pub mod driver;
pub mod ego;
pub mod file;
pub mod foreign;
pub mod hud;
pub mod idm;
#[cfg(feature = "desktop")]
pub mod input;
#[cfg(feature = "desktop")]
pub mod live_drive;
pub mod lsl;
pub mod map;
pub mod metrics;
pub mod native_code;
#[cfg(feature = "desktop")]
pub mod panel;
pub mod plot;
pub mod policy;
pub mod private;
pub mod record;
#[cfg(feature = "desktop")]
pub mod render;
#[cfg(feature = "command")]
pub mod replay;
pub mod rng;
pub mod scenario;
#[cfg(feature = "desktop")]
pub mod scene;
#[cfg(feature = "desktop")]
pub mod session;
pub mod settings;
#[cfg(feature = "command")]
pub mod signing;
pub mod sim;
pub mod space;
pub mod study;
pub mod sumo_xml;
pub mod sweep;
pub mod temporary;
pub mod time;
pub mod toml_text;
pub mod traffic;
pub mod train;
pub mod triggers;
pub mod units;
