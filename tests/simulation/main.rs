//! The simulation from the outside: car, simulated drivers, policies, networks of other programs, training, world. In: the library's public
//! types. Out: figures that a reference, another program or a closed form gives as well.

mod agents;
mod agents_network;
mod automation;
mod crossings;
mod driver;
mod ego;
mod episode;
mod event_actions;
mod event_stimuli;
mod events;
mod fixed_objects;
mod hills;
mod lanes_beside;
mod light_agents;
mod logged;
mod network;
mod no_participant;
mod obstacles;
#[cfg(feature = "onnx")]
mod onnx;
mod openscenario;
mod people_of_events;
mod persons;
mod policies;
mod python_episode;
mod questions;
mod rain;
mod right_of_way;
mod road_users;
mod train;
#[cfg(feature = "desktop")]
mod wheels_on_road;
mod world;
