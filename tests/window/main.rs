//! The program in real windows on a real X server (Xvfb).

mod display;
mod drive;
mod keys;
mod kills;
mod led;
mod picture;
mod traffic;
mod visit;
mod wheel;
mod xserver;
