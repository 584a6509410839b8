"""Prints a recording of LabRecorder as JSON: for each stream its time stamps as sent, and its values."""

import json
import sys

import pyxdf

streams, _ = pyxdf.load_xdf(sys.argv[1], synchronize_clocks=False, dejitter_timestamps=False)
plain = lambda value: value if isinstance(value, str) else None if value != value else float(value)
print(json.dumps({
    stream["info"]["name"][0]: {
        "stamps": [float(stamp) for stamp in stream["time_stamps"]],
        "values": [[plain(value) for value in sample] for sample in stream["time_series"]],
        "offsets": [float(offset) for offset in stream["clock_values"]] if "clock_values" in stream else [],
    }
    for stream in streams
}))
