"""What SUMO's own library reads in networks. In: the folder with sumolib, then files. Out: JSON, by file."""

import json
import sys

sys.path.insert(0, sys.argv[1])
import sumolib  # noqa: E402


def lane_row(lane):
    ways = []
    for way in lane.getOutgoing():
        ways.append({
            "to": way.getToLane().getID(),
            "via": way.getViaLaneID() or None,
            "dir": way.getDirection(),
            "state": way.getState(),
            "tl": way.getTLSID() or None,
            "tl_link": way.getTLLinkIndex(),
            # sumolib counts links also where a junction has no rules.
            "link": way.getJunctionIndex() if lane.getEdge().getToNode()._foes else -1,
        })
    shape = lane.getShape3D()
    length_2d = sumolib.geomhelper.polyLength(lane.getShape())
    thirds = []
    if length_2d > 0.05:
        at = [sumolib.geomhelper.positionAtShapeOffset(lane.getShape(), length_2d * part) for part in (0.2, 0.5, 0.9)]
        thirds = [list(point) for point in at]
    return {
        "length": lane.getLength(),
        "width": lane.getWidth(),
        "speed": lane.getSpeed(),
        "permissions": sorted(lane.getPermissions()),
        "shape": [list(point) for point in shape],
        "at": thirds,
        "ways": ways,
    }


def node_row(node):
    n = node._prohibits and len(node._prohibits) or 0
    return {
        "type": node.getType(),
        "at": list(node.getCoord3D()),
        "foes": [[k for k in range(n) if node.areFoes(link, k)] for link in range(n)],
        "yields": [[k for k in range(n) if node._prohibits[link][n - 1 - k] == "1"] for link in range(n)],
    }


def read(file):
    net = sumolib.net.readNet(file, withInternal=True, withPrograms=True, withPedestrianConnections=True, withFoes=True)
    edges = {}
    lanes = {}
    for edge in net.getEdges(withInternal=True):
        edges[edge.getID()] = {
            "function": edge.getFunction(),
            "from": edge.getFromNode() and edge.getFromNode().getID(),
            "to": edge.getToNode() and edge.getToNode().getID(),
            "lanes": [lane.getID() for lane in edge.getLanes()],
        }
        for lane in edge.getLanes():
            lanes[lane.getID()] = lane_row(lane)
    programs = {}
    for light in net.getTrafficLights():
        programs[light.getID()] = {
            name: {"type": program.getType(), "phases": [[phase.duration, phase.state] for phase in program.getPhases()]}
            for name, program in light.getPrograms().items()
        }
    nodes = {node.getID(): node_row(node) for node in net.getNodes()}
    return {"edges": edges, "lanes": lanes, "nodes": nodes, "programs": programs}


json.dump({file: read(file) for file in sys.argv[2:]}, sys.stdout)
