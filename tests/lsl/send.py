"""Simulates a device on LSL by pylsl. Arguments: name, samples per second (0: texts, 20 per second), source id. Sends sample k at its due
time, with k and the k-th value of a known series, until its standard input ends. Prints READY at the start and the number of samples
at the end. It waits for a listener before the first sample."""

import math
import sys
import threading
import time

import pylsl

name, rate, source = sys.argv[1], float(sys.argv[2]), sys.argv[3]
kind = pylsl.cf_double64 if rate else pylsl.cf_string
info = pylsl.StreamInfo(name, "Gaze" if rate else "Markers", 2, rate, kind, source)
channels = info.desc().append_child("channels")
for label, unit in [("sample", ""), ("pupil", "mm")]:
    channel = channels.append_child("channel")
    channel.append_child_value("label", label)
    channel.append_child_value("unit", unit)
outlet = pylsl.StreamOutlet(info)
over = threading.Event()


def watch():
    sys.stdin.read()
    over.set()


threading.Thread(target=watch, daemon=True).start()
print("READY", flush=True)
outlet.wait_for_consumers(60)
begun, k = pylsl.local_clock(), 0
while not over.is_set():
    due = begun + k / (rate or 20.0)
    wait = due - pylsl.local_clock()
    if wait > 0:
        time.sleep(wait)
    outlet.push_sample([k, math.sin(k / 50)] if rate else [str(k), "left, \"right\"; \u00fcber"], due)
    k += 1
# The last samples are still being sent.
time.sleep(1.0)
print(k, begun.hex(), flush=True)
