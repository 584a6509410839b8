"""One whole drive, hold by hold, in this process; ``_workers`` has the same for other processes."""

from __future__ import annotations

import os
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from codrive_sim._codrive import Drive, DriveConfiguration
from codrive_sim._runtime_folder import runtime_variables
from codrive_sim._words import InWordsOfPython


#: Made once, as a hold is short.
_IN_WORDS = InWordsOfPython()


class Arguments(NamedTuple):
    """Arguments of ``DriveConfiguration``."""

    map: str
    driver: str | None
    settings: dict[str, Any]


class Observed(NamedTuple):
    """Vehicles that are advised now, and their observations, float32, ``(agents, k)``."""

    agents: list[str]
    observations: NDArray[np.float32]


class Leaders(NamedTuple):
    """Vehicle ahead of each of ``Vehicles`` on its way: its number, -1 without one, and the gap from bumper to bumper, m, NaN without one."""

    car: NDArray[np.int64]
    gap_m: NDArray[np.float64]


class Seen(NamedTuple):
    """Traffic now: time since the drive began, columns of all vehicles, ids and letters of signals."""

    time_s: float
    columns: NDArray[np.float64]
    signals: list[tuple[str, str]]


#: Order to the traffic: name of a method of ``Drive``, and its arguments.
Order = tuple[str, tuple[Any, ...]]


class Road(NamedTuple):
    """Lanes with their ids, widths and centre lines, m; length of the route, m, and True if it is closed."""

    lanes: list[tuple[str, float, NDArray[np.float64]]]
    length_m: float
    is_closed: bool


class HoldResult(NamedTuple):
    """Result of a hold; rows are the vehicles that were advised in it. ``measures`` are in the order of ``HOLD_MEASURES``."""

    rewards: NDArray[np.float64]
    terminations: NDArray[np.bool_]
    is_truncated: bool
    measures: NDArray[np.float64]
    time_s: float
    final_observations: NDArray[np.float32]
    after: Observed


class DriveLog:
    """All that a drive was told since it began, from which it can be driven again to the same bits."""

    def __init__(self, seed: int) -> None:
        self.seed = seed
        #: Calls of ``LocalDrive`` by name, with their arguments.
        self.calls: list[tuple[str, tuple[Any, ...]]] = []


class LocalDrive:
    """Drive in this process."""

    def __init__(self, arguments: Arguments) -> None:
        self._drive = Drive(DriveConfiguration(*arguments))

    def call(self, name: str, *arguments: Any) -> Any:
        """Calls the method with this name, as ``WorkerDrive.call`` does in another process."""
        return getattr(self, name)(*arguments)

    def begin(self, seed: int) -> Observed:
        """Begins a drive of this seed, up to its first advice."""
        with InWordsOfPython():
            self._drive.begin(seed)
        return self._observed()

    def restore(self, log: DriveLog) -> Observed:
        """Drives a drive again, up to the last call of its log."""
        self.begin(log.seed)
        for call, arguments in log.calls:
            getattr(self, call)(*arguments)
        return self._observed()

    def hold(self, actions: NDArray[np.float32], orders: list[Order] | None = None) -> HoldResult:
        """Drives one hold under these actions, float32, ``(agents,)``, after these orders."""
        drive = self._drive
        with _IN_WORDS:
            if orders:
                for name, arguments in orders:
                    getattr(drive, name)(*arguments)
            rewards, terminations, final, is_truncated, measures, time_s, agents, observations = drive.hold(actions)
        return HoldResult(rewards, terminations, is_truncated, measures, time_s, final, Observed(agents, observations))

    def traffic_step(
        self, actions: NDArray[np.float32], orders: list[Order], reach_m: float | None
    ) -> tuple[HoldResult, Seen, Leaders | None]:
        """Drives one hold as ``hold``, and returns the traffic after it, too, with the vehicles ahead within a distance, m, if there is one."""
        result = self.hold(actions, orders)
        return result, self.seen(), None if reach_m is None else self.leaders(reach_m)

    def order(self, name: str, *arguments: Any) -> None:
        """Gives the traffic an order by the name of its method."""
        with InWordsOfPython():
            getattr(self._drive, name)(*arguments)

    def seen(self) -> Seen:
        """Returns the traffic now."""
        drive = self._drive
        return Seen(drive.time_s(), drive.vehicles(), drive.signals())

    def leaders(self, reach_m: float) -> Leaders:
        """Returns the vehicle ahead of each vehicle on its way, within a distance, m."""
        with InWordsOfPython():
            return Leaders(*self._drive.leaders(reach_m))

    def names(self, cars: list[int]) -> list[tuple[str, str]]:
        """Returns the names of these vehicles in the demand, and those of their types."""
        with InWordsOfPython():
            return [(name, kind) for name, kind in self._drive.names(cars)]

    def road(self) -> Road:
        """Returns the road."""
        return Road(self._drive.lanes(), *self._drive.route())

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
