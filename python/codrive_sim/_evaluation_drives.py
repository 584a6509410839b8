"""Drives of evaluations: one in this process, and many in worker processes at once."""

from __future__ import annotations

import json
import os
import queue
import threading
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from codrive_sim._codrive import DriveConfiguration, EvaluationDrive
from codrive_sim._drives import Arguments
from codrive_sim._words import InWordsOfPython
from codrive_sim._workers import WorkerDrive

#: Interval of checks for Ctrl-C during a wait, s.
_LOOK_S = 0.2

#: Function from the number of a policy, one for each advised vehicle, and its observation, float32, ``(1, k)``, to the action.
Ask = Callable[[int, NDArray[np.float32]], float]


class EvaluationArguments(NamedTuple):
    """Arguments of ``EvaluationDrive``; ``policy`` is None for a policy that is asked."""

    drive: Arguments
    policy: str | None
    policy_speed_mps: float
    advised: str | None

    def checked(self) -> EvaluationDrive:
        """Returns the checked drives.

        Raises:
            ValueError: There is no such policy, or the road allows no such drive.
        """
        with InWordsOfPython():
            return EvaluationDrive(DriveConfiguration(*self.drive), *self[1:])


class Question(NamedTuple):
    """Question of a drive for the next action of one of its policies."""

    policy: int
    seen: NDArray[np.float32]


class LocalEvaluation:
    """Drives of an evaluation in this process, one after the other."""

    def __init__(self, arguments: EvaluationArguments, ask: Ask) -> None:
        self._drives = arguments.checked()
        self._ask = ask if arguments.policy is None else None

    def begin(self, seed: int) -> dict[str, Any]:
        """Drives the drive of this seed to its end, and returns its result."""
        with InWordsOfPython():
            return json.loads(self._drives.evaluate(seed, self._ask))


class Job(NamedTuple):
    """One drive to be driven in a process with these variables of the environment."""

    arguments: EvaluationArguments
    variables: dict[str, str]
    seed: int
    #: Function that returns what answers the questions of one new policy; a policy by name has none.
    engage: Callable[[], Callable[[NDArray[np.float32]], NDArray[np.float32]]]


class _Running:
    """Process that drives one job after the other, and the policies of its present drive."""

    def __init__(self, number: int, job: Job, before: _Running | None) -> None:
        """Begins a job, in the process of ``before`` if it has the same settings."""
        self.number = number
        self.job = job
        self._policies: dict[int, Callable[[NDArray[np.float32]], NDArray[np.float32]]] = {}
        if before is not None and before.job.arguments == job.arguments:
            self.drive = before.drive
        else:
            if before is not None:
                before.drive.close()
            self.drive = WorkerDrive(job.arguments, job.variables, os.getcwd(), "call codrive_sim.evaluate again")
        self.drive.ask("begin", job.seed)

    def listen(self, events: queue.SimpleQueue[tuple[_Running, Any, BaseException | None]]) -> None:
        """Passes on the questions of the drive up to its result, or to its failure."""
        while True:
            try:
                said, fault = self.drive.answer(), None
            except BaseException as why:
                said, fault = None, why
            events.put((self, said, fault))
            if not isinstance(said, Question):
                return

    def respond(self, question: Question) -> None:
        """Answers a question by the policy that it is for."""
        if question.policy not in self._policies:
            self._policies[question.policy] = self.job.engage()
        self.drive.reply(float(self._policies[question.policy](question.seen)[0]))


def cores() -> int:
    """Returns the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def results_of(jobs: Sequence[Job], done: Callable[[int], None]) -> list[dict[str, Any]]:
    """Drives all jobs in processes on all cores. Policies are asked in this thread, in which Ctrl-C arrives.

    Args:
        jobs: Drives, those with the same settings beside each other.
        done: Gets the number of finished drives.

    Returns:
        The results, in the order of the jobs.

    Raises:
        RuntimeError: A drive has failed, or its process has ended.
    """
    results: list[dict[str, Any]] = [{} for _ in jobs]
    events: queue.SimpleQueue[tuple[_Running, Any, BaseException | None]] = queue.SimpleQueue()
    waiting = iter(enumerate(jobs))
    running: dict[int, _Running] = {}
    finished = 0

    def begin(worker: int) -> None:
        number, job = next(waiting, (-1, None))
        if job is None:
            running.pop(worker).drive.close()
            return
        running[worker] = _Running(number, job, running.get(worker))
        threading.Thread(target=running[worker].listen, args=(events,), daemon=True).start()

    try:
        for worker in range(min(cores(), len(jobs))):
            begin(worker)
        while running:
            try:
                one, said, fault = events.get(timeout=_LOOK_S)
            except queue.Empty:
                continue
            if fault is not None:
                raise fault
            if isinstance(said, Question):
                one.respond(said)
                continue
            results[one.number] = said
            finished += 1
            done(finished)
            begin(next(worker for worker, other in running.items() if other is one))
    finally:
        # Without a failure all of them have been closed.
        for one in running.values():
            one.drive.kill()
    return results
