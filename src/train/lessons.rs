//! The schedule of a training. In: a [`TrainConfig`] and the number of iterations done. Out: the next lesson.
//!
//! First the policy learns: with traits from a teacher that is given the true ones, with latents without any, as they do not exist yet.
//! Then the estimator learns, then the policy with its estimates, and so on alternately.

use super::TrainConfig;
use crate::policy::{FEATURES, Feature, LATENTS};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Quantities that a driver estimator learns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum EstimatorKind {
    /// Named traits, from drivers with known traits
    #[default]
    Traits,
    /// Latents of a variational encoder, learned only from what drivers do next
    Variational,
}

/// Subject of an iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lesson {
    /// An update of the policy with the true traits as inputs, or without any estimate.
    Teacher,
    /// A round of the driver estimator.
    Estimator,
    /// An update of the policy with the estimates as inputs.
    Student,
}

impl TrainConfig {
    /// Returns all lessons with their numbers of iterations, in order.
    pub fn lessons(&self) -> Vec<(Lesson, u32)> {
        let mut lessons = vec![(Lesson::Teacher, self.run.iterations)];
        let student = &self.student;
        if student.estimator_rounds > 0 {
            lessons.push((Lesson::Estimator, student.estimator_rounds));
            lessons.push((Lesson::Student, student.student_iterations));
        }
        lessons
    }

    /// Returns the number of updates and rounds of all lessons.
    pub fn all_iterations(&self) -> u32 {
        self.lessons().iter().map(|(_, iterations)| iterations).sum()
    }

    /// Returns the lesson after `done` iterations, and true if it begins with the next one. After the end the last lesson continues.
    pub fn lesson_after(&self, done: u32) -> (Lesson, bool) {
        let mut begins = 0;
        for (lesson, iterations) in self.lessons() {
            if done < begins + iterations {
                return (lesson, done == begins);
            }
            begins += iterations;
        }
        let last = if self.student.estimator_rounds > 0 { Lesson::Student } else { Lesson::Teacher };
        (last, false)
    }

    /// Returns true for the last iteration of a lesson; iterations count from 1.
    pub fn ends_lesson(&self, iteration: u32) -> bool {
        let mut end = 0;
        self.lessons().iter().any(|(_, iterations)| {
            end += iterations;
            end == iteration
        })
    }

    /// Returns the iterations of lesson kind `of` among the first `done`.
    pub fn done_of(&self, of: Lesson, done: u32) -> u32 {
        let mut left = done;
        let mut count = 0;
        for (lesson, iterations) in self.lessons() {
            let here = left.min(iterations);
            left -= here;
            count += if lesson == of { here } else { 0 };
        }
        count
    }

    /// Returns the share of policy updates done, by which the bound on an update falls. A policy with a teacher has learned most before
    /// the student begins, and keeps the final bound after that.
    pub fn share_of_updates(&self, done: u32) -> f64 {
        let all = match self.student.estimator {
            EstimatorKind::Traits => return (f64::from(done) / f64::from(self.run.iterations)).min(1.0),
            EstimatorKind::Variational if self.student.estimator_rounds == 0 => self.run.iterations,
            EstimatorKind::Variational => self.run.iterations + self.student.student_iterations,
        };
        let updates = self.done_of(Lesson::Teacher, done) + self.done_of(Lesson::Student, done);
        (f64::from(updates) / f64::from(all)).min(1.0)
    }

    /// Returns the driver inputs that a policy may have with this kind of estimator.
    pub fn known_of_driver(&self) -> Vec<Feature> {
        match self.student.estimator {
            EstimatorKind::Traits => FEATURES.into_iter().filter(|f| f.is_of_driver() && !f.is_latent()).collect(),
            EstimatorKind::Variational => LATENTS[..self.student.latents as usize].to_vec(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::{RunConfig, StudentConfig};

    fn config(estimator: EstimatorKind) -> TrainConfig {
        TrainConfig {
            run: RunConfig { iterations: 4, ..RunConfig::default() },
            student: StudentConfig {
                estimator,
                estimator_rounds: 5,
                student_iterations: 6,
                ..StudentConfig::default()
            },
            ..TrainConfig::default()
        }
    }

    #[test]
    fn lessons_follow_each_other() {
        use Lesson::{Estimator, Student, Teacher};
        let config = config(EstimatorKind::Traits);
        assert_eq!(config.lessons(), [(Teacher, 4), (Estimator, 5), (Student, 6)]);
        assert_eq!(config.all_iterations(), 15);
        let begins: Vec<u32> = (0..16).filter(|done| config.lesson_after(*done).1).collect();
        assert_eq!(begins, [0, 4, 9]);
        let ends: Vec<u32> = (1..=16).filter(|iteration| config.ends_lesson(*iteration)).collect();
        assert_eq!(ends, [4, 9, 15]);
        assert_eq!((config.lesson_after(4), config.lesson_after(99)), ((Estimator, true), (Student, false)));
        assert_eq!((config.done_of(Estimator, 7), config.done_of(Student, 13)), (3, 4));
    }

    #[test]
    fn the_bound_falls_with_the_teacher_or_with_all_updates_of_a_policy_that_had_none() {
        let share = |kind, done| config(kind).share_of_updates(done);
        let traits = [0, 2, 4, 15].map(|done| share(EstimatorKind::Traits, done));
        assert_eq!(traits, [0.0, 0.5, 1.0, 1.0]);
        let latents = [0, 4, 9, 12, 15].map(|done| share(EstimatorKind::Variational, done));
        assert_eq!(latents, [0.0, 0.4, 0.4, 0.7, 1.0]);
    }
}
