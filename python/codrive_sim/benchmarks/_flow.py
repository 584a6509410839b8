"""What Flow's benchmarks share: the reward for a desired speed, the intelligent driver model of Flow's vehicles, their names.

Definitions: Vinitsky et al., "Benchmarks for reinforcement learning in mixed-autonomy traffic", CoRL 2018, and the sources of Flow,
github.com/flow-project/flow, at 70281193 (2018-09-30, the paper's setting) and a511c41c (2020-12-11, the last state).
"""

from __future__ import annotations

import pathlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Folder of the networks and demands, which scripts/benchmark-networks makes.
NETWORKS = pathlib.Path(__file__).parent / "networks"

#: Highest speed of Flow's vehicles, m/s, which scales observations.
TOP_SPEED_MPS = 30.0


def desired_speed(speeds_mps: NDArray[np.float64], desired_mps: float) -> float:
    """Returns how near all speeds are to the desired one: ``max(|d 1| - |d 1 - v|, 0) / |d 1|`` with Euclidean norms; 0 without vehicles."""
    if len(speeds_mps) == 0:
        return 0.0
    most = desired_mps * np.sqrt(len(speeds_mps))
    return float(max(most - np.linalg.norm(desired_mps - speeds_mps), 0.0) / most)


def checked_version(version: int, *allowed: int) -> int:
    """
    Raises:
        ValueError: The benchmark has no such version.
    """
    if version not in allowed:
        raise ValueError(f"version is {version!r}; allowed: {', '.join(map(str, allowed))}")
    return version


def mean(values: NDArray[np.float64]) -> float:
    """Returns the mean; 0 without values."""
    return float(values.mean()) if len(values) else 0.0


def idm(speed_mps: NDArray[np.float64], gap_m: NDArray[np.float64], leader_mps: NDArray[np.float64]) -> NDArray[np.float64]:
    """Returns the accelerations of Flow's intelligent driver model, m/s²: 30 m/s, 1 s, 2 m, 1 and 1.5 m/s². A gap of NaN is none ahead."""
    wanted_m = 2.0 + np.maximum(0.0, speed_mps * 1.0 + speed_mps * (speed_mps - leader_mps) / (2.0 * np.sqrt(1.0 * 1.5)))
    gap_m = np.where(np.abs(gap_m) < 1e-3, 1e-3, gap_m)
    ratio = np.where(np.isnan(gap_m), 0.0, wanted_m / gap_m)
    return 1.0 * (1.0 - (speed_mps / 30.0) ** 4 - ratio**2)


def demand(name: str, *additional: str) -> dict[str, Any]:
    """Returns the demand of this file of ``NETWORKS``."""
    files = {"files": [str(NETWORKS / f"{name}.rou.xml")]}
    return {**files, "additional_files": [str(NETWORKS / f"{file}.add.xml") for file in additional]} if additional else files
