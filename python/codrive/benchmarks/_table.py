"""Command ``python -m codrive.benchmarks``: the table of results of the benchmarks, without control and with policies, beside the published figures.

Each figure is the mean over drives of unseen seeds, with its standard deviation; of policies the mean over the seeds of their trainings, too.
The drives run on all cores. The fingerprint at the end is a hash over all states of all drives: it is equal where all bits are.
"""

from __future__ import annotations

import argparse
import hashlib
import multiprocessing
import os
import pathlib
import signal
import sys
from concurrent.futures import ProcessPoolExecutor
from typing import NamedTuple

import numpy as np

from codrive import benchmarks
from codrive.benchmarks import BENCHMARKS, Benchmark
from codrive.benchmarks._policies import POLICIES, read

#: First seed of evaluations; trainings have smaller ones.
FIRST_SEED = 100_001
#: Distance to the end of its lane below which the derived controller of the bottleneck yields, m; 30, 50 and 80 gave the same outflow.
_YIELD_BELOW_M = 30.0


class Task(NamedTuple):
    """Drive of a benchmark: its method, "none", "derived" or "policy"; the file of the policy; the seed; and actions up to its end, 0 for all."""

    benchmark: Benchmark
    method: str
    file: pathlib.Path | None
    seed: int
    actions: int


class Outcome(NamedTuple):
    """Evaluation of a drive, the actions that it took, and its fingerprint."""

    evaluation: float
    actions: int
    fingerprint: str


def drive(task: Task) -> Outcome:
    """Drives an episode in this process."""
    kind = getattr(benchmarks, task.benchmark.kind)
    env = kind(**task.benchmark.arguments, controlled=task.method != "none", own_process=False)
    try:
        observation, _ = env.reset(seed=task.seed)
        policy = None if task.file is None else read(task.file, env)
        action = np.zeros(env.action_space.shape, env.action_space.dtype)
        is_over, actions, evaluation = False, 0, np.nan
        while not is_over and (task.actions == 0 or actions < task.actions):
            if policy is not None:
                action = policy.action(observation)
            elif task.method == "derived":
                action = env.yield_below(_YIELD_BELOW_M)
            observation, _, terminated, truncated, info = env.step(action)
            is_over, actions, evaluation = terminated or truncated, actions + 1, info["evaluation"]
        return Outcome(evaluation, actions, env.fingerprint())
    finally:
        env.close()


def tasks(chosen: list[Benchmark], policies: pathlib.Path, drives: int, actions: int) -> list[Task]:
    """Returns all drives of the table."""
    made = []
    for benchmark in chosen:
        files = sorted(policies.glob(f"{benchmark.name}.*.json"))
        methods: list[tuple[str, pathlib.Path | None]] = [("none", None), *(("policy", file) for file in files)]
        if benchmark.kind == "WuLabBottleneck":
            methods.append(("derived", None))
        made += [Task(benchmark, method, file, FIRST_SEED + k, actions) for method, file in methods for k in range(drives)]
    return made


def table(results: list[tuple[Task, Outcome]]) -> str:
    """Returns the table in Markdown."""
    lines = [
        "| benchmark | evaluation | without control | published | derived controller | policies | trainings | published |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for benchmark in dict.fromkeys(task.benchmark.name for task, _ in results):
        own = [(task, outcome) for task, outcome in results if task.benchmark.name == benchmark]
        about = own[0][0].benchmark
        published = [f"{method} {value:g}" for method, value in about.published.items() if method not in ("human", "derived")]
        derived = _figure([outcome for task, outcome in own if task.method == "derived"])
        if "derived" in about.published:
            derived = ", ".join(filter(None, [derived, f"published {about.published['derived']:g}"]))
        files = sorted({task.file for task, _ in own if task.file is not None})
        trained = [np.mean([outcome.evaluation for task, outcome in own if task.file == file]) for file in files]
        spread = ", ".join(f"{value:.4g}" for value in trained)
        cells = [
            benchmark,
            about.evaluation,
            _figure([outcome for task, outcome in own if task.method == "none"]),
            f"{about.published['human']:g}" if "human" in about.published else "",
            derived,
            _figure([outcome for task, outcome in own if task.method == "policy"]),
            spread,
            ", ".join(published),
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _figure(outcomes: list[Outcome]) -> str:
    """Returns mean and standard deviation over drives; empty without any."""
    if not outcomes:
        return ""
    values = [outcome.evaluation for outcome in outcomes]
    return f"{np.mean(values):.4g} SD {np.std(values, ddof=1):.2g}" if len(values) > 1 else f"{values[0]:.4g}"


def fingerprint(results: list[tuple[Task, Outcome]]) -> str:
    """Returns a hash over the fingerprints of all drives."""
    return hashlib.sha256("".join(outcome.fingerprint for _, outcome in results).encode()).hexdigest()[:16]


def main() -> int:
    """Makes the table by the arguments of the command line. Returns the exit status."""
    parser = argparse.ArgumentParser(prog="python -m codrive.benchmarks", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    names = [benchmark.name for benchmark in BENCHMARKS]
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"benchmarks, without the version or with it; all without a name: {', '.join(names)}")
    parser.add_argument("--drives", type=int, default=10, help="drives of each benchmark and policy, default 10")
    parser.add_argument("--actions", type=int, default=0, help="end each drive after this many actions, for a trial; 0 is its horizon")
    parser.add_argument("--policies", type=pathlib.Path, default=POLICIES, help="folder of policies, NAME.SEED.json; default: the shipped ones")
    arguments = parser.parse_args()
    unknown = [name for name in arguments.names if not any(known.startswith(name) for known in names)]
    if unknown:
        parser.error(f"no benchmark is called {unknown[0]!r}; allowed: {', '.join(names)}")
    if arguments.drives < 1 or arguments.actions < 0:
        parser.error("--drives must be 1 or more, --actions 0 or more")
    chosen = [known for known in BENCHMARKS if not arguments.names or any(known.name.startswith(name) for name in arguments.names)]
    todo = tasks(chosen, arguments.policies, arguments.drives, arguments.actions)
    results: list[tuple[Task, Outcome]] = []
    # Ctrl-C is for this process, which ends the others.
    silent = (signal.SIGINT, signal.SIG_IGN)
    count = min(os.cpu_count() or 1, len(todo))
    with ProcessPoolExecutor(count, multiprocessing.get_context("spawn"), signal.signal, silent) as pool:
        try:
            for task, future in [(task, pool.submit(drive, task)) for task in todo]:
                results.append((task, future.result()))
                if sys.stderr.isatty():
                    print(f"\r{len(results)} of {len(todo)} drives", end="", file=sys.stderr, flush=True)
        except KeyboardInterrupt:
            for process in multiprocessing.active_children():
                process.terminate()
            print("\nended by Ctrl-C", file=sys.stderr)
            return 130
    if sys.stderr.isatty():
        print(file=sys.stderr)
    print(table(results))
    print(f"\n{len(results)} drives, fingerprint {fingerprint(results)}")
    return 0

