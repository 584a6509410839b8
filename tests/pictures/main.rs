//! Pictures by their pixels: what is seen is what the simulation says. Regions and properties rather than whole images,
//! which differ between drivers. All tests share one device; without one they fail.

mod cars;
mod cockpit;
mod costs;
mod daylight;
mod dial;
mod ground;
mod light;
mod network;
mod pixels;
mod place;
mod plates;
mod poses;
mod trees;
