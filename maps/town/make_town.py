#!/usr/bin/env python3
"""Writes town.nod.xml, town.edg.xml and town.con.xml, from which netconvert makes net.xml.

A street is a smooth line through nodes and points without nodes. Its two directions share that line as their left border.
Metres and degrees; x leads east, y north, z up.
"""
from math import atan2, cos, degrees, hypot, pi, radians, sin

SCALE = 0.93          # of the plan below, without heights and the roundabout
TURN_DEG = 1.8        # largest change of direction from one segment of a shape to the next
STEP_M, HILL_STEP_M = 12.0, 4.0
PAVEMENT_M, BICYCLES_M = 2.0, 1.5
RING_M = 17.0         # radius of the inner border of the roundabout
FAST, TOWN, QUIET = 19.44, 13.89, 8.33
GRADE = 0.057

NODES = {  # id: x, y, type
    "W": (-740, -20, "priority"), "M0": (-500, -52, "priority"), "M1": (-350, -45, "priority"), "M2": (-185, 0, "priority_stop"),
    "M3": (0, 40, "traffic_light"), "M4": (165, 42, "priority"), "M5": (330, 5, "traffic_light"), "M6": (510, -50, "priority"),
    "M7": (565, -68, "priority"), "E": (790, -80, "priority"),
    "S": (-10, -720, "priority"), "S3": (-48, -490, "priority"), "S2": (-42, -330, "priority"), "S1": (-12, -150, "priority_stop"),
    "N1": (4, 195, "priority"), "N2": (46, 540, "priority"), "N3": (52, 655, "priority"), "N": (85, 870, "priority"),
    "H1": (-95, 352, "priority"), "G1": (-150, 180, "right_before_left"),
    "Q1": (-345, -165, "right_before_left"), "Q2": (-335, -300, "right_before_left"), "Q3": (-190, -140, "right_before_left"),
    "Q4": (-205, -292, "right_before_left"), "Q5": (-490, -195, "right_before_left"), "Q7": (-118, -315, "right_before_left"),
    "Q8": (-100, -150, "right_before_left"),
    "K": (180, -590, "priority"), "K1": (165, -500, "right_before_left"), "J0": (150, -345, "priority_stop"), "A1": (182, -344, "priority"), "Z1": (240, -320, "priority"), "A2": (293, -278, "priority"),
    "J1": (318, -250, "priority"), "J3": (345, -115, "priority"), "X1": (160, -180, "priority"),
    "T1": (322, 118, "priority"), "U1": (275, 575, "right_before_left"), "V1": (165, 335, "priority"),
    "Z2": (496, 75, "priority"), "B0": (506, 205, "priority"),
    "B1": (480, 322, "priority_stop"), "U2": (420, 480, "right_before_left"), "U5": (300, 710, "right_before_left"),
    "U4": (165, 690, "right_before_left"), "U3": (155, 562, "right_before_left"),
}
NODES = {name: (x * SCALE, y * SCALE, kind) for name, (x, y, kind) in NODES.items()}
RING = (22 * SCALE, 345 * SCALE)
RING_ARMS = {"Rs": -93.0, "Re": -1.0, "Rn": 84.0, "Rw": 177.0}
for name, angle in RING_ARMS.items():
    NODES[name] = (RING[0] + RING_M * cos(radians(angle)), RING[1] + RING_M * sin(radians(angle)), "priority")

