"""``python -m codrive_sim.bench``: measures environment steps/s under random actions, and compares them, all in one run.

An environment step is one hold of one ring of 22 vehicles; an agent step is one hold of one of its advised vehicles, if it has several. The
references are the same rings in Rust without Python, a ring with the same model in numpy, and SUMO by TraCI as Flow drove it (one ring, one
decision per step of 0.1 s), if SUMO's Python package is found. ``--drives`` measures whole drives with light bodies beside environments on
plain libsumo, if that is installed; ``--scaling`` measures threads and processes on all cores beside one.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import pathlib
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from codrive_sim import _bench_drives, _bench_scaling
from codrive_sim._codrive import data_folder, random_steps
from codrive_sim._numpy_ring import NumpyRing
from codrive_sim._register import make_vec
from codrive_sim._settings import configuration, settings

#: Vehicles of a ring, and numbers of advised ones that are measured.
CARS = 22
ADVISED = (1, 4, CARS)

#: Step of the ring's model, s.
STEP_S = 0.1

#: Driver who keeps their distance under any advice; after a collision, most of the time would be warm-up of new rings.
DRIVER = "late"


def python_rate(num_envs: int, hold_s: float, steps: int, **settings: float) -> float:
    """Measures environment steps/s through ``VectorEnv.step``."""
    envs = make_vec("ring-250", num_envs, hold=hold_s, driver=DRIVER, copy=False, seed=1, **settings)
    envs.reset()
    rng = np.random.default_rng(1)
    begun = time.perf_counter()
    for _ in range(steps):
        envs.step(2.0 * rng.random((num_envs, 1), dtype=np.float32) - 1.0)
    return num_envs * steps / (time.perf_counter() - begun)


def rust_rate(num_envs: int, hold_s: float, steps: int) -> float:
    """Measures environment steps/s without Python."""
    return num_envs * steps / random_steps(configuration("ring-250", hold_s, None, DRIVER, {}), num_envs, steps)


def advised_rate(num_envs: int, hold_s: float, advised: int, steps: int) -> float:
    """Measures agent steps per CPU-second of rings with this number of advised vehicles, through ``VectorEnv.step``."""
    envs = make_vec("ring-250", num_envs, hold=hold_s, driver=DRIVER, copy=False, seed=1, advised=advised)
    envs.reset()
    rng = np.random.default_rng(1)
    begun = time.process_time()
    for _ in range(steps):
        envs.step(2.0 * rng.random((envs.num_envs, 1), dtype=np.float32) - 1.0)
    return envs.num_envs * steps / (time.process_time() - begun)


def numpy_rate(num_envs: int, steps: int) -> float:
    """Measures environment steps/s of the ring in numpy, with holds of one model step and the same driver."""
    rings = NumpyRing(num_envs, seed=1, driver=settings("ring-250", driver=DRIVER))
    rng = np.random.default_rng(1)
    begun = time.perf_counter()
    for _ in range(steps):
        rings.step(rng.random(num_envs, dtype=np.float32) - np.float32(0.5))
    return num_envs * steps / (time.perf_counter() - begun)


def _traci() -> tuple[Any, str] | None:
    """Returns SUMO's module and its program from ``SUMO_HOME``, a checkout's ``.sumo``, or an installed package, if found."""
    homes = [pathlib.Path(os.environ["SUMO_HOME"])] if os.environ.get("SUMO_HOME") else []
    homes += [folder / ".sumo/sumo" for folder in (data_folder(), pathlib.Path.cwd())]
    for home in homes:
        if (home / "tools/traci").is_dir() and (home / "bin/sumo").is_file():
            sys.path.append(str(home / "tools"))
            import traci

            return traci, str(home / "bin/sumo")
    try:
        import sumo
        import traci
    except ImportError:
        return None
    return traci, str(pathlib.Path(sumo.SUMO_HOME) / "bin/sumo")


_ROUTES = """<routes>
<vType id="idm" carFollowModel="IDM" length="5" minGap="2" tau="1" accel="1" decel="1.5" maxSpeed="30" sigma="0.2"/>
<route id="round" edges="e0 e1 e2 e3" repeat="10000"/>
{cars}
</routes>
"""


def sumo_rate(steps: int, cars: int = CARS) -> float | None:
    """Measures environment steps/s of one ring by TraCI: each step reads all positions and speeds and sets one speed. None without SUMO."""
    found = _traci()
    if found is None:
        return None
    traci, program = found
    with tempfile.TemporaryDirectory() as folder:
        routes = pathlib.Path(folder) / "ring.rou.xml"
        # From the last edge backwards, so that no vehicle blocks the next one.
        places = sorted((250.0 / cars * k for k in range(cars)), reverse=True)
        line = '<vehicle id="{k}" type="idm" depart="0" departPos="{at:.3f}" departSpeed="0"><route edges="{edges}" repeat="10000"/></vehicle>'
        order = ["e0", "e1", "e2", "e3"] * 2
        lines = []
        for k, place in enumerate(places):
            edge = int(place // 62.5)
            lines.append(line.format(k=k, at=place % 62.5, edges=" ".join(order[edge : edge + 4])))
        routes.write_text(_ROUTES.format(cars="\n".join(lines)), encoding="utf-8")
        net = data_folder() / "maps/ring-250/net.xml"
        command = [program, "-n", str(net), "-r", str(routes), "--step-length", str(STEP_S), "--no-step-log", "--no-warnings"]
        # If SUMO starts slowly, traci prints messages, which must not mix with the results.
        with contextlib.redirect_stdout(sys.stderr):
            traci.start([*command, "--seed", "1"], label="codrive_sim.bench")
        sumo = traci.getConnection("codrive_sim.bench")
        try:
            while sumo.vehicle.getIDCount() < cars:
                sumo.simulationStep()
            for car in sumo.vehicle.getIDList():
                sumo.vehicle.subscribe(car, (traci.constants.VAR_SPEED, traci.constants.VAR_LANEPOSITION, traci.constants.VAR_ROAD_ID))
            rng = np.random.default_rng(1)
            begun = time.perf_counter()
            for _ in range(steps):
                sumo.simulationStep()
                seen = sumo.vehicle.getAllSubscriptionResults()
                speed_mps = seen["0"][traci.constants.VAR_SPEED]
                sumo.vehicle.setSpeed("0", max(speed_mps + rng.uniform(-0.5, 0.5) * STEP_S, 0.0))
            return steps / (time.perf_counter() - begun)
        finally:
            sumo.close()


def measure(num_envs: int, seconds: float) -> dict[str, Any]:
    """Measures all rates, environment steps/s, and the promised ratios.

    Args:
        num_envs: Number of rings side by side.
        seconds: Approximate duration of each measurement.
    """

    def timed(rate: Callable[[int], float], first: int, agents: int = 1) -> float:
        # As many steps as fill the time, from the rate of a few steps.
        steps = max(int(rate(first) * seconds / (num_envs * agents)), first)
        return rate(steps)

    rates: dict[str, Any] = {"num_envs": num_envs, "cores": os.cpu_count()}
    for hold_s in (1.0, STEP_S):
        # Both in turns, best of three: other load of the machine affects both.
        turns = [
            (timed(lambda n: python_rate(num_envs, hold_s, n), 20), timed(lambda n: rust_rate(num_envs, hold_s, n), 20))
            for _ in range(3)
        ]
        python, rust = (max(turn[k] for turn in turns) for k in (0, 1))
        rates[f"hold {hold_s} s"] = {"python": python, "rust": rust, "python / rust": python / rust}
        turns = [
            [timed(lambda n, agents=agents: advised_rate(num_envs, hold_s, agents, n), 5, agents) for agents in ADVISED]
            for _ in range(3)
        ]
        best = [max(turn[k] for turn in turns) for k in range(len(ADVISED))]
        rates[f"advised, hold {hold_s} s"] = {
            **{f"{agents} of {CARS}": rate for agents, rate in zip(ADVISED, best)},
            **{f"{agents} / 1": rate / best[0] for agents, rate in zip(ADVISED[1:], best[1:])},
        }
    # numpy's rings start from rest, so these do, too.
    turns = [
        (timed(lambda n: python_rate(num_envs, STEP_S, n, warm_up_s=0.0), 20), timed(lambda n: numpy_rate(num_envs, n), 5))
        for _ in range(3)
    ]
    python, own = (max(turn[k] for turn in turns) for k in (0, 1))
    rates["numpy"] = {"rate": own, "codrive": python, "codrive / numpy": python / own}
    one_step = rates[f"hold {STEP_S} s"]["python"]
    sumo = sumo_rate(max(int(1000 * seconds), 100))
    if sumo is None:
        rates["sumo by TraCI"] = "not measured: SUMO's Python package is missing; run scripts/setup, or set SUMO_HOME"
    else:
        rates["sumo by TraCI"] = {"rate": sumo, "codrive / sumo": one_step / sumo}
    return rates


def _print_drives(rates: dict[str, float | str], as_json: bool) -> None:
    if as_json:
        print(json.dumps(rates, indent=1))
        return
    print("whole drives with light bodies; agent steps per CPU-second, of traffic without agents steps of SUMO, of the grid times of real time")
    for name, rate in rates.items():
        plain = rates.get(f"{name.partition(',')[0]}, plain libsumo")
        ratio = f"; {rate / plain:.2f} x plain libsumo" if isinstance(rate, float) and isinstance(plain, float) else ""
        print(f"  {name}: {rate if isinstance(rate, str) else f'{rate:.4g}'}{ratio if 'plain' not in name else ''}")


def _print_scaling(found: dict[str, Any], as_json: bool) -> None:
    if as_json:
        print(json.dumps(found, indent=1))
        return
    cores = found["cores"]
    print(f"environment steps/s on one core and on all {cores}")
    for name, of in found.items():
        if isinstance(of, dict):
            cpu = of["CPU-seconds per step, one / all"]
            said = "" if cpu is None else f"; {cpu:.2f} by CPU-seconds"
            print(f"  {name}: {of['one']:.3g}, {of['all']:.3g}: {of['all / (cores * one)']:.2f} x the cores{said}")


def main(arguments: list[str] | None = None) -> None:
    """Runs the command line."""
    parser = argparse.ArgumentParser(prog="python -m codrive_sim.bench", description=__doc__.splitlines()[0])
    parser.add_argument("--num-envs", type=int, default=1024, help="number of rings side by side (default 1024)")
    parser.add_argument("--seconds", type=float, default=2.0, help="approximate duration of each measurement, s (default 2)")
    parser.add_argument("--drives", action="store_true", help="measure whole drives, agent steps per CPU-second, instead of fast rings")
    parser.add_argument("--scaling", action="store_true", help="measure threads and processes on all cores, instead of fast rings")
    parser.add_argument("--json", action="store_true", help="print as JSON")
    asked = parser.parse_args(arguments)
    if asked.drives:
        _print_drives(_bench_drives.measure(asked.seconds), asked.json)
        return
    if asked.scaling:
        _print_scaling(_bench_scaling.measure(asked.seconds), asked.json)
        return
    if not (asked.num_envs >= 1 and 0.0 < asked.seconds <= 3600.0):
        parser.error("allowed: --num-envs at least 1, --seconds above 0 and at most 3600")
    rates = measure(asked.num_envs, asked.seconds)
    if asked.json:
        print(json.dumps(rates, indent=1))
        return
    print(f"{rates['num_envs']} rings of {CARS} cars, {rates['cores']} cores; environment steps/s")
    for name in ("hold 1.0 s", f"hold {STEP_S} s"):
        of = rates[name]
        print(f"  {name}: {of['python']:.3g} by VectorEnv.step, {of['rust']:.3g} in Rust: {of['python / rust']:.0%}")
    for name in ("hold 1.0 s", f"hold {STEP_S} s"):
        of = rates[f"advised, {name}"]
        text = ", ".join(f"{of[f'{agents} of {CARS}']:.3g} with {agents}" for agents in ADVISED)
        print(f"  {name}, agent steps per CPU-second by advised vehicles: {text}; {of[f'{CARS} / 1']:.1f} x with all")
    numpy = rates["numpy"]
    print(f"  numpy, hold {STEP_S} s, from a standstill: {numpy['rate']:.3g}; codrive {numpy['codrive / numpy']:.1f} x")
    sumo = rates["sumo by TraCI"]
    said = sumo if isinstance(sumo, str) else f"{sumo['rate']:.3g}; codrive {sumo['codrive / sumo']:.0f} x"
    print(f"  SUMO by TraCI, hold {STEP_S} s: {said}")


if __name__ == "__main__":
    main()
