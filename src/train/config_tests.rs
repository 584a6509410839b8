//! The file of a training's configuration: its form, and faults with their line.

use super::*;
use crate::settings;

#[test]
fn the_file_has_no_groups() {
    let reward = RewardConfig { kind: RewardKind::Ego, ..RewardConfig::default() };
    let text = toml::to_string(&TrainConfig { reward, ..TrainConfig::default() }).expect("a file");
    let tables: Vec<&str> = text.lines().filter(|line| line.starts_with('[')).collect();
    assert_eq!(tables, ["[idm]", "[scaling]"]);
    assert!(text.starts_with("action = \"acceleration\"\nlevels = 0\n"), "{text}");
    assert!(text.contains("\nreward = \"ego\"\naction_penalty = 0.0\n"), "{text}");
    let read: TrainConfig = settings::from_toml(&text, "train.toml").expect("its own file");
    assert_eq!(read.reward.kind, RewardKind::Ego);
    let refused = |text: &str| settings::from_toml::<TrainConfig>(text, "train.toml").expect_err(text).message;
    assert!(refused("seed = 1\n[ring]\n").starts_with("train.toml:2:2: unknown key `ring`; did you mean `rings`?"));
    assert!(refused("kind = \"ego\"").starts_with("train.toml:1:1: unknown key `kind`"));
    assert!(refused("estimator_rounds = 5").contains("estimator_rounds is 5; allowed: 0 if sees names no input"));
    assert!(
        refused(
            "\n\
            step_s = 0.025"
        )
        .starts_with("train.toml:2:10: step_s is 0.025; allowed: a multiple of 0.01 s")
    );
    assert!(refused("probe_mps = 0.2").starts_with("train.toml:1:13: probe_mps is 0.2; allowed: 0 if action is"));
    assert!(refused("\nhold_s = 0.25").starts_with("train.toml:2:10: hold_s is 0.25; allowed: a whole number"));
}
