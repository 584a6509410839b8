"""Tests of the benchmark and its references."""

import json
import subprocess
import sys

import numpy as np
import pytest

import codrive_sim
from codrive_sim import _bench_scaling, bench
from codrive_sim._numpy_ring import NumpyRing


def test_the_ring_of_numpy_drives_as_that_of_the_engine():
    # Without noise, from evenly spaced vehicles at rest: the same model, in float32 in another order.
    env = codrive_sim.make(
        hold=0.1, idm={"noise": 0.0}, bunched_share=0.0, warm_up_s=0.0, sees="speed,leader_speed,gap", horizon_s=100.0
    )
    ring = NumpyRing(1, seed=1, noise=0.0)
    env.reset(seed=1)
    for step in range(300):
        action = np.array([0.4 * np.sin(step / 40.0) + 0.2], np.float32)
        seen, _, terminated, _, info = env.step(action)
        own, mean_mps = ring.step(0.5 * action)
        # -1 to 1 spans 0 to 10 m/s and 0 to 30 m.
        speed, leader, gap = (seen + 1.0) * np.array([5.0, 5.0, 15.0])
        assert not terminated
        assert own[0] == pytest.approx([speed, leader, gap], abs=5e-3)
        assert mean_mps[0] == pytest.approx(info["mean_speed_mps"], abs=1e-3)


def test_the_driver_of_numpy_drives_as_that_of_the_engine():
    # Without randomness: a driver who reacts late to advice and leader, drives too fast, and is held up by the wave at the end.
    driver = {"random_driver": False, "reaction_s": 0.8, "leader_reaction_s": 0.6, "error_mps": 0.0, "speed_bias_mps": 0.3, "deadband_mps": 0.2}
    fixed = {"idm": {"noise": 0.0}, "bunched_share": 0.0, "warm_up_s": 0.0, "sees": "speed,leader_speed,gap", "horizon_s": 100.0}
    env = codrive_sim.make(hold=0.1, driver="late", **driver, **fixed)
    ring = NumpyRing(1, seed=1, noise=0.0, driver=driver)
    env.reset(seed=1)
    for step in range(600):
        action = np.array([0.9 * np.sin(step / 25.0) + 0.1], np.float32)
        seen, _, terminated, _, info = env.step(action)
        own, mean_mps = ring.step(0.5 * action)
        speed, leader, gap = (seen + 1.0) * np.array([5.0, 5.0, 15.0])
        assert not terminated
        assert own[0] == pytest.approx([speed, leader, gap], abs=5e-3), step
        assert mean_mps[0] == pytest.approx(info["mean_speed_mps"], abs=1e-3), step


def test_the_benchmark_measures_all_ratios():
    done = subprocess.run(
        [sys.executable, "-m", "codrive_sim.bench", "--num-envs", "32", "--seconds", "0.05", "--json"],
        capture_output=True,
        text=True,
        check=True,
    )
    rates = json.loads(done.stdout)
    assert rates["hold 1.0 s"]["python / rust"] > 0.0 and rates["numpy"]["codrive / numpy"] > 0.0
    # Whatever the number of advised vehicles, half of the rate of one is promised; a short measurement has a fifth of doubt.
    assert all(rates[f"advised, hold {hold_s} s"][ratio] > 0.4 for hold_s in (1.0, 0.1) for ratio in ("4 / 1", "22 / 1"))
    sumo = rates["sumo by TraCI"]
    assert sumo["rate"] > 0.0 if isinstance(sumo, dict) else "SUMO_HOME" in sumo


def test_without_sumo_the_benchmark_says_what_brings_it(monkeypatch):
    monkeypatch.setattr(bench, "_traci", lambda: None)
    assert bench.sumo_rate(10) is None
    assert "scripts/setup" in bench.measure(16, 0.01)["sumo by TraCI"]


def test_the_benchmark_of_drives_measures_each_of_them():
    done = subprocess.run(
        [sys.executable, "-m", "codrive_sim.bench", "--drives", "--seconds", "0.001", "--json"], capture_output=True, text=True, check=True
    )
    rates = json.loads(done.stdout)
    roads = ["ring", "merge", "grid", "traffic"]
    assert set(rates) == {"ring, native engine", *(f"{road}, {by}" for road in roads for by in ("SUMO", "plain libsumo"))}
    assert all(rate > 0.0 if isinstance(rate, float) else "pip install libsumo" in rate for rate in rates.values())


def test_the_scaling_of_threads_and_processes_is_measured():
    for name in _bench_scaling.ENVIRONMENTS:
        # Two environments' steps take some CPU of this process at least; that of others is told on Linux only.
        per_s, cpu_s = _bench_scaling.rate(name, 2, 5)
        assert per_s > 0.0 and cpu_s > 0.0