# Name, limit, priority, then places: a node, or (x, y). A word before a node says how the part that ends there differs: "2>" and "2<" two lanes
# forth and back, "bike>" and "bike<" a lane for bicycles, "out" no pavements and 70 km/h, "school" 30 km/h.
STREETS = [
    ("Main Street", TOWN, 10, "W out M0 bike>bike< M1 bike>bike< M2 2>2< M3 2>2< M4 2>2< M5 bike>2< M6 bike> M7 out E"),
    ("South Street", TOWN, 8, "S out S3 S2 S1 2> M3 2< N1 Rs"),
    ("North Street", TOWN, 8, "Rn N2 N3 out N"),
    ("Ring Street", TOWN, 8, "S2 J0 A1 school Z1 school A2 J1 J3 2> M5 2< T1 (304,340) U1"),
    ("Hill Street", TOWN, 8, "Rw H1 (-225,340) (-325,262) (-368,120) M1"),
    ("East Street", TOWN, 7, "J1 (425,-188) M6 Z2 B0 B1"),
    ("Valley Street", TOWN, 7, "Re V1 (304,340) B1"),
    ("Market Lane", TOWN, 5, "M4 (172,190) V1"),
    ("Mill Street", TOWN, 5, "B0 (410,155) T1"),
    ("Garden Street", TOWN, 5, "M2 G1 H1"),
    ("Park Street", TOWN, 5, "G1 (-70,182) N1"),
    ("School Lane", TOWN, 5, "S1 X1 J3"),
    ("Weaver Lane", TOWN, 5, "X1 J0"),
    ("Field Lane", QUIET, 3, "K K1 J0"),
    ("South Lane", QUIET, 3, "S3 (55,-510) K1"),
    ("Lime Street", QUIET, 3, "M1 Q1 Q2"),
    ("Rose Street", QUIET, 3, "Q5 Q1 Q3 Q8 S1"),
    ("Beech Street", QUIET, 3, "M2 Q3 Q4"),
    ("Brook Street", QUIET, 3, "Q2 Q4 Q7 S2"),
    ("Elm Street", QUIET, 3, "M0 Q5 (-450,-280) Q2"),
    ("Finch Street", QUIET, 3, "Q8 Q7"),
    ("Over Street", QUIET, 3, "N2 U3 U1 U2"),
    ("Lark Street", QUIET, 3, "U1 U5"),
    ("Swift Street", QUIET, 3, "N3 U4 U5 (400,640) U2"),
    ("Wren Street", QUIET, 3, "U4 U3"),
    ("Upper East Street", TOWN, 7, "B1 U2"),
]
# Directions of streets at their ends where another street goes on straight, and at the roundabout.
GOES_ON = {("Hill Street", "M1"): ("Lime Street", "M1"), ("Upper East Street", "B1"): ("East Street", "B1")}
HILL = ("Hill Street", 9.0, 40.0, 45.0)        # street, height, length of the top, length of vertical curves
BRIDGE = ("Ring Street", 6.0, 36.0, 40.0, (304 * SCALE, 340 * SCALE))   # the same, and the place passed over
CROSSINGS = [("M3", "M2"), ("M3", "M4"), ("M3", "N1"), ("M3", "S1"), ("M5", "M4"), ("M5", "M6"), ("M5", "J3"), ("M5", "T1"),
             ("Rs", "N1"), ("Rw", "H1"), ("Z1", "A1"), ("Z2", "M6")]


def parse(text):
    """Returns the places of a street and the words of its parts, one for each place after the first."""
    places, words, word = [], [], ""
    for token in text.split():
        if token[0] == "(":
            x, y = token[1:-1].split(",")
            places.append((float(x) * SCALE, float(y) * SCALE))
        elif token in NODES:
            places.append(token)
        else:
            word = token
            continue
        words.append(word)
        if not isinstance(places[-1], tuple):       # a word before points holds up to the next node
            word = ""
    return places, words[1:]


def xy(place):
    return NODES[place][:2] if isinstance(place, str) else place


def heading(a, b):
    return atan2(b[1] - a[1], b[0] - a[0])


def wrap(angle):
    return (angle + pi) % (2 * pi) - pi


def inner_heading(points, i):
    """Direction at an inner place: that of the circle through it and its neighbours."""
    before, after = heading(points[i - 1], points[i]), heading(points[i], points[i + 1])
    d0, d1 = hypot(*(b - a for a, b in zip(points[i - 1], points[i]))), hypot(*(b - a for a, b in zip(points[i], points[i + 1])))
    return before + wrap(after - before) * d0 / (d0 + d1)


