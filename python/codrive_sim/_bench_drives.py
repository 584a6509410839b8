"""``python -m codrive_sim._bench_drives NAME STEPS``: one measurement of whole drives for ``codrive_sim.bench``, in a process of its own, which can
hold one SUMO. It prints steps of agents per CPU-second; of traffic without agents steps of SUMO; of the grid the times of real time.

The references are environments as users of Flow write them on plain libsumo: at each step they read the advised vehicles and their leaders
and set speeds, and at each step of SUMO they read the mean speed of all vehicles.
"""

from __future__ import annotations

import importlib.util
import pathlib
import random
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Discrete
from numpy.typing import NDArray

from codrive_sim._codrive import data_folder, sumo_home
from codrive_sim._drives import Order
from codrive_sim._register import make, make_parallel
from codrive_sim._traffic_env import Timing, TrafficEnv

#: Share of advised vehicles on the merge, and of those on the grid.
SHARE, GRID_SHARE = 0.25, 0.1
#: Step of SUMO, s.
STEP_S = 0.1
#: Vehicles on a ring.
CARS = 22
#: Junctions along a side of the grid, length of its streets, m, vehicles on it, and edges of the route of each.
GRID_SIDE, GRID_STREET_M, GRID_CARS, GRID_EDGES = 10, 200, 1000, 100
#: Time in which the vehicles enter the grid, s, and the merge without agents.
GRID_FILLS_S, TRAFFIC_FILLS_S = 60, 60


def ring(traffic: str, steps: int) -> float:
    """Measures rings with a light ego and holds of one step of the traffic."""
    env = make("ring-250", traffic=traffic, participant=False, own_process=False, advice="acceleration", hold=STEP_S, horizon_s=36000.0)
    env.reset(seed=1)
    rng = np.random.default_rng(1)
    begun = time.process_time()
    for _ in range(steps):
        env.step(rng.uniform(-1.0, 1.0, (1,)).astype(np.float32))
    return steps / (time.process_time() - begun)


def _agents(network: str, share: float, first: int, holds: int, **settings: Any) -> tuple[float, float]:
    """Measures a network with holds of 1 s, after the ``first`` holds: steps of agents, and seconds of the drive, per CPU-second."""
    env = make_parallel(
        network, advised=share, participant=False, own_process=False, advice="acceleration", warm_up_s=0.0, horizon_s=float(first + holds), **settings
    )
    env.reset(seed=1)
    rng = np.random.default_rng(1)
    begun, driven, hold = 0.0, 0, 0
    while env.agents:
        if hold == first:
            begun, driven = time.process_time(), 0
        driven, hold = driven + len(env.agents), hold + 1
        env.step({agent: rng.uniform(-1.0, 1.0, (1,)).astype(np.float32) for agent in env.agents})
    used_s = time.process_time() - begun
    return driven / used_s, (hold - first) / used_s


def merge(holds: int) -> float:
    """Measures the agents of the merge."""
    return _agents("merge", SHARE, 0, max(holds, 60))[0]


def grid(holds: int) -> float:
    """Measures the grid, once all vehicles are there if the measurement is long enough."""
    with tempfile.TemporaryDirectory() as folder:
        net, routes = write_grid(pathlib.Path(folder))
        return _agents(str(net), GRID_SHARE, min(GRID_FILLS_S, 3 * holds), holds, demand={"files": [str(routes)]})[1]


def write_grid(folder: pathlib.Path) -> tuple[pathlib.Path, pathlib.Path]:
    """Writes the network of the grid, signals at its junctions, and its demand: vehicles that drive about at random until after the end."""
    net, routes = folder / "net.xml", folder / "demand.rou.xml"
    home = sumo_home()
    if home is None:
        raise RuntimeError("SUMO was not found: run scripts/setup, or set SUMO_HOME")
    side = ["--grid.number", str(GRID_SIDE), "--grid.length", str(GRID_STREET_M)]
    command = [str(home / "bin/netgenerate"), "--grid", *side, "--default-junction-type", "traffic_light", "--no-turnarounds", "true"]
    subprocess.run([*command, "--output-file", str(net)], check=True, stdout=subprocess.DEVNULL)
    roads = [edge.attrib for edge in ElementTree.parse(net).getroot().iter("edge") if "from" in edge.attrib]
    following = {road["id"]: [on["id"] for on in roads if on["from"] == road["to"] and on["to"] != road["from"]] for road in roads}
    drawn = random.Random(1)
    lines = []
    for car in range(GRID_CARS):
        edges = [drawn.choice(roads)["id"]]
        while len(edges) < GRID_EDGES:
            edges.append(drawn.choice(following[edges[-1]]))
        depart_s = car * GRID_FILLS_S // 2 / GRID_CARS
        lines.append(f'<vehicle id="{car}" depart="{depart_s}"><route edges="{" ".join(edges)}"/></vehicle>')
    routes.write_text(f"<routes>{''.join(lines)}</routes>", encoding="utf-8")
    return net, routes


