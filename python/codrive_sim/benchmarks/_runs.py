"""Drives and trainings of the benchmarks as independent runs: the part of each, made once, and the process that makes them,
``python -m codrive_sim.benchmarks._runs OUT``.
"""

from __future__ import annotations

import functools
import hashlib
import json
import pathlib
import sys
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

import codrive_sim
from codrive_sim import benchmarks
from codrive_sim._distribute import Meter, Place, distribute
from codrive_sim._run_process import Report, run_beside, serve
from codrive_sim._run_store import PARTS, Checkpoint, Store
from codrive_sim.benchmarks._policies import SharedPolicy
from codrive_sim.benchmarks.train import library, train

#: Distance to the end of its lane below which the derived controller of the bottleneck yields, m; 30, 50 and 80 gave the same outflow.
_YIELD_BELOW_M = 30.0


class Drive(NamedTuple):
    """Drive of a benchmark: its method, "none", "derived" or "policy"; the weights of the policy; the seed; and actions up to its end, 0 for
    all."""

    benchmark: str
    method: str
    weights: Sequence[float] | None
    seed: int
    actions: int


class Training(NamedTuple):
    """Training of a benchmark, with its seed, the number of its episodes, and actions of an episode, 0 for all."""

    benchmark: str
    seed: int
    episodes: int
    actions: int


class FailedRuns(Exception):
    """Runs that failed in every attempt, with their reasons."""


def make_all(runs: Sequence[Drive | Training], place: Place, store: Store, retries: int) -> list[Any]:
    """Makes the missing parts of runs. Returns the results of all of them: of a drive its evaluation, the number of its actions and its
    fingerprint, of a training what :func:`train` returns.

    Raises:
        FailedRuns: Runs failed in every attempt. All others are made.
    """
    names, there = [part_name(run) for run in runs], store.names()
    # Other machines and processes have working folders of their own.
    out = store.out if store.folder is None else str(store.folder)
    due = {number: (out, name, run) for number, (name, run) in enumerate(zip(names, runs)) if name not in there}
    failed = distribute(place, execute, due, retries, Meter(len(runs), len(runs) - len(due)))
    if failed:
        reasons = "".join(f"\n  {runs[number].benchmark}, seed {runs[number].seed}: {why}" for number, why in sorted(failed.items()))
        raise FailedRuns(f"{len(failed)} runs failed; run the same command again to repeat them{reasons}")
    return [json.loads(store.read(f"{PARTS}/{name}") or b"") for name in names]


def execute(out: str, name: str, run: Drive | Training) -> list[str]:
    """Makes a run in a process beside this one, which writes its part. Returns the reports about it."""
    return run_beside((__name__, out), json.dumps([name, type(run).__name__, *run]))


def part_name(run: Drive | Training) -> str:
    """Returns the name of a run's part: a hash over its settings, over the benchmarks themselves and over the versions that decide the result."""
    kind, versions = ("trainings", [np.__version__, library().__version__]) if isinstance(run, Training) else ("drives", [])
    identity = [codrive_sim.__version__, _sources(), versions, *run]
    return f"{kind}-{hashlib.sha256(json.dumps(identity).encode()).hexdigest()[:32]}.json"


@functools.cache
def _sources() -> str:
    """Returns a hash over the code and the networks of the benchmarks."""
    folder = pathlib.Path(benchmarks.__file__).parent
    files = sorted([*folder.glob("*.py"), *folder.glob("networks/*")])
    return hashlib.sha256(b"".join(hashlib.sha256(file.read_bytes()).digest() for file in files)).hexdigest()


def drive(run: Drive) -> list[Any]:
    """Drives an episode in this process. Returns its evaluation, the number of its actions and its fingerprint."""
    env = benchmarks.named(run.benchmark).make(controlled=run.method != "none", own_process=False)
    try:
        observation, _ = env.reset(seed=run.seed)
        policy = None if run.weights is None else SharedPolicy(env, run.weights)
        action = np.zeros(env.action_space.shape, env.action_space.dtype)
        is_over, actions, evaluation = False, 0, np.nan
        while not is_over and (run.actions == 0 or actions < run.actions):
            if policy is not None:
                action = policy.action(observation)
            elif run.method == "derived":
                action = env.yield_below(_YIELD_BELOW_M)
            observation, _, terminated, truncated, info = env.step(action)
            is_over, actions, evaluation = terminated or truncated, actions + 1, float(info["evaluation"])
        return [evaluation, actions, env.fingerprint()]
    finally:
        env.close()


def maker(out: str, report: Report) -> Callable[[str], None]:
    """Returns the function that makes a run and writes its part."""
    store = Store(out)

    def make(asked: str) -> None:
        name, kind, *settings = json.loads(asked)
        run = Drive(*settings) if kind == "Drive" else Training(*settings)
        if part_name(run) != name:
            raise RuntimeError(
                f"{run} is {part_name(run)} on this machine and {name} on the machine that started it\n"
                "  remedy: install the same versions of codrive, numpy and cma on all machines"
            )
        if isinstance(run, Drive):
            result: Any = drive(run)
        else:
            checkpoint = Checkpoint(store, name, lambda text: report(f"{run.benchmark}, seed {run.seed}: {text}"))
            result = train(*run, checkpoint=checkpoint)
        store.put(name, json.dumps(result).encode())

    return make


if __name__ == "__main__":
    serve(lambda report: maker(*sys.argv[1:], report))
