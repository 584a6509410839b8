//! The planned analysis against another program (R with lme4 and lmerTest, as `scripts/setup --test` installs them), and a study from its
//! plan to its report.

use crate::common::{codrive, study, table, text};
use codrive::analysis::models::{
    mixed_model::{ContrastEstimate, MixedModel},
    normality::shapiro_wilk,
};
use std::{collections::BTreeMap, fs, path::Path, process::Command};

/// Runs a script in R and returns its standard output.
fn r(script: &str) -> String {
    let output = Command::new("Rscript").args(["--vanilla", "-e", script]).output();
    let output = output.unwrap_or_else(|e| panic!("Rscript: {e}; scripts/setup --test installs it"));
    assert!(output.status.success(), "{}", text(&output));
    String::from_utf8(output.stdout).unwrap()
}

fn numbers(line: &str) -> Vec<f64> {
    line.split_whitespace().map(|word| word.parse().unwrap_or_else(|e| panic!("{word}: {e}: {line}"))).collect()
}

fn near(found: f64, known: f64, share: f64) -> bool {
    (found - known).abs() <= share * known.abs().max(1e-12)
}

/// Fits a mixed model to a table of R (participant, covariate, response). Returns the model, lmerTest's row of each coefficient, and the
/// standard deviations, REML criterion and Shapiro-Wilk test of R.
fn compared(data: &str) -> (MixedModel, Vec<Vec<f64>>, Vec<f64>) {
    let script = format!(
        "suppressMessages(library(lmerTest)); options(digits = 15); {data}; d$g <- as.integer(factor(d$g)) - 1L; \
         cat(d$g, '\\n'); cat(format(d$x, digits = 17), '\\n'); cat(format(d$y, digits = 17), '\\n'); \
         m <- lmer(y ~ x + (1 | g), d, control = lmerControl(optCtrl = list(ftol_abs = 1e-12, xtol_abs = 1e-12))); \
         s <- summary(m)$coefficients; cat(s[1, ], '\\n'); cat(s[2, ], '\\n'); v <- as.data.frame(VarCorr(m))$sdcor; \
         w <- shapiro.test(residuals(m)); cat(v, REMLcrit(m), w$statistic, w$p.value, '\\n')"
    );
    let printed = r(&script);
    let lines: Vec<Vec<f64>> = printed.lines().map(numbers).collect();
    let participant_of_row: Vec<usize> = lines[0].iter().map(|n| *n as usize).collect();
    let model = MixedModel::fit(&participant_of_row, &[lines[1].clone()], &lines[2]).unwrap();
    (model, vec![lines[3].clone(), lines[4].clone()], lines[5].clone())
}

fn agrees(found: &ContrastEstimate, known: &[f64]) {
    // Estimate, standard error, degrees of freedom, t, p, as lmerTest prints them.
    let all = [found.estimate, found.se, found.df, found.t, found.p];
    for (found, known) in all.iter().zip(known) {
        assert!(near(*found, *known, 1e-3) || known.abs() < 1e-30, "{all:?} {known}");
    }
}

/// Example of lme4's own documentation, reaction times by days without sleep (R's data set `sleepstudy`). It prints an intercept of
/// 251.405, 10.467 a day, and deviations of 37.12 between and 30.99 within persons.
#[test]
fn the_published_example_of_a_random_intercept_has_its_printed_figures() {
    let (model, terms, more) = compared("d <- setNames(lme4::sleepstudy, c('y', 'x', 'g'))");
    assert!(near(model.estimates[0], 251.405, 2e-6) && near(model.estimates[1], 10.467, 3e-5), "{:?}", model.estimates);
    assert!(near(model.sd_participant, 37.12, 2e-4) && near(model.sd_residual, 30.99, 2e-4), "{model:?}");
    assert!((model.criterion - 1786.5).abs() < 0.05, "{}", model.criterion);
    agrees(&model.term(0), &terms[0]);
    agrees(&model.term(1), &terms[1]);
    assert!(near(model.criterion, more[2], 1e-6), "{} {}", model.criterion, more[2]);
    let test = shapiro_wilk(&model.residuals).unwrap();
    assert!(near(test.w, more[3], 1e-3) && near(test.p, more[4], 1e-2), "{test:?} {more:?}");
}