def end_heading(street, places, points, i, headings):
    """Direction at an end: away from the roundabout, on from a street, across another one, or free."""
    name = places[i]
    other = points[1] if i == 0 else points[-2]
    chord = heading(points[i], other)               # away from the end
    if name in RING_ARMS:
        out = radians(RING_ARMS[name])
    elif (street, name) in GOES_ON:
        out = headings[GOES_ON[(street, name)]] + pi
        if abs(wrap(out - chord)) > pi / 2:
            out += pi
    elif any(key[1] == name and key[0] != street for key in headings):
        along = next(headings[key] for key in headings if key[1] == name and key[0] != street)
        square = min((along + pi / 2, along - pi / 2), key=lambda angle: abs(wrap(angle - chord)))
        out = square + max(-radians(9), min(radians(9), wrap(chord - square)))
    else:
        inner = inner_heading(points, 1 if i == 0 else len(points) - 2) if len(points) > 2 else heading(points[0], points[1])
        towards = inner + pi if i else inner
        out = chord - wrap(towards - chord)         # an arc to the first inner place
    return out + pi if i else out


def hermite(a, b, ta, tb):
    """Points of a cubic curve from a to b with directions ta and tb, less than 0.3 m apart, without b."""
    chord = hypot(b[0] - a[0], b[1] - a[1])
    turn = (abs(wrap(ta - heading(a, b))) + abs(wrap(tb - heading(a, b)))) / 2
    size = chord / max(0.5, cos(turn / 2) ** 2)
    n = int(size / 0.25) + 1
    out = []
    for k in range(n):
        t = k / n
        h0, h1, h2, h3 = 2 * t**3 - 3 * t**2 + 1, t**3 - 2 * t**2 + t, -2 * t**3 + 3 * t**2, t**3 - t**2
        out.append(tuple(h0 * a[j] + h1 * size * (cos(ta), sin(ta))[j] + h2 * b[j] + h3 * size * (cos(tb), sin(tb))[j] for j in (0, 1)))
    return out


def ramp(s, height, curve):
    """Height after s metres of a ramp that begins and ends level, with vertical curves at both ends."""
    length = height / GRADE + curve
    s = max(0.0, min(length, s))
    if s > length / 2:
        return height - ramp(length - s, height, curve)
    return GRADE * s * s / (2 * curve) if s < curve else GRADE * (s - curve / 2)


def rise(s, start, height, top, curve):
    length = height / GRADE + curve
    return ramp(s - start, height, curve) - ramp(s - start - length - top, height, curve)


def thin(dense, step):
    """Returns indices of a dense line that are at most a step and a turn apart, its ends included."""
    kept, last = [0], None
    for k in range(1, len(dense)):
        here = heading(dense[k - 1], dense[k])
        last = here if last is None else last
        far = hypot(dense[k][0] - dense[kept[-1]][0], dense[k][1] - dense[kept[-1]][1])
        if k < len(dense) - 1 and (far >= step or abs(wrap(here - last)) >= radians(TURN_DEG)):
            kept.append(k)
            last = here
    end = len(dense) - 1
    near = hypot(dense[end][0] - dense[kept[-1]][0], dense[end][1] - dense[kept[-1]][1])
    if near < 0.6 and len(kept) > 1:
        kept.pop()
    return kept + [end]


