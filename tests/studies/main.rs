//! Studies: plan, order, sessions and rehearsals, and the data set that comes of them. In: small studies on the native engine.
//! Out: files that outside readers and validators take.

mod bids;
mod common;
mod drivers;
mod fms;
mod hostile;
mod models;
mod people;
mod places;
mod plan_and_analysis;
mod questionnaires;
mod readers;
mod session;
mod shipped;
mod study;
mod unfinished;
