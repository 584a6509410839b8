//! The timetable of a training. In: a [`TrainConfig`] and how many iterations are done. Out: what is learned next.
//!
//! First the policy learns: of traits from a teacher who knows them, of latents nothing, for nobody can tell it any. Then the
//! estimator learns, then the policy on what the estimator says, and so on in turn.

use super::TrainConfig;
use crate::policy::{FEATURES, Feature, LATENTS};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What an estimator of the driver learns to tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum EstimatorKind {
    /// Traits with a name, from drivers whose traits are known
    #[default]
    Traits,
    /// Latents of a variational encoder, from nothing but what drivers do next
    Variational,
}

/// What an iteration is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lesson {
    /// The policy learns; a teacher tells it who drives, or nobody does.
    Teacher,
    /// A student learns to tell who drives.
    Estimator,
    /// The policy learns; the student tells it who drives.
    Student,
}

impl TrainConfig {
    /// All lessons and their iterations, in order.
    pub fn lessons(&self) -> Vec<(Lesson, u32)> {
        let mut lessons = vec![(Lesson::Teacher, self.run.iterations)];
        let student = &self.student;
        if student.estimator_rounds > 0 {
            lessons.push((Lesson::Estimator, student.estimator_rounds));
            lessons.push((Lesson::Student, student.student_iterations));
        }
        lessons
    }

    /// Updates and rounds of all lessons together.
    pub fn all_iterations(&self) -> u32 {
        self.lessons().iter().map(|(_, iterations)| iterations).sum()
    }

    /// The lesson after so many iterations, and whether it begins with the next. Whoever goes on after the last stays with it.
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

    /// True of the last iteration of a lesson, counted from 1.
    pub fn ends_lesson(&self, iteration: u32) -> bool {
        let mut end = 0;
        self.lessons().iter().any(|(_, iterations)| {
            end += iterations;
            end == iteration
        })
    }

    /// Iterations of such lessons among the first `done`.
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

    /// Share of the updates of a policy that is done after so many iterations, by which the bound on an update falls. A policy
    /// that had a teacher has learned most when the student comes, and goes on with the bound that it ended with.
    pub fn share_of_updates(&self, done: u32) -> f64 {
        let all = match self.student.estimator {
            EstimatorKind::Traits => return (f64::from(done) / f64::from(self.run.iterations)).min(1.0),
            EstimatorKind::Variational if self.student.estimator_rounds == 0 => self.run.iterations,
            EstimatorKind::Variational => self.run.iterations + self.student.student_iterations,
        };
        let updates = self.done_of(Lesson::Teacher, done) + self.done_of(Lesson::Student, done);
        (f64::from(updates) / f64::from(all)).min(1.0)
    }

    /// What of the driver the policy may see with this kind of estimator.
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