def lines():
    """Yields for each part of each street: name, limit, priority, word, from, to, points with heights."""
    headings = {}
    prepared = []
    for street, limit, priority, text in STREETS:       # directions at inner places first
        places, words = parse(text)
        points = [xy(place) for place in places]
        for i in range(1, len(points) - 1):
            headings[(street, places[i])] = inner_heading(points, i)
        prepared.append((street, limit, priority, places, words, points))
    for street, limit, priority, places, words, points in prepared:
        for i in (0, len(points) - 1):
            if (street, places[i]) in GOES_ON:
                continue
            headings[(street, places[i])] = end_heading(street, places, points, i, {k: v for k, v in headings.items() if k[1] != places[i] or
                                                        k[0] != street and not at_end(prepared, k)})
    for street, limit, priority, places, words, points in prepared:
        for i in (0, len(points) - 1):
            if (street, places[i]) in GOES_ON:
                headings[(street, places[i])] = end_heading(street, places, points, i, headings)
    for street, limit, priority, places, words, points in prepared:
        ways = [headings[(street, place)] for place in places]
        dense, at = [], []
        for i in range(len(points) - 1):
            at.append(len(dense))
            dense += hermite(points[i], points[i + 1], ways[i], ways[i + 1])
        at.append(len(dense))
        dense.append(points[-1])
        along = [0.0]
        for a, b in zip(dense, dense[1:]):
            along.append(along[-1] + hypot(b[0] - a[0], b[1] - a[1]))
        height, step = (lambda s: 0.0), STEP_M
        if street == HILL[0]:
            _, up, top, curve = HILL
            length = 2 * (up / GRADE + curve) + top
            start = along[at[1]] + (along[-1] - along[at[1]] - length) / 2
            print(f"hill: {length:.0f} m, {start - along[at[1]]:.0f} m of level road before it")
            height = lambda s: rise(s, start, up, top, curve)
        if street == BRIDGE[0]:
            _, up, top, curve, over = BRIDGE
            middle = along[at[places.index(next(p for p in places if isinstance(p, tuple)))]]
            length = 2 * (up / GRADE + curve) + top
            start = middle - length / 2
            print(f"bridge: {length:.0f} m, from {start - along[at[places.index('T1')]]:.0f} m behind T1, to {along[-1] - start - length:.0f} m before U1")
            height = lambda s: rise(s, start, up, top, curve)
        stops = [i for i, place in enumerate(places) if isinstance(place, str)]
        for i, j in zip(stops, stops[1:]):
            piece, s = dense[at[i]:at[j] + 1], along[at[i]:at[j] + 1]
            hilly = any(height(v) > 0 for v in s)
            kept = thin(piece, HILL_STEP_M if hilly else STEP_M)
            yield street, limit, priority, words[j - 1], places[i], places[j], [(*piece[k], height(s[k])) for k in kept]


def at_end(prepared, key):
    """Checks whether a street ends at a node."""
    return any(street == key[0] and key[1] in (places[0], places[-1]) for street, _, _, places, _, _ in prepared)


def check(name, points):
    """Reports kinks and steep slopes."""
    turns = [abs(wrap(heading(b, c) - heading(a, b))) for a, b, c in zip(points, points[1:], points[2:])]
    flat = [hypot(b[0] - a[0], b[1] - a[1]) for a, b in zip(points, points[1:])]
    slope = max(abs(b[2] - a[2]) / d for a, b, d in zip(points, points[1:], flat))
    radius = min((min(d, e) / t if t > 1e-4 else 1e9) for t, d, e in zip(turns, flat, flat[1:])) if turns else 1e9
    if turns and degrees(max(turns)) > 2.3 or slope > 0.06 or radius < 30 or min(flat) < 0.5:
        print(f"{name}: turn {degrees(max(turns or [0])):.1f} deg, slope {slope:.3f}, radius {radius:.0f} m, shortest {min(flat):.2f} m")


def text(points):
    return " ".join(f"{x:.2f},{y:.2f},{z:.3f}" if z else f"{x:.2f},{y:.2f}" for x, y, z in points)


LANES = {}


def edge(street, limit, priority, a, b, points, cars, bike, pavement, width):
    name = f"{a}-{b}"
    check(name, points)
    lanes = ([("allow=\"pedestrian\"", PAVEMENT_M)] if pavement else []) + ([("allow=\"bicycle\"", BICYCLES_M)] if bike else [])
    lanes += [("disallow=\"pedestrian bicycle\"" if bike else "disallow=\"pedestrian\"", width)] * cars
    LANES[name] = {"car": len(lanes) - cars, "cars": cars, "bike": 1 if bike else None}
    out = [f'    <edge id="{name}" from="{a}" to="{b}" numLanes="{len(lanes)}" speed="{limit}" priority="{priority}" name="{street}"'
           f' shape="{text(points)}">']
    out += [f'        <lane index="{i}" {who} width="{wide:.2f}"/>' for i, (who, wide) in enumerate(lanes)]
    return out + ["    </edge>"]