/// Participants with one to ten rows each, whose covariate also differs between them: no closed form exists.
#[test]
fn unbalanced_data_give_the_results_of_lmertest() {
    let (model, terms, more) = compared(
        "d <- setNames(lme4::sleepstudy, c('y', 'x', 'g')); d <- d[(seq_len(180) * 7) %% 11 < 6, ]; d <- d[-(1:9 * 3), ]",
    );
    agrees(&model.term(0), &terms[0]);
    agrees(&model.term(1), &terms[1]);
    assert!(near(model.sd_participant, more[0], 1e-3) && near(model.sd_residual, more[1], 1e-3), "{model:?} {more:?}");
    assert!(near(model.criterion, more[2], 1e-6));
}

const PLAN: &str = r#"
[analysis]
primary = "mean_speed_mps"
smallest_effect = 0.1
secondary = ["speed_error_mps"]
covariates = ["hand_over_speed_sd_over_vehicles_mps"]
contrasts = [{ condition = "wide", reference = "narrow" }, { condition = "middle", reference = "narrow" }]
[analysis.exclude]
least_recorded_share = 0.9
"#;

fn succeeded(arguments: &[&str]) -> String {
    let output = codrive(arguments, "warn");
    assert!(output.status.success(), "{}", text(&output));
    text(&output)
}

