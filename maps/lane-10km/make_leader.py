#!/usr/bin/env python3
"""Writes leader.csv: the speed of a vehicle that slows down three times, at full seconds.

In: nothing. Out: leader.csv in this folder. The phases are made up; no vehicle was measured.
"""

from pathlib import Path

# (seconds, speed at their end in m/s): speeds between are linear.
PHASES = [(40, 22), (8, 10), (20, 10), (12, 22), (40, 22), (11, 0), (15, 0), (22, 22), (50, 22), (10, 12), (12, 12), (10, 22), (50, 22)]

rows, time_s, speed = [(0, 22.0)], 0, 22.0
for seconds, end in PHASES:
    rows += [(time_s + k, speed + (end - speed) * k / seconds) for k in range(1, seconds + 1)]
    time_s, speed = time_s + seconds, float(end)
text = "time_s,speed_mps\n" + "".join(f"{at},{mps:.3f}\n" for at, mps in rows)
(Path(__file__).parent / "leader.csv").write_text(text)
