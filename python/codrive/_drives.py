"""One whole drive, hold by hold, in this process; ``_workers`` has the same for other processes."""

from __future__ import annotations

import os
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from codrive._codrive import Drive, DriveConfiguration
from codrive._runtime_folder import runtime_variables
from codrive._words import in_words_of_python


class Arguments(NamedTuple):
    """Arguments of ``DriveConfiguration``."""

    map: str
    driver: str | None
    settings: dict[str, Any]


class Observed(NamedTuple):
    """Vehicles that are advised now, and their observations, float32, ``(agents, k)``."""

    agents: list[str]
    observations: NDArray[np.float32]


class HoldResult(NamedTuple):
    """Result of a hold; rows are the vehicles that were advised in it."""

    rewards: NDArray[np.float64]
    terminations: NDArray[np.bool_]
    is_truncated: bool
    mean_speed_mps: float
    final_observations: NDArray[np.float32]
    after: Observed


class LocalDrive:
    """Drive in this process."""

    def __init__(self, arguments: Arguments) -> None:
        self._drive = Drive(DriveConfiguration(*arguments))

    def begin(self, seed: int) -> Observed:
        """Begins a drive of this seed, up to its first advice."""
        with in_words_of_python():
            self._drive.begin(seed)
        return self._observed()

    def hold(self, actions: NDArray[np.float32]) -> HoldResult:
        """Drives one hold under these actions, float32, ``(agents,)``."""
        drive = self._drive
        with in_words_of_python():
            drive.hold(actions)
        return HoldResult(
            drive.rewards(),
            drive.terminations(),
            drive.is_truncated(),
            drive.mean_speed_mps(),
            drive.final_observations(),
            self._observed(),
        )

    def fingerprint(self) -> str:
        """Returns a hash over all states since the drive began."""
        return self._drive.fingerprint()

    def render(self, width: int, height: int, view: str) -> NDArray[np.uint8]:
        """Returns the present picture, uint8, ``(height, width, 3)``."""
        os.environ.update(runtime_variables())
        return self._drive.render(width, height, view)

    def close(self) -> None:
        """Ends the drive."""
        self._drive = None

    def _observed(self) -> Observed:
        return Observed(self._drive.agents(), self._drive.observations())
