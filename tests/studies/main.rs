//! Studies: plan, order, sessions, rehearsals and their data set. In: small studies on the native engine. Out: files that outside readers
//! and validators accept.

mod bids;
mod common;
mod damage;
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
