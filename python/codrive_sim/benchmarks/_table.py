"""Table of results of the benchmarks, without control and with policies, beside the published figures. Each figure is the mean over drives of
unseen seeds, with its standard deviation; of policies the mean over the seeds of their trainings, too.
"""

from __future__ import annotations

import hashlib
import pathlib
from typing import NamedTuple

import numpy as np

from codrive_sim.benchmarks import Benchmark
from codrive_sim.benchmarks._policies import read
from codrive_sim.benchmarks._runs import Drive

#: First seed of evaluations; trainings have smaller ones.
FIRST_SEED = 100_001


class Evaluated(NamedTuple):
    """A drive with its benchmark and the name of its policy's file, and its results."""

    benchmark: Benchmark
    policy: str
    drive: Drive
    evaluation: float
    actions: int
    fingerprint: str


def drives(chosen: list[Benchmark], policies: pathlib.Path, count: int, actions: int) -> list[tuple[Benchmark, str, Drive]]:
    """Returns all drives of the table, each with its benchmark and the name of its policy's file.

    Raises:
        ValueError: A file of the folder is no policy of a benchmark.
    """
    made = []
    for benchmark in chosen:
        methods: list[tuple[str, str, list[float] | None]] = [("none", "", None)]
        methods += [("policy", file.name, read(file)) for file in sorted(policies.glob(f"{benchmark.name}.*.json"))]
        if benchmark.kind == "WuLabBottleneck":
            methods.append(("derived", "", None))
        made += [
            (benchmark, file, Drive(benchmark.name, method, weights, FIRST_SEED + k, actions))
            for method, file, weights in methods
            for k in range(count)
        ]
    return made


def table(results: list[Evaluated]) -> str:
    """Returns the table in Markdown."""
    lines = [
        "| benchmark | evaluation | without control | published | derived controller | policies | trainings | published |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for about in dict.fromkeys(one.benchmark.name for one in results):
        own = [one for one in results if one.benchmark.name == about]
        benchmark = own[0].benchmark
        published = [f"{method} {value:g}" for method, value in benchmark.published.items() if method not in ("human", "derived")]
        derived = _figure([one for one in own if one.drive.method == "derived"])
        if "derived" in benchmark.published:
            derived = ", ".join(filter(None, [derived, f"published {benchmark.published['derived']:g}"]))
        files = sorted({one.policy for one in own if one.policy})
        trained = [np.mean([one.evaluation for one in own if one.policy == file]) for file in files]
        spread = ", ".join(f"{value:.4g}" for value in trained)
        cells = [
            about,
            benchmark.evaluation,
            _figure([one for one in own if one.drive.method == "none"]),
            f"{benchmark.published['human']:g}" if "human" in benchmark.published else "",
            derived,
            _figure([one for one in own if one.policy]),
            spread,
            ", ".join(published),
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _figure(results: list[Evaluated]) -> str:
    """Returns mean and standard deviation over drives; empty without any."""
    if not results:
        return ""
    values = [one.evaluation for one in results]
    return f"{np.mean(values):.4g} SD {np.std(values, ddof=1):.2g}" if len(values) > 1 else f"{values[0]:.4g}"


def csv(results: list[Evaluated]) -> str:
    """Returns a row for each drive, as CSV."""
    rows = [
        f"{one.benchmark.name},{one.drive.method},{one.policy},{one.drive.seed},{one.evaluation!r},{one.actions},{one.fingerprint}" for one in results
    ]
    return "\n".join(["benchmark,method,policy,seed,evaluation,actions,fingerprint", *rows]) + "\n"


def fingerprint(results: list[Evaluated]) -> str:
    """Returns a hash over the fingerprints of all drives."""
    return hashlib.sha256("".join(one.fingerprint for one in results).encode()).hexdigest()[:16]
