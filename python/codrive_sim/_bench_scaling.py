"""``python -m codrive_sim._bench_scaling NAME COUNT STEPS``: one measurement of environments on several cores for ``codrive_sim.bench``, in a process
of its own. It prints environment steps per second, and CPU-seconds of all processes per environment step.
"""

from __future__ import annotations

import os
import pathlib
import subprocess
import sys
import time
from typing import Any

import numpy as np

from codrive_sim._register import make_vec

#: Fast rings for each thread.
RINGS = 512


def rings(threads: int) -> Any:
    """Makes fast rings for this number of threads."""
    return make_vec("ring-250", RINGS * threads, hold=1.0, driver="late", copy=False, seed=1)


def drives(processes: int) -> Any:
    """Makes drives of rings in SUMO, each in a process of its own."""
    return make_vec("ring-250", processes, traffic="sumo", participant=False, advice="acceleration", hold=1.0, horizon_s=36000.0, seed=1)


#: Environments by name: factory, and number of steps that take about a second.
ENVIRONMENTS = {"fast rings by threads": (rings, 1500), "SUMO's rings by processes": (drives, 500)}


def _cpu_s(pid: int | None) -> float:
    """Returns the CPU-seconds of another process so far; 0 where the system does not tell them."""
    stat = pathlib.Path(f"/proc/{pid}/stat")
    if not stat.is_file():
        return 0.0
    fields = stat.read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _used_s(envs: Any) -> float:
    return time.process_time() + sum(_cpu_s(drive.pid) for drive in getattr(envs, "_drives", []))


def rate(name: str, count: int, steps: int) -> tuple[float, float]:
    """Measures environment steps per second, and CPU-seconds per environment step."""
    envs = ENVIRONMENTS[name][0](count)
    envs.reset()
    rng = np.random.default_rng(1)
    used_s, begun = _used_s(envs), time.perf_counter()
    for _ in range(steps):
        envs.step(2.0 * rng.random((envs.num_envs, 1), dtype=np.float32) - 1.0)
    lasted_s, used_s = time.perf_counter() - begun, _used_s(envs) - used_s
    envs.close()
    return envs.num_envs * steps / lasted_s, used_s / (envs.num_envs * steps)


def measure(seconds: float) -> dict[str, Any]:
    """Measures all on one core and on all of them, and the share of the cores by which the rate grows: the best of three in turns."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    found: dict[str, Any] = {"cores": cores}
    for name, (_, per_s) in ENVIRONMENTS.items():
        turns: dict[int, list[tuple[float, float]]] = {1: [], cores: []}
        for _ in range(3):
            for count, of in turns.items():
                command = [sys.executable, "-m", "codrive_sim._bench_scaling", name, str(count), str(max(int(per_s * seconds), 5))]
                variables = {**os.environ, "RAYON_NUM_THREADS": str(count)}
                done = subprocess.run(command, capture_output=True, text=True, check=False, env=variables)
                if done.returncode != 0:
                    raise RuntimeError(f"{name}: {done.stderr.strip()}")
                per_s_wall, cpu_s = map(float, done.stdout.split()[-2:])
                of.append((per_s_wall, cpu_s))
        (one, one_cpu_s), (all_of, all_cpu_s) = [
            (max(per_s_wall for per_s_wall, _ in of), min(cpu_s for _, cpu_s in of)) for of in (turns[1], turns[cores])
        ]
        found[name] = {
            "one": one,
            "all": all_of,
            "all / (cores * one)": all_of / (cores * one),
            "CPU-seconds per step, one / all": one_cpu_s / all_cpu_s if all_cpu_s else None,
        }
    return found


def main() -> None:
    """Makes one measurement."""
    print(*rate(sys.argv[1], int(sys.argv[2]), int(sys.argv[3])))


if __name__ == "__main__":
    main()
