#!/usr/bin/env python3
"""Writes two-lane-ring.nod.xml, two-lane-ring.edg.xml and two-lane-ring.con.xml, from which netconvert makes net.xml, and demand.rou.xml.

The ring is two halves of a circle, with two lanes each. Metres, m/s, seconds.
"""
from math import cos, pi, sin
from pathlib import Path

LAP_M = 250.0
RADIUS_M = LAP_M / (2 * pi)
CHORDS = 125          # of half a circle, 1 m each
LANE_VEHICLES = 22
QUEUE_M = 9.09        # spacing at the start, as in a bunched start on ring-250: 50 m of each lane are free
START_M = 5.0         # front of a participant at the start, as the last of the outer lane
SHARES = (0.7, 0.85, 1.0, 1.15, 1.3)    # of the ring study's time gap, 1 s, and of its acceleration, 1 m/s2

HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n<!-- {} -->\n'


def half(start_rad):
    """Returns the shape of half a circle."""
    angles = [start_rad + pi * i / CHORDS for i in range(CHORDS + 1)]
    return " ".join(f"{RADIUS_M * cos(a):.4f},{RADIUS_M * sin(a):.4f}" for a in angles)


def road():
    """Writes nodes, edges and connections."""
    places = (("bottom", -RADIUS_M), ("top", RADIUS_M))
    nodes = [f'    <node id="{name}" x="0" y="{y_m:.4f}" type="priority"/>' for name, y_m in places]
    lanes = f'numLanes="2" speed="30" length="{LAP_M / 2:g}" spreadType="center"'
    edges = [f'    <edge id="{name}" from="{a}" to="{b}" {lanes} shape="{half(start)}"/>'
             for name, a, b, start in (("right", "bottom", "top", -pi / 2), ("left", "top", "bottom", pi / 2))]
    links = [f'    <connection from="{a}" to="{b}" fromLane="{lane}" toLane="{lane}"/>'
             for a, b in (("right", "left"), ("left", "right")) for lane in (0, 1)]
    write("two-lane-ring.nod.xml", "The south and the north of a circle of 250 m. Metres.", "nodes", nodes)
    write("two-lane-ring.edg.xml", "Two halves of a circle; a lap counts as 250 m in both lanes. Metres, m/s.", "edges", edges)
    write("two-lane-ring.con.xml", "Each lane goes on as itself.", "connections", links)


def demand():
    """Writes the vehicles: in each lane a queue of equal spacing, the two on opposite sides of the ring."""
    rows = ['    <vTypeDistribution id="human">']
    rows += [f'        <vType id="T{t:g}-a{a:g}" vClass="passenger" carFollowModel="IDM" length="5" tau="{t:g}" accel="{a:g}" decel="1.5"\n'
             f'               minGap="2" maxSpeed="30" laneChangeModel="LC2013" lcAssertive="2" lcSpeedGain="20" lcMaxSpeedLatStanding="0"\n'
             f'               lcMaxSpeedLatFactor="0.2" probability="1"/>' for t in SHARES for a in SHARES]
    rows += ["    </vTypeDistribution>", '    <route id="from-right" edges="right left" repeat="10000"/>',
             '    <route id="from-left" edges="left right" repeat="10000"/>']
    for lane in (0, 1):
        for place in range(LANE_VEHICLES):
            lap_m = (START_M + QUEUE_M * (place + 1) + lane * LAP_M / 2) % LAP_M
            edge, on_edge_m = ("right", lap_m) if lap_m < LAP_M / 2 else ("left", lap_m - LAP_M / 2)
            rows.append(f'    <vehicle id="{lane}.{place}" type="human" route="from-{edge}" depart="0" departLane="{lane}" '
                        f'departPos="{on_edge_m:.2f}" departSpeed="0"/>')
    head = ("The 44 vehicles of the ring, at rest: in each lane a queue of 22, which drive round and round. The seed draws the driver of each from 25,\n"
            "     whose time gap and acceleration are 0.7 to 1.3 times those of the ring study. They change lanes for a small gain of speed.")
    write("demand.rou.xml", head, "routes", rows)


def write(name, comment, root, rows):
    """Writes an XML file into the folder of this program."""
    Path(__file__).with_name(name).write_text(HEAD.format(comment) + "\n".join([f"<{root}>", *rows, f"</{root}>"]) + "\n", encoding="utf-8")


road()
demand()
