"""Thins the log that esmini writes with --csv_logger to one row for each road user at each 0.1 s.

    python3 trajectories.py LOG.csv > NAME.esmini.csv

Rows of the output: time_s, entity, x_m, y_m, heading_rad, speed_mps. X and Y are those of the reference point, which is the middle of the rear
axle for our vehicles and the middle of the body for people.
"""

import csv
import sys

COLUMNS = {
    "World_Position_X": 3,
    "World_Position_Y": 3,
    "World_Heading_Angle": 4,
    "Current_Speed": 3,
}
STEPS_PER_S = 10


def entities(titles):
    """Yields the column of each entity's name and those of its values."""
    begins = [at for at, title in enumerate(titles) if "Entity_Name" in title]
    for begin, end in zip(begins, begins[1:] + [len(titles)]):
        yield begin, [next(at for at in range(begin, end) if column in titles[at]) for column in COLUMNS]


def main():
    with open(sys.argv[1], newline="") as log:
        rows = [row for row in csv.reader(log, skipinitialspace=True) if len(row) > 1]
    titles, rows = rows[0], rows[1:]
    out = csv.writer(sys.stdout, lineterminator="\n")
    out.writerow(["time_s", "entity", "x_m", "y_m", "heading_rad", "speed_mps"])
    for row in rows:
        step = float(row[1]) * STEPS_PER_S
        if abs(step - round(step)) < 1e-4:
            for name, columns in entities(titles):
                values = [round(float(row[at]), digits) for at, digits in zip(columns, COLUMNS.values())]
                out.writerow([round(step) / STEPS_PER_S, row[name], *values])


if __name__ == "__main__":
    main()
