"""Receives streams of one source by pylsl, as another laboratory's program would. Arguments: end of the source id, names of the
streams. Prints READY when it receives all of them. At the end of its standard input it waits until no more samples come, and prints
JSON: for each stream its description, stamps, values, and measured clock offsets."""

import json
import sys
import threading
import time

import pylsl

source, names = sys.argv[1], sys.argv[2:]
inlets = {}
for name in names:
    found = pylsl.resolve_bypred(f"name='{name}' and source_id='{name}.{source}'", 1, 20)
    assert found, f"{name} is not there"
    inlets[name] = pylsl.StreamInlet(found[0])
    inlets[name].open_stream(10)
got = {name: {"xml": inlet.info().as_xml(), "stamps": [], "values": [], "offsets": []} for name, inlet in inlets.items()}
over = threading.Event()


def watch():
    sys.stdin.read()
    over.set()


threading.Thread(target=watch, daemon=True).start()
print("READY", flush=True)
measured = quiet = time.monotonic()
while not over.is_set() or time.monotonic() - quiet < 0.5:
    for name, inlet in inlets.items():
        values, stamps = inlet.pull_chunk(0.0, 1024)
        if stamps:
            quiet = time.monotonic()
            got[name]["stamps"] += stamps
            got[name]["values"] += values
    if time.monotonic() - measured > 1.0:
        measured = time.monotonic()
        for name, inlet in inlets.items():
            got[name]["offsets"].append(inlet.time_correction(2.0))
    time.sleep(0.005)
for stream in got.values():
    # JSON has no NaN.
    stream["values"] = [[None if v != v else v for v in sample] for sample in stream["values"]]
print(json.dumps(got), flush=True)
