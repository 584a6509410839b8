"""``python -m codrive._bench_drives NAME STEPS``: one measurement of whole drives for ``codrive.bench``, in a process of its own, which can
hold one SUMO. It prints steps of agents per CPU-second.

The references are environments as users of Flow write them on plain libsumo: at each step they read the advised vehicles and their leaders
and set speeds, and at each step of SUMO they read the mean speed of all vehicles.
"""

from __future__ import annotations

import importlib.util
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from typing import Any

import numpy as np

from codrive._codrive import data_folder
from codrive._register import make, make_parallel

#: Share of advised vehicles on the merge.
SHARE = 0.25
#: Step of SUMO, s.
STEP_S = 0.1
#: Vehicles on a ring.
CARS = 22


def ring(traffic: str, steps: int) -> float:
    """Measures rings with a light ego and holds of one step of the traffic."""
    env = make("ring-250", traffic=traffic, participant=False, own_process=False, advice="acceleration", hold=STEP_S, horizon_s=36000.0)
    env.reset(seed=1)
    rng = np.random.default_rng(1)
    begun = time.process_time()
    for _ in range(steps):
        env.step(rng.uniform(-1.0, 1.0, (1,)).astype(np.float32))
    return steps / (time.process_time() - begun)


def merge(steps: int) -> float:
    """Measures the agents of the merge with holds of 1 s."""
    env = make_parallel(
        "merge", advised=SHARE, participant=False, own_process=False, advice="acceleration", warm_up_s=0.0, horizon_s=float(max(steps, 60))
    )
    env.reset(seed=1)
    rng = np.random.default_rng(1)
    begun, driven = time.process_time(), 0
    while env.agents:
        driven += len(env.agents)
        env.step({agent: rng.uniform(-1.0, 1.0, (1,)).astype(np.float32) for agent in env.agents})
    return driven / (time.process_time() - begun)


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
    sumo = _libsumo(["-n", str(net)])
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


def plain_merge(steps: int) -> float:
    """Measures the merge on plain libsumo."""
    folder = data_folder() / "maps/merge"
    sumo = _libsumo(["-n", str(folder / "net.xml"), "-r", str(folder / "demand.rou.xml")])
    rng, vehicle, agents = np.random.default_rng(1), sumo.vehicle, set[str]()
    begun, driven = time.process_time(), 0
    for _ in range(max(steps, 60)):
        for agent in sorted(agents):
            seen = _seen(vehicle, agent)
            vehicle.setSpeed(agent, max(float(seen[0]) + float(rng.uniform(-0.5, 0.5)), 0.0))
            driven += 1
        for _ in range(round(1.0 / STEP_S)):
            sumo.simulationStep()
            agents |= {one for one in sumo.simulation.getDepartedIDList() if rng.random() < SHARE}
            agents -= set(sumo.simulation.getArrivedIDList())
            _mean_mps(vehicle)
    return driven / (time.process_time() - begun)


#: Measurements by name, and the number of steps that take about a second.
MEASUREMENTS = {
    "ring, native engine": (lambda steps: ring("native", steps), 10_000),
    "ring, SUMO": (lambda steps: ring("sumo", steps), 5_000),
    "ring, plain libsumo": (plain_ring, 8_000),
    "merge, SUMO": (merge, 150),
    "merge, plain libsumo": (plain_merge, 300),
}


def measure(seconds: float) -> dict[str, float | str]:
    """Measures all, agent steps per CPU-second: the best of three in turns, because other load of the machine affects all."""
    rates: dict[str, float | str] = {}
    has_libsumo = importlib.util.find_spec("libsumo") is not None
    for _ in range(3):
        for name, (_, per_s) in MEASUREMENTS.items():
            if "plain" in name and not has_libsumo:
                rates[name] = "not measured: pip install libsumo==1.28.0"
                continue
            command = [sys.executable, "-m", "codrive._bench_drives", name, str(max(int(per_s * seconds), 20))]
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
