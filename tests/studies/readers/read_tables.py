"""Reads every table of a BIDS data set with pandas by what its sidecars say: units mean numbers, levels are all values that there are.

In: the data set's folder. Out: JSON with what was read; an error names the table and the column.
"""

import json
import re
import sys
from pathlib import Path

import pandas as pd

root = Path(sys.argv[1])


def entities(path):
    """Entities of a name as BIDS writes it, and its suffix: sub-R01_task-trial_events is {sub: R01, task: trial}, events."""
    *pairs, suffix = path.name.split(".")[0].split("_")
    return dict(pair.split("-", 1) for pair in pairs), suffix


def sidecar(table):
    """What all sidecars say of a table, by the inheritance principle: the nearest wins."""
    if table.parent.name == "phenotype" or table.name == "participants.tsv":
        return json.loads(table.with_suffix(".json").read_text())
    own, suffix = entities(table)
    said = {}
    for folder in reversed(table.relative_to(root).parents):
        for path in sorted((root / folder).glob(f"*{suffix}.json")):
            inherited, kind = entities(path)
            if kind == suffix and inherited.items() <= own.items():
                said |= json.loads(path.read_text())
    return said


def read(table):
    """A table by its sidecars; motion takes its names from the table of channels."""
    options = {"sep": "\t", "na_values": ["n/a"], "keep_default_na": False}
    if table.name.endswith("_motion.tsv"):
        channels = pd.read_csv(str(table).replace("_motion.tsv", "_channels.tsv"), **options)
        frame = pd.read_csv(table, header=None, names=list(channels["name"]), **options)
        # With more cells than names pandas would take the first for an index.
        assert isinstance(frame.index, pd.RangeIndex), f"{table}: more columns than channels"
        assert all(kind.kind in "fi" for kind in frame.dtypes), f"{table}: {frame.dtypes}"
        about = sidecar(table)
        assert about["MotionChannelCount"] == len(channels) == frame.shape[1], table
        assert about["RecordingDuration"] == round(len(frame) / about["SamplingFrequency"], 6), table
        return frame
    frame, about = pd.read_csv(table, **options), sidecar(table)
    of_bids = {"name", "component", "type", "tracked_point", "units", "description"} if "_channels" in table.name else set()
    for name in frame.columns:
        if name in of_bids:
            continue
        assert name in about, f"{table}: {name} is not described"
        column = frame[name].dropna()
        if about[name].get("Units"):
            assert pd.api.types.is_numeric_dtype(frame[name]), f"{table}: {name} has a unit and is {frame[name].dtype}"
        if "Levels" in about[name]:
            # Whole numbers and yes or no come as such.
            values = {str(value).lower() if isinstance(value, bool) else re.sub(r"\.0$", "", str(value)) for value in column}
            assert values <= set(about[name]["Levels"]), f"{table}: {name} {values - set(about[name]['Levels'])}"
    return frame


tables = [path for path in sorted(root.rglob("*.tsv")) if path.relative_to(root).parts[0] not in ("sourcedata", "derivatives")]
frames = {str(path.relative_to(root)): read(path) for path in tables}
motion = {name: frame for name, frame in frames.items() if name.endswith("_motion.tsv")}
times = {}
for name, frame in frames.items():
    if name.endswith("_scans.tsv"):
        for scan, at in zip(frame["filename"], pd.to_datetime(frame["acq_time"], utc=True), strict=True):
            times[str(Path(name).parent / scan)] = at.isoformat()
json.dump(
    {
        "tables": len(frames),
        "motion": {name: [len(frame), float(frame["speed"].mean())] for name, frame in motion.items()},
        "times": times,
    },
    sys.stdout,
)
