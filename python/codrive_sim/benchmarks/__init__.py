"""Benchmarks that the field cites, by their Gymnasium ids: Flow's (CoRL 2018) and networks of the Wu lab (T-ASE 2022). docs/benchmarks.md
describes them. ``python -m codrive_sim.benchmarks`` makes the table of results, and ``python -m codrive_sim.benchmarks train`` trains policies.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from codrive_sim._traffic_env import TrafficEnv
from codrive_sim.benchmarks._bottleneck import FlowBottleneck
from codrive_sim.benchmarks._figure_eight import FlowFigureEight
from codrive_sim.benchmarks._grid import FlowGrid
from codrive_sim.benchmarks._merge import FlowMerge
from codrive_sim.benchmarks._policies import SharedPolicy
from codrive_sim.benchmarks._policies import count as weight_count
from codrive_sim.benchmarks._wulab import WuLabBottleneck, WuLabFigureEight, WuLabRamp

__all__ = [
    "BENCHMARKS",
    "Benchmark",
    "FlowBottleneck",
    "FlowFigureEight",
    "FlowGrid",
    "FlowMerge",
    "SharedPolicy",
    "WuLabBottleneck",
    "WuLabFigureEight",
    "WuLabRamp",
    "named",
    "weight_count",
]


class Benchmark(NamedTuple):
    """Benchmark: its id without the namespace; its class by name, and the arguments; what its evaluation is; and published figures by their
    method, in that unit."""

    name: str
    kind: str
    arguments: dict[str, Any]
    evaluation: str
    published: dict[str, float]

    def make(self, **options: Any) -> TrafficEnv:
        """Returns the environment, with these further arguments of its class."""
        env: TrafficEnv = globals()[self.kind](**self.arguments, **options)
        return env


def _flow(name: str, version: int, evaluation: str, **published: float) -> Benchmark:
    return Benchmark(f"Flow-{name}-v{version}", f"Flow{name}", {"version": version}, evaluation, published)


_SPEED, _FLOW, _DELAY = "mean speed, m/s", "outflow, veh/h", "delay, s"

#: All benchmarks. Published: table 1 of the paper of Flow's benchmarks; table and plots of the Wu lab's paper.
BENCHMARKS = (
    _flow("FigureEight", 0, _SPEED, human=4.18, ARS=7.31, ES=6.87, TRPO=8.26),
    _flow("FigureEight", 1, _SPEED, human=4.18, ARS=6.43, TRPO=5.61),
    _flow("FigureEight", 2, _SPEED, human=4.18, ARS=5.70, ES=5.96, TRPO=5.03),
    _flow("Merge", 0, _SPEED, human=7.39, ARS=11.3, ES=13.31, TRPO=14.95, PPO=13.66),
    _flow("Merge", 1, _SPEED, human=7.39, ARS=11.06, ES=17.29, TRPO=13.74, PPO=14.61),
    _flow("Merge", 2, _SPEED, human=7.39, ARS=11.5, ES=17.36, TRPO=14.14, PPO=14.54),
    _flow("Bottleneck", 0, _FLOW, human=1023, ARS=1265, ES=1360, TRPO=1298, PPO=1167),
    _flow("Bottleneck", 2, _FLOW, human=1889, ARS=2284, ES=2324, TRPO=2131, PPO=2143),
    _flow("Grid", 0, _DELAY),
    _flow("Grid", 1, _DELAY),
    Benchmark("WuLab-FigureEight-v0", "WuLabFigureEight", {}, _SPEED, {"human": 3.37, "derived": 7.33}),
    Benchmark("WuLab-Bottleneck-v0", "WuLabBottleneck", {}, _FLOW, {"human": 1476, "derived": 1787}),
    Benchmark("WuLab-Ramp-v0", "WuLabRamp", {}, _FLOW, {"human": 1500, "derived": 1675}),
)


def named(name: str) -> Benchmark:
    """Returns the benchmark of a name, such as ``"Flow-Merge-v1"``.

    Raises:
        ValueError: There is no such benchmark.
    """
    for benchmark in BENCHMARKS:
        if benchmark.name == name:
            return benchmark
    raise ValueError(f"no benchmark is called {name!r}; allowed: {', '.join(benchmark.name for benchmark in BENCHMARKS)}")
