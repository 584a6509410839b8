"""Reads the data set of a study with pandas: python read_study.py DATASET [OUT]

Needs pandas and pyarrow; with statsmodels it also fits a mixed model. Before it: codrive analyse DATASET.
Prints measures by condition, paired differences with their t statistic, and joins a recording tick by tick.
"""

import json
import sys
from pathlib import Path

import pandas as pd

MEASURES = ["mean_speed_mps", "speed_gain_mps", "time_in_range", "speed_error_mps", "reaction_s", "enter_range_s"]


def read(root: Path):
    """Trials with who drove them, answers by questionnaire, changes of the advice."""
    tsv = {"sep": "\t", "na_values": "n/a", "keep_default_na": False}
    participants = pd.read_csv(root / "participants.tsv", **tsv)
    tables = root / "derivatives" / "codrive"
    if not (tables / "trials.csv").exists():
        sys.exit(f"{tables}: no tables there; run: codrive analyse {root}")
    trials = pd.read_csv(tables / "trials.csv").merge(
        participants, left_on="participant", right_on="participant_id", validate="many_to_one"
    )
    trials = trials[trials["condition"].notna()]
    # Conditions in the study's own order.
    sidecar = next(iter(sorted(root.glob("sub-*/sub-*_scans.json"))))
    order = list(json.loads(sidecar.read_text())["condition"]["Levels"])
    trials["condition"] = pd.Categorical(trials["condition"], categories=order, ordered=True)
    phenotype = {path.stem: pd.read_csv(path, **tsv) for path in sorted((root / "phenotype").glob("*.tsv"))}
    advice = pd.read_csv(tables / "advice.csv")
    return trials, phenotype, advice


def paired(trials: pd.DataFrame, measure: str) -> pd.DataFrame:
    """Differences within participants between all pairs of conditions: mean, SD (N-1), n, t."""
    wide = trials.pivot_table(index="participant", columns="condition", values=measure, observed=True)
    rows = []
    for i, first in enumerate(wide.columns):
        for second in wide.columns[i + 1 :]:
            difference = (wide[second] - wide[first]).dropna()
            n, sd = len(difference), difference.std()
            t = difference.mean() / (sd / n**0.5) if n > 1 and sd > 0 else float("nan")
            rows.append([measure, f"{first} -> {second}", n, difference.mean(), sd, t])
    return pd.DataFrame(rows, columns=["measure", "conditions", "n", "difference", "sd", "t"])


def ticks(root: Path, recording: str) -> pd.DataFrame:
    """One recording, 100 rows a second: the ego, and beside each tick the advice that was issued at it."""
    folder = root / recording
    ego = pd.read_parquet(folder / "ego.parquet")
    advice = pd.read_parquet(folder / "advice.parquet", columns=["tick", "action", "action_value"])
    # An advice of tick k is first driven in tick k + 1.
    return ego.merge(advice.assign(tick=advice["tick"] + 1), on="tick", how="left", validate="one_to_one")


def mixed(trials: pd.DataFrame) -> None:
    """Mean speed by condition and place with an intercept for each participant, or why there is none."""
    participants, conditions = trials["participant"].nunique(), trials["condition"].nunique()
    # A mean, differences between conditions, a slope and two variances are to be found.
    if participants < 2 or conditions < 2 or len(trials) <= conditions + 3:
        print(f"(too few participants or conditions for a mixed model: {participants} and {conditions})")
        return
    try:
        import statsmodels.formula.api as smf
    except ImportError:
        print("(install statsmodels for a mixed model)")
        return
    print(smf.mixedlm("mean_speed_mps ~ C(condition) + place", trials, groups=trials["participant"]).fit().summary())


def main() -> None:
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    root = Path(sys.argv[1])
    trials, phenotype, advice = read(root)
    pd.set_option("display.width", 160, "display.max_columns", 20)
    print(f"{trials['participant'].nunique()} participants, {len(trials)} trials, {len(advice)} changes of the advice\n")
    print(trials.groupby("condition", observed=True)[MEASURES].agg(["mean", "std"]).T.round(3), "\n")
    differences = pd.concat([paired(trials, measure) for measure in MEASURES], ignore_index=True)
    print(differences.round(3).to_string(index=False), "\n")
    for name, table in phenotype.items():
        scores = [column for column in table.columns if column.startswith("score_")]
        if scores:
            print(name, table[scores].mean().round(2).to_dict())
    mixed(trials)
    scans = pd.read_csv(next(iter(sorted(root.glob("sub-*/sub-*_scans.tsv")))), sep="\t")
    # Answers are in the list, too, and have no recording.
    recording = scans["recording"].dropna().iloc[-1]
    rows = ticks(root, recording)
    print(f"\n{recording}: {len(rows)} ticks, {rows['action'].notna().sum()} advices joined to theirs")
    if len(sys.argv) == 3:
        out = Path(sys.argv[2])
        out.mkdir(parents=True, exist_ok=True)
        trials.to_csv(out / "trials_with_participants.csv", index=False)
        differences.to_csv(out / "paired_differences.csv", index=False)


if __name__ == "__main__":
    main()