def turns(out):
    """Lanes at the signals: the left one for those who turn left, the right one for all others. Lanes at Main Street's narrowing."""
    def add(a, b, lane, c, target):
        source, to = LANES[f"{a}-{b}"], LANES[f"{b}-{c}"]
        line = source["car"] + lane
        out.append(f'    <connection from="{a}-{b}" to="{b}-{c}" fromLane="{line}" toLane="{to["car"] + min(target, to["cars"] - 1)}"/>')

    def cycle(a, b, c):
        source, to = LANES[f"{a}-{b}"], LANES[f"{b}-{c}"]
        if source["bike"]:
            out.append(f'    <connection from="{a}-{b}" to="{b}-{c}" fromLane="1" toLane="{to["bike"] or to["car"]}"/>')
    for middle, arms in (("M3", ("M2", "S1", "M4", "N1")), ("M5", ("M4", "J3", "M6", "T1"))):
        for i, arm in enumerate(arms):              # counterclockwise
            right, ahead, left = (arms[(i + k) % 4] for k in (1, 2, 3))
            for way in (right, ahead, left):
                cycle(arm, middle, way)
            add(arm, middle, 0, right, 0)
            add(arm, middle, 0, ahead, 0)
            add(arm, middle, 1, left, 1)
    for arm, lane in (("M4", 0), ("J3", 0), ("T1", 1)):     # bicycles into their lane
        source = LANES[f"{arm}-M5"]
        out.append(f'    <connection from="{arm}-M5" to="M5-M6" fromLane="{source["car"] + lane}" toLane="1"/>')
    add("M3", "M2", 0, "G1", 0)
    add("M3", "M2", 0, "M1", 0)
    add("M3", "M2", 1, "Q3", 0)


def main():
    nodes = ["<nodes>"]
    nodes += [f'    <node id="{name}" x="{x:.2f}" y="{y:.2f}" type="{kind}" radius="{9 if kind == "traffic_light" else 6}"/>' for name, (x, y, kind) in NODES.items()] + ["</nodes>"]
    edges = ["<edges>"]
    for street, limit, priority, word, a, b, points in lines():
        out = "out" in word
        limit = FAST if out else QUIET if "school" in word else limit
        wide = 3.0 if priority == 3 else 3.25
        edges += edge(street, limit, priority, a, b, points, 2 if "2>" in word else 1, "bike>" in word, not out, wide)
        edges += edge(street, limit, priority, b, a, points[::-1], 2 if "2<" in word else 1, "bike<" in word, not out, wide)
    arms = list(RING_ARMS)
    ring = []
    for a, b in zip(arms, arms[1:] + arms[:1]):
        start = RING_ARMS[a]
        sweep = (RING_ARMS[b] - start) % 360
        n = int(sweep / 2.2) + 1
        points = [(RING[0] + RING_M * cos(radians(start + sweep * k / n)), RING[1] + RING_M * sin(radians(start + sweep * k / n)), 0.0)
                  for k in range(n + 1)]
        edges += edge("Roundabout", 8.33, 12, a, b, points, 1, False, True, 5.0)
        ring.append(f"{a}-{b}")
    edges += [f'    <roundabout nodes="{" ".join(arms)}" edges="{" ".join(ring)}"/>', "</edges>"]
    connections = ["<connections>"]
    turns(connections)
    connections += [f'    <crossing node="{node}" edges="{node}-{arm} {arm}-{node}" priority="1" width="{3.0 if node in ("M3", "M5") else 4.0}"/>'
                    for node, arm in CROSSINGS]
    connections.append("</connections>")
    for ending, lines_out in (("nod", nodes), ("edg", edges), ("con", connections)):
        with open(f"town.{ending}.xml", "w", encoding="utf-8") as file:
            file.write("\n".join(lines_out) + "\n")


main()
