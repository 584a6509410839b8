//! The simulation from the outside: the car, simulated drivers, policies and networks of others, training, the world. In: the
//! library's public types. Out: numbers that a reference, another program or a closed form gives as well.

mod agents;
mod agents_network;
mod driver;
mod ego;
mod episode;
mod give_way;
mod hills;
mod lanes_beside;
mod network;
mod no_participant;
mod obstacles;
#[cfg(feature = "onnx")]
mod onnx;
mod policies;
mod python_episode;
mod train;
mod world;