class MergeTraffic(TrafficEnv):
    """Traffic of the merge without orders; an action is nothing."""

    action_space = Discrete(1)
    observation_space = Box(0.0, np.inf, (1,), np.float64)

    def __init__(self, timing: Timing, own_process: bool = True) -> None:
        """Stores the times."""
        folder = data_folder() / "maps/merge"
        super().__init__(folder / "net.xml", {"files": [str(folder / "demand.rou.xml")]}, timing, own_process=own_process)

    def orders(self, action: Any) -> list[Order]:
        """Returns no order."""
        return []

    def observe(self) -> NDArray[Any]:
        """Returns the mean speed of all vehicles, m/s."""
        return np.array([self.measure()])

    def reward(self, action: Any, has_failed: bool) -> float:
        """Returns the mean speed of all vehicles, m/s."""
        return self.measure()

    def measure(self) -> float:
        """Returns the mean speed of all vehicles, m/s."""
        return float(self.now.vehicles.speed_mps.mean()) if len(self.now.vehicles.car) else 0.0


def traffic(steps: int) -> float:
    """Measures traffic of the merge without agents, by steps of SUMO, after the first minute."""
    env = MergeTraffic(Timing(STEP_S, 1, TRAFFIC_FILLS_S * round(1.0 / STEP_S), steps + 1), own_process=False)
    env.reset(seed=1)
    begun = time.process_time()
    for _ in range(steps):
        env.step(0)
    return steps / (time.process_time() - begun)


def _libsumo(arguments: list[str]) -> Any:
    import libsumo

    libsumo.start(["sumo", "--step-length", str(STEP_S), "--no-step-log", "true", "--no-warnings", "true", "--seed", "1", *arguments])
    return libsumo


def _seen(vehicle: Any, agent: str) -> np.ndarray[Any, np.dtype[np.float32]]:
    leader = vehicle.getLeader(agent, 200.0)
    gap_m, leader_mps = (leader[1], vehicle.getSpeed(leader[0])) if leader and leader[0] else (200.0, 30.0)
    return np.array([vehicle.getSpeed(agent), gap_m, leader_mps, vehicle.getLanePosition(agent)], np.float32)


def _mean_mps(vehicle: Any) -> float:
    speeds_mps = [vehicle.getSpeed(one) for one in vehicle.getIDList()]
    return float(np.mean(speeds_mps)) if speeds_mps else 0.0


def plain_ring(steps: int) -> float:
    """Measures a ring on plain libsumo."""
    net = data_folder() / "maps/ring-250/net.xml"
    edges = [edge.attrib["id"] for edge in ElementTree.parse(net).getroot().iter("edge") if not edge.attrib["id"].startswith(":")]
    # The model of the vehicles on codrive's ring.
    sumo = _libsumo(["-n", str(net), "--default.carfollowmodel", "IDM"])
    sumo.route.add("round", edges * 1000)
    lengths_m = [sumo.lane.getLength(f"{edge}_0") for edge in edges]
    ends_m = np.cumsum(lengths_m)
    for car in range(CARS):
        sumo.vehicle.add(f"v{car}", "round")
        place_m = ends_m[-1] * car / CARS
        edge = int(np.searchsorted(ends_m, place_m, side="right"))
        sumo.vehicle.moveTo(f"v{car}", f"{edges[edge]}_0", place_m - (ends_m[edge] - lengths_m[edge]))
    sumo.simulationStep()
    rng, vehicle = np.random.default_rng(1), sumo.vehicle
    begun = time.process_time()
    for _ in range(steps):
        seen = _seen(vehicle, "v0")
        vehicle.setSpeed("v0", max(float(seen[0]) + float(rng.uniform(-0.5, 0.5)) * STEP_S, 0.0))
        sumo.simulationStep()
        _mean_mps(vehicle)
    return steps / (time.process_time() - begun)