#[test]
fn a_planned_and_rehearsed_study_is_analysed_as_planned_and_as_r_does() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (file, data) = (at("study.toml"), at("data"));
    fs::write(&file, study(20.0, 2.0, ["workload", "raw-tlx"]) + PLAN).unwrap();
    let rehearse = ["study", "rehearse", &file, "--population", "people", "--out", &data];
    succeeded(&rehearse);
    // Each participant is drawn from the population; the data set has the true values.
    let people = table(Path::new(&at("data/participants.tsv")));
    let mut reactions: Vec<&str> = people.iter().map(|row| row["true_reaction_s"].as_str()).collect();
    reactions.sort_unstable();
    reactions.dedup();
    assert_eq!((people.len(), reactions.len()), (6, 6));
    assert!(people.iter().all(|row| ["0", "1"].contains(&row["true_compliance"].as_str())), "{people:?}");
    assert!(people.iter().all(|row| row["true_time_gap_factor"].parse::<f64>().unwrap() > 0.6), "{people:?}");

    let plan = succeeded(&["study", "preregister", &file, "--rehearsed", &data]);
    for part in ["# Preregistration: Short", "6 simulated participants", "| **6** | 0.1 m/s |", "* Primary: Mean speed"]
    {
        assert!(plan.contains(part), "{part}\n{plan}");
    }
    succeeded(&["study", "preregister", &file, "--participants", "12", "--out", &at("plan.md")]);
    assert!(fs::read_to_string(at("plan.md")).unwrap().contains("With 12 participants every order is used 2 times."));
    let again = codrive(&["study", "preregister", &file, "--out", &at("plan.md")], "warn");
    assert!(
        !again.status.success() && text(&again).contains("a registered plan is not overwritten"),
        "{}",
        text(&again)
    );

    let analysed = succeeded(&["analyse", &data]);
    let lines: Vec<&str> = analysed.lines().collect();
    assert!(lines.len() == 2 && lines[0].starts_with("consistent, not authentic"), "{analysed}");
    let report = || fs::read_to_string(at("data/derivatives/codrive/report.html")).unwrap();
    assert!(report().contains("The plan has not changed since the first session."));
    assert!(fs::read_to_string(at("data/derivatives/codrive/methods.txt")).unwrap().contains("linear mixed model"));
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/analysis/read_study.R");
    let output = Command::new("Rscript").arg(script).arg(&data).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    let [ours, theirs] =
        ["models.csv", "models_r.csv"].map(|name| unquoted(&Path::new(&at("data/derivatives/codrive")).join(name)));
    assert_eq!((ours.len(), theirs.len()), (8, 8), "{}", text(&output));
    for (one, other) in ours.iter().zip(&theirs) {
        for column in ["outcome", "kind", "condition", "reference", "participants", "trials"] {
            assert_eq!(one[column], other[column], "{column}");
        }
        for column in
            ["estimate", "se", "df", "t", "p", "p_holm", "low", "high", "sd_participant", "sd_residual", "residual_w"]
        {
            let [a, b] = [one, other].map(|row| row[column].parse::<f64>().unwrap_or(-1.0));
            assert!(near(a, b, 1e-3) || (a - b).abs() < 1e-9, "{} {} {column}: {a} {b}", one["outcome"], one["kind"]);
        }
    }

    // A change after the first session: in a later file, and in a session that ran with it.
    fs::write(at("later.toml"), study(20.0, 2.0, ["workload", "raw-tlx"]) + &PLAN.replace("= 0.1", "= 0.3")).unwrap();
    succeeded(&["analyse", &data, "--study", &at("later.toml")]);
    assert!(report().contains("smallest_effect: planned 0.1, now 0.3."));
    succeeded(&["study", "rehearse", &at("later.toml"), "--population", "people", "--out", &data]);
    succeeded(&["analyse", &data]);
    assert!(report().contains("smallest_effect: planned 0.1, now 0.3."));
    succeeded(&rehearse);
    succeeded(&["analyse", &data]);
    assert!(report().contains("The plan has not changed since the first session."));
    // A participant excluded after the session is reported with the models; the exclusion does not count as an alteration.
    succeeded(&["study", "exclude", &file, "R02", "--reason", "fell asleep", "--from", &data]);
    succeeded(&["analyse", &data]);
    let left_out = fs::read_to_string(at("data/derivatives/codrive/left_out.csv")).unwrap();
    assert!(left_out.ends_with("\nsub-R02,,,,excluded by the experimenter: fell asleep\n"), "{left_out}");
    assert!(fs::read_to_string(at("data/derivatives/codrive/models.csv")).unwrap().contains(",5,15,"));
    // Any other change makes another study.
    fs::write(at("other.toml"), study(21.0, 2.0, ["workload", "raw-tlx"]) + PLAN).unwrap();
    let other = codrive(&["study", "rehearse", &at("other.toml"), "--out", &data], "warn");
    assert!(
        !other.status.success() && text(&other).contains("differs from the study of this data set"),
        "{}",
        text(&other)
    );
}

/// Reads a table that R wrote, without the quotes around its words.
fn unquoted(path: &Path) -> Vec<BTreeMap<String, String>> {
    let rows = table(path).into_iter();
    let bare = |text: String| text.trim_matches('"').to_owned();
    rows.map(|row| row.into_iter().map(|(key, value)| (bare(key), bare(value))).collect()).collect()
}

#[test]
fn a_wrong_plan_is_refused_with_its_line_and_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("study.toml");
    let good = study(20.0, 2.0, ["workload", "raw-tlx"]);
    for (plan, has) in [
        (
            PLAN.replace("\"wide\"", "\"wid\""),
            ":39:28: there is no condition \"wid\" (did you mean wide?); allowed: narrow, middle, wide",
        ),
        (PLAN.replace("mean_speed_mps", "mean_sped"), ":35:11: there is no measure \"mean_sped\""),
        (PLAN.replace("smallest_effect", "smalest_effect"), "did you mean `smallest_effect`?"),
    ] {
        fs::write(&file, good.clone() + &plan).unwrap();
        let output = codrive(&["study", "check", file.to_str().unwrap()], "warn");
        assert!(!output.status.success() && text(&output).contains(has), "{has}\n{}", text(&output));
    }
    fs::write(&file, good).unwrap();
    let output = codrive(&["study", "preregister", file.to_str().unwrap()], "warn");
    assert!(!output.status.success() && text(&output).contains("has no [analysis]"), "{}", text(&output));
}
