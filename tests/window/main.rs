//! Tests of the program in real windows on a real X server (Xvfb).

mod anywhere;
mod display;
mod drive;
mod environment;
mod keys;
mod kills;
mod led;
mod live_session;
mod picture;
mod traffic;
mod wheel;
mod xserver;
