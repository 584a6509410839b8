//! Tests of pictures by their pixels: the picture shows what the simulation says. The tests check regions and properties, as whole images
//! differ between graphics drivers. All tests share one graphics device; without one they fail.

mod cars;
mod cockpit;
mod costs;
mod daylight;
mod dial;
mod ground;
mod light;
mod network;
mod night;
mod people;
mod pixels;
mod place;
mod plates;
mod poses;
mod rain;
mod town;
mod trees;
