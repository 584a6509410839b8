//! Statistical models. In: analysed drives and the plan in the study's file. Out: planned differences between conditions, and
//! the power of a plan.
//!
//! * [`distributions`], [`normality`], [`mixed_design`], [`mixed_model`]: statistics.
//! * [`plan`], [`exclusion_rules`], [`one_or_more`], [`planned`]: the analysis planned in the study's file, and its results;
//!   [`power`]: how often a plan detects an effect.

pub mod distributions;
pub mod exclusion_rules;
pub mod mixed_design;
pub mod mixed_model;
pub mod normality;
pub mod one_or_more;
pub mod plan;
pub mod planned;
pub mod power;
