"""Centre lines of OpenDRIVE lanes, computed from the formulas of the standard, compared with a network that was made of the file. In: the
folder with sumolib, an .xodr file, its net.xml. Out: JSON: the number of points, the largest distance from a point to the nearest lane of
the network, metres, and the place of that point. Only lanes of constant width outside junctions are compared: a lane of SUMO has one width."""

import bisect
import json
import math
import sys
import xml.etree.ElementTree as ElementTree

sys.path.insert(0, sys.argv[1])
import sumolib  # noqa: E402

STEP_M = 1.0
# Types of lanes that cars drive on.
FOR_CARS = {"driving", "entry", "exit", "offRamp", "onRamp", "connectingRamp", "slipLane", "mwyEntry", "mwyExit", "bidirectional"}


def numbers(element, names):
    return [float(element.get(name, 0)) for name in names.split()]


def polynomial(coefficients, x):
    a, b, c, d = coefficients
    return a + b * x + c * x * x + d * x**3


def slope(coefficients, x):
    _, b, c, d = coefficients
    return b + 2 * c * x + 3 * d * x * x


def local(element, ds, length):
    """Place and direction at ds along a piece of a reference line, in the frame of the piece's start."""
    shape = list(element)[0]
    if shape.tag == "line":
        return ds, 0.0, 0.0
    if shape.tag == "arc":
        bend = float(shape.get("curvature"))
        if bend == 0:
            return ds, 0.0, 0.0
        return math.sin(bend * ds) / bend, (1 - math.cos(bend * ds)) / bend, bend * ds
    if shape.tag == "spiral":
        start, end = numbers(shape, "curvStart curvEnd")
        # Direction is the integral of a linear curvature; the place is integrated by Simpson's rule.
        direction = lambda at: start * at + (end - start) * at * at / (2 * length)
        n = 2 * max(4, math.ceil(ds / 0.5))
        h = ds / n
        weights = [1 if k in (0, n) else 4 if k % 2 else 2 for k in range(n + 1)]
        x = h / 3 * sum(w * math.cos(direction(k * h)) for k, w in enumerate(weights))
        y = h / 3 * sum(w * math.sin(direction(k * h)) for k, w in enumerate(weights))
        return x, y, direction(ds)
    if shape.tag == "poly3":
        # The parameter is u, along the start's direction; ds is the way along the curve.
        of = numbers(shape, "a b c d")
        u, way, h = 0.0, 0.0, 0.01
        while way + h * math.hypot(1, slope(of, u + h / 2)) < ds:
            way += h * math.hypot(1, slope(of, u + h / 2))
            u += h
        u += (ds - way) / math.hypot(1, slope(of, u))
        return u, polynomial(of, u), math.atan(slope(of, u))
    if shape.tag == "paramPoly3":
        us, vs = numbers(shape, "aU bU cU dU"), numbers(shape, "aV bV cV dV")
        p = ds if shape.get("pRange") == "arcLength" else ds / length
        return polynomial(us, p), polynomial(vs, p), math.atan2(slope(vs, p), slope(us, p))
    raise ValueError(shape.tag)


def reference(road, s):
    """Place and direction of the reference line at s."""
    pieces = road.findall("planView/geometry")
    k = bisect.bisect_right([float(piece.get("s")) for piece in pieces], s) - 1
    piece = pieces[max(k, 0)]
    start, x, y, heading, length = numbers(piece, "s x y hdg length")
    u, v, turn = local(piece, min(s - start, length), length)
    return x + u * math.cos(heading) - v * math.sin(heading), y + u * math.sin(heading) + v * math.cos(heading), heading + turn


def at(elements, offset, s):
    """Polynomial that holds at s, and s within it."""
    valid = [element for element in elements if float(element.get(offset, 0)) <= s + 1e-9]
    if not valid:
        return [0.0] * 4, 0.0
    return numbers(valid[-1], "a b c d"), s - float(valid[-1].get(offset, 0))


def lane_points(road, section, end_s):
    """Points in the middle of each lane for cars with a constant width: lane, s, x, y."""
    begin_s = float(section.get("s"))
    offsets = road.findall("lanes/laneOffset")
    for side, sign in (("left", 1), ("right", -1)):
        lanes = sorted(section.findall(side + "/lane"), key=lambda lane: abs(int(lane.get("id"))))
        # One width in the whole section.
        is_plain = lambda lane: all(numbers(width, "b c d") == [0, 0, 0] for width in lane.findall("width")) and len(
            {width.get("a") for width in lane.findall("width")}
        ) == 1
        inner = 0.0
        for lane in lanes:
            if not is_plain(lane):
                break
            width = float(lane.find("width").get("a"))
            if lane.get("type") in FOR_CARS:
                n = max(1, int((end_s - begin_s) / STEP_M))
                for k in range(n):
                    s = begin_s + (k + 0.5) * (end_s - begin_s) / n
                    (a, b, c, d), within = at(offsets, "s", s)
                    if [b, c, d] != [0, 0, 0]:
                        continue
                    x, y, heading = reference(road, s)
                    t = a + sign * (inner + width / 2)
                    yield lane.get("id"), s, x - t * math.sin(heading), y + t * math.cos(heading)
            inner += width


def distance(point, shape):
    best = math.inf
    for (x1, y1), (x2, y2) in zip(shape, shape[1:]):
        dx, dy = x2 - x1, y2 - y1
        length2 = dx * dx + dy * dy
        part = 0 if length2 == 0 else max(0, min(1, ((point[0] - x1) * dx + (point[1] - y1) * dy) / length2))
        best = min(best, math.hypot(x1 + part * dx - point[0], y1 + part * dy - point[1]))
    return best


def main(file, net_file):
    net = sumolib.net.readNet(net_file, withInternal=True)
    off_x, off_y = net.getLocationOffset()
    lanes = [lane for edge in net.getEdges(withInternal=True) for lane in edge.getLanes() if lane.allows("passenger")]
    shapes = [lane.getShape() for lane in lanes]
    boxes = [(min(x for x, _ in s), min(y for _, y in s), max(x for x, _ in s), max(y for _, y in s)) for s in shapes]
    count, worst = 0, (0.0, "")
    for road in ElementTree.parse(file).getroot().iter("road"):
        if road.get("junction", "-1") != "-1":
            continue
        sections = road.findall("lanes/laneSection")
        ends = [float(section.get("s")) for section in sections[1:]] + [float(road.get("length"))]
        for section, end_s in zip(sections, ends):
            for lane, s, x, y in lane_points(road, section, end_s):
                point = (x + off_x, y + off_y)
                near = [
                    shape
                    for shape, (x1, y1, x2, y2) in zip(shapes, boxes)
                    if x1 - 9 < point[0] < x2 + 9 and y1 - 9 < point[1] < y2 + 9
                ]
                apart = min((distance(point, shape) for shape in near), default=99.0)
                count += 1
                worst = max(worst, (apart, f"road {road.get('id')} lane {lane} s {s:.1f}"))
    json.dump({"points": count, "worst_m": worst[0], "place": worst[1]}, sys.stdout)


main(*sys.argv[2:])