def _plain_agents(net: pathlib.Path, routes: pathlib.Path, share: float, first: int, holds: int) -> tuple[float, float]:
    """Does the same as ``_agents`` on plain libsumo."""
    sumo = _libsumo(["-n", str(net), "-r", str(routes)])
    rng, vehicle, agents = np.random.default_rng(1), sumo.vehicle, set[str]()
    begun, driven = 0.0, 0
    for hold in range(first + holds):
        if hold == first:
            begun, driven = time.process_time(), 0
        for agent in sorted(agents):
            seen = _seen(vehicle, agent)
            vehicle.setSpeed(agent, max(float(seen[0]) + float(rng.uniform(-0.5, 0.5)), 0.0))
            driven += 1
        for _ in range(round(1.0 / STEP_S)):
            sumo.simulationStep()
            agents |= {one for one in sumo.simulation.getDepartedIDList() if rng.random() < share}
            agents -= set(sumo.simulation.getArrivedIDList())
            _mean_mps(vehicle)
    used_s = time.process_time() - begun
    return driven / used_s, holds / used_s


def plain_merge(holds: int) -> float:
    """Measures the merge on plain libsumo."""
    folder = data_folder() / "maps/merge"
    return _plain_agents(folder / "net.xml", folder / "demand.rou.xml", SHARE, 0, max(holds, 60))[0]


def plain_traffic(steps: int) -> float:
    """Measures traffic of the merge without agents on plain libsumo."""
    folder = data_folder() / "maps/merge"
    sumo = _libsumo(["-n", str(folder / "net.xml"), "-r", str(folder / "demand.rou.xml")])
    for _ in range(TRAFFIC_FILLS_S * round(1.0 / STEP_S)):
        sumo.simulationStep()
    begun = time.process_time()
    for _ in range(steps):
        sumo.simulationStep()
        _mean_mps(sumo.vehicle)
    return steps / (time.process_time() - begun)


def plain_grid(holds: int) -> float:
    """Measures the grid on plain libsumo."""
    with tempfile.TemporaryDirectory() as folder:
        return _plain_agents(*write_grid(pathlib.Path(folder)), GRID_SHARE, min(GRID_FILLS_S, 3 * holds), holds)[1]


#: Measurements by name, and the number of steps that take about a second.
MEASUREMENTS = {
    "ring, native engine": (lambda steps: ring("native", steps), 10_000),
    "ring, SUMO": (lambda steps: ring("sumo", steps), 5_000),
    "ring, plain libsumo": (plain_ring, 8_000),
    "merge, SUMO": (merge, 150),
    "merge, plain libsumo": (plain_merge, 300),
    "traffic, SUMO": (traffic, 2_000),
    "traffic, plain libsumo": (plain_traffic, 3_000),
    "grid, SUMO": (grid, 10),
    "grid, plain libsumo": (plain_grid, 10),
}


def measure(seconds: float) -> dict[str, float | str]:
    """Measures all in the units of the head of this file: the best of three in turns, because other load of the machine affects all.
    A measurement below 1 s has one turn."""
    rates: dict[str, float | str] = {}
    has_libsumo = importlib.util.find_spec("libsumo") is not None
    for _ in range(3 if seconds >= 1.0 else 1):
        for name, (_, per_s) in MEASUREMENTS.items():
            if "plain" in name and not has_libsumo:
                rates[name] = "not measured: pip install libsumo==1.28.0"
                continue
            command = [sys.executable, "-m", "codrive_sim._bench_drives", name, str(max(int(per_s * seconds), 2))]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            if done.returncode != 0:
                raise RuntimeError(f"{name}: {done.stderr.strip()}")
            rates[name] = max(float(done.stdout.split()[-1]), float(rates.get(name, 0.0)))
    return rates


def main() -> None:
    """Makes one measurement."""
    name, steps = sys.argv[1], int(sys.argv[2])
    print(MEASUREMENTS[name][0](steps))


if __name__ == "__main__":
    main()
