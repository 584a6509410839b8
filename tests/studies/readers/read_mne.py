"""Opens a BIDS data set in MNE-BIDS, and the motion of a drive in MNE.

In: the data set's folder. Out: JSON with what was read.

What MNE-BIDS 0.20 does not do: read motion (`read_raw_bids` knows no file of it), and take names of motion with a run (it wants the run
before the tracking system, where BIDS 1.10 has it after). So motion is read by its channels here, and the report is made of a copy whose
lists of files are gone, without which it is one of participants and description.
"""

import json
import shutil
import sys
import tempfile
from datetime import datetime
from pathlib import Path

import mne
import numpy as np
import pandas as pd
from mne_bids import BIDSPath, get_bids_path_from_fname, get_entities_from_fname, get_entity_vals, make_report

root = Path(sys.argv[1])
table = {"sep": "\t", "na_values": ["n/a"], "keep_default_na": False}
subjects = get_entity_vals(root, "subject")
events = BIDSPath(root=root, subject=subjects[0], datatype="beh", suffix="events", extension=".tsv").match()

raws = []
for path in sorted((root / f"sub-{subjects[0]}" / "motion").glob("*_motion.tsv")):
    said = get_entities_from_fname(path.name, on_error="ignore")
    facts = json.loads(path.with_suffix(".json").read_text())
    channels = pd.read_csv(str(path).replace("_motion.tsv", "_channels.tsv"), **table)
    motion = pd.read_csv(path, header=None, names=list(channels["name"]), **table)
    # MNE has no kinds for these channels: they are miscellaneous.
    info = mne.create_info(list(channels["name"]), facts["SamplingFrequency"], "misc")
    raw = mne.io.RawArray(motion.to_numpy().T, info, verbose="error")
    scans = pd.read_csv(root / f"sub-{subjects[0]}" / f"sub-{subjects[0]}_scans.tsv", **table).set_index("filename")
    raw.set_meas_date(datetime.fromisoformat(scans.loc[f"motion/{path.name}", "acq_time"]))
    found = pd.read_csv(str(path).replace("_motion.tsv", "_events.tsv"), **table)
    raw.set_annotations(
        mne.Annotations(found["onset"], found["duration"].fillna(0), found["trial_type"], orig_time=raw.info["meas_date"]),
        verbose="error",
    )
    # Samples lie where their own clock says.
    assert np.allclose(raw.times, raw.get_data(picks="latency")[0], atol=1e-9), path
    raws.append(
        {
            "task": said["task"],
            "run": said["run"],
            "tracking_system": said["tracking_system"],
            "samples": int(raw.n_times),
            "mean_speed": float(raw.get_data(picks="speed").mean()),
            "year": raw.info["meas_date"].year,
            "advice": int(sum(raw.annotations.description == "advice")),
            "first_event": float(found["onset"].min()),
        }
    )

practice = root / f"sub-{subjects[0]}" / "motion" / f"sub-{subjects[0]}_task-practice_tracksys-codrive_motion.tsv"
assert get_bids_path_from_fname(practice).tracking_system == "codrive"
with tempfile.TemporaryDirectory() as scratch:
    copy = Path(scratch) / "data"
    shutil.copytree(root, copy, ignore=shutil.ignore_patterns("sourcedata", "*_scans.tsv", "motion"))
    report = make_report(copy, verbose="error")
json.dump(
    {
        "subjects": subjects,
        "tasks": get_entity_vals(root, "task"),
        "runs": get_entity_vals(root, "run"),
        "events": [path.basename for path in events],
        "motion": raws,
        "report": report,
    },
    sys.stdout,
)
