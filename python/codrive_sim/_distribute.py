"""Distribution of independent runs over the cores of this machine or a Ray cluster, with further attempts and progress. Each run is made in
a process beside its thread or task, which writes the run's part; what is distributed is a function that waits for that process.
"""

from __future__ import annotations

import os
import queue
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from typing import Any, Protocol

from codrive_sim._namesake import namesake_remedy
from codrive_sim._run_process import end_all

#: Function that makes a run and returns the reports about it.
Make = Callable[..., list[str]]
#: Queued tasks per core of a cluster: enough that no core is idle, few enough for a quick stop.
WAITING = 4
#: Interval at which progress is shown, s.
_SHOWN_EVERY_S = 1.0


class Place(Protocol):
    """Place where runs are made."""

    #: Number of runs that are begun at a time.
    at_a_time: int

    def begin(self, make: Make, arguments: tuple[Any, ...]) -> Any:
        """Begins a run. Returns a reference to it."""

    def ended(self, begun: list[Any]) -> list[Any]:
        """Waits for the end of a run, at most a second. Returns the references of runs that have ended."""

    def reports(self, run: Any) -> list[str]:
        """Returns the reports about a run that has ended.

        Raises:
            RuntimeError: The run failed.
        """

    def close(self) -> None:
        """Ends what the place has started on this machine."""


class Cores:
    """Cores of this machine, each with a thread that waits for the process beside it."""

    def __init__(self, workers: int | None = None) -> None:
        self.at_a_time = workers or os.cpu_count() or 1
        self._begun: queue.SimpleQueue[tuple[Future[list[str]], Make, tuple[Any, ...]] | None] = queue.SimpleQueue()
        # Threads that end with this process, unlike those of an executor: Ctrl-C must not wait for a run.
        for _ in range(self.at_a_time):
            threading.Thread(target=self._work, daemon=True).start()

    def begin(self, make: Make, arguments: tuple[Any, ...]) -> Any:
        """Begins a run."""
        run: Future[list[str]] = Future()
        self._begun.put((run, make, arguments))
        return run

    def ended(self, begun: list[Any]) -> list[Any]:
        """Waits for the end of a run."""
        return list(wait(begun, _SHOWN_EVERY_S, FIRST_COMPLETED).done)

    def reports(self, run: Any) -> list[str]:
        """Returns the reports about a run."""
        return run.result()

    def close(self) -> None:
        """Ends threads and processes."""
        for _ in range(self.at_a_time):
            self._begun.put(None)
        end_all()

    def _work(self) -> None:
        while (begun := self._begun.get()) is not None:
            run, make, arguments = begun
            try:
                run.set_result(make(*arguments))
            except Exception as why:
                run.set_exception(why)


class RayCluster:
    """Ray cluster: that of ``address``, else of ``RAY_ADDRESS``, else one on this machine."""

    def __init__(self, workers: int | None = None, address: str | None = None) -> None:
        try:
            import ray
        except ImportError:
            # The other project's package has no extra of that name, which pip only warns of.
            remedy = f"\n{namesake_remedy()[1]}".rstrip()
            raise ImportError(f"runs on a cluster need Ray: pip install './python[ray]'{remedy}") from None
        self._ray = ray
        if not ray.is_initialized():
            ray.init(address=address, log_to_driver=False, logging_level="warning")
        self.at_a_time = workers or int(ray.cluster_resources().get("CPU", 1)) * WAITING
        self._tasks: dict[Make, Any] = {}

    def shared(self, value: Any) -> Any:
        """Returns a reference to a value, which each machine takes once."""
        return self._ray.put(value)

    def begin(self, make: Make, arguments: tuple[Any, ...]) -> Any:
        """Begins a run as a task of one core. Ray repeats tasks that are lost with their machine."""
        if make not in self._tasks:
            self._tasks[make] = self._ray.remote(num_cpus=1, max_retries=-1)(make)
        return self._tasks[make].remote(*arguments)

    def ended(self, begun: list[Any]) -> list[Any]:
        """Waits for the end of a run."""
        return self._ray.wait(begun, num_returns=1, timeout=_SHOWN_EVERY_S)[0]

    def reports(self, run: Any) -> list[str]:
        """Returns the reports about a run."""
        try:
            return self._ray.get(run)
        except self._ray.exceptions.RayTaskError as why:
            raise RuntimeError(str(why.cause) if why.cause is not None else str(why)) from None
        except self._ray.exceptions.RayError as why:
            raise RuntimeError(str(why)) from None

    def close(self) -> None:
        """Does nothing: the cluster ends its own processes."""


def distribute(place: Place, make: Make, runs: dict[int, tuple[Any, ...]], retries: int, meter: Meter) -> dict[int, str]:
    """Makes runs, given by number with the arguments of ``make``; tries those that fail again after all others, ``retries`` times.

    Returns:
        The runs that failed after all attempts, with the reason, by number.
    """
    due, failed = sorted(runs), dict[int, str]()
    try:
        for _ in range(retries + 1):
            failed = _attempt(place, make, {number: runs[number] for number in due}, meter)
            due = sorted(failed)
            if not due:
                break
    finally:
        place.close()
    meter.end()
    return failed


def _attempt(place: Place, make: Make, runs: dict[int, tuple[Any, ...]], meter: Meter) -> dict[int, str]:
    """Makes each run once. Returns those that failed."""
    waiting: Iterator[int] = iter(runs)
    begun: dict[Any, int] = {}
    failed: dict[int, str] = {}
    while True:
        while len(begun) < place.at_a_time and (number := next(waiting, None)) is not None:
            begun[place.begin(make, runs[number])] = number
        if not begun:
            return failed
        for run in place.ended(list(begun)):
            number = begun.pop(run)
            try:
                meter.one(place.reports(run))
            except RuntimeError as why:
                failed[number] = str(why)
        meter.show(len(failed))


class Meter:
    """Progress of runs, in one line of standard error, and the reports about them."""

    def __init__(self, runs: int, there: int, shown: bool | None = None) -> None:
        """Starts with ``there`` of all runs done; ``shown=None`` shows the progress on a terminal."""
        self._runs, self._there, self._done = runs, there, 0
        self._start = time.monotonic()
        self._is_shown = sys.stderr.isatty() if shown is None else shown

    def one(self, reports: list[str]) -> None:
        """Counts a finished run and prints the reports about it."""
        self._done += 1
        for report in reports:
            print(f"{self._clear}{report}", file=sys.stderr, flush=True)

    def show(self, failed: int) -> None:
        """Prints the progress, if it is shown."""
        if not self._is_shown:
            return
        left = self._runs - self._there - self._done
        eta = f", {(time.monotonic() - self._start) / self._done * left:.0f} s left" if self._done else ""
        bad = f", {failed} failed" if failed else ""
        print(f"{self._clear}{self._there + self._done} of {self._runs} runs{eta}{bad}", end="", file=sys.stderr, flush=True)

    def end(self) -> None:
        """Ends the line."""
        if self._is_shown:
            print(file=sys.stderr)

    @property
    def _clear(self) -> str:
        return "\r\033[K" if self._is_shown else ""
