"""Processes that make runs for this one, so that a run that hangs or crashes affects nothing else.

They speak the protocol of the program's own workers (src/sweep/supervisor.rs): an answer is a JSON string, empty if the run is done, and a
report is ``{"report": "text"}``. They end with the process that started them.
"""

from __future__ import annotations

import json
import os
import queue
import subprocess
import sys
import threading
import time
from collections.abc import Callable

from codrive_sim._codrive import Plan

#: Function that takes reports about a run.
Report = Callable[[str], None]
#: A run has one core; numpy's libraries and the rings of a training would take all.
_ONE_CORE = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "RAYON_NUM_THREADS": "1"}


class RunProcess:
    """Handle of a process that makes runs."""

    def __init__(self, module: str, *arguments: str) -> None:
        """Starts ``python -m module arguments``, which calls :func:`serve`, and waits until it is ready.

        Raises:
            RuntimeError: The process cannot make runs.
        """
        # Ctrl-C is for the process that started it, which ends it.
        self._process = subprocess.Popen(
            [sys.executable, "-m", module, *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, **_ONE_CORE},
            start_new_session=True,
        )
        _started.append(self)
        self._messages: queue.SimpleQueue[str | dict[str, str] | None] = queue.SimpleQueue()
        threading.Thread(target=self._listen, daemon=True).start()
        self._check(self._messages.get())

    @property
    def is_alive(self) -> bool:
        """Returns True if the process can take a run."""
        return self._process.poll() is None

    def run(self, asked: str, limit_s: float | None = None) -> list[str]:
        """Makes a run in the process, which writes its part. Returns the reports about it.

        Raises:
            RuntimeError: The run failed, crashed the process, or was not done after ``limit_s`` seconds.
        """
        try:
            self._process.stdin.write(f"{asked}\n")
            self._process.stdin.flush()
        except OSError:
            pass  # The missing answer below reports a process that has ended.
        deadline = None if limit_s is None else time.monotonic() + limit_s
        reports: list[str] = []
        while True:
            try:
                message = self._messages.get(timeout=None if deadline is None else max(deadline - time.monotonic(), 0.0))
            except queue.Empty:
                self.close()
                raise RuntimeError(Plan.timed_out(limit_s)) from None
            if not isinstance(message, dict):
                self._check(message)
                return reports
            reports.append(message["report"])

    def close(self) -> None:
        """Ends the process. Its part is then complete or missing."""
        self._process.kill()
        self._process.wait()
        if self in _started:
            _started.remove(self)

    def _check(self, answer: str | None) -> None:
        if answer is None:
            raise RuntimeError(Plan.process_ended(f"exit status {self._process.wait()}"))
        if answer:
            raise RuntimeError(answer)

    def _listen(self) -> None:
        for line in self._process.stdout:
            self._messages.put(json.loads(line))
        self._messages.put(None)


#: Processes that this process has started and not ended.
_started: list[RunProcess] = []
#: Process of each thread, with its command.
_own = threading.local()


def run_beside(command: tuple[str, ...], asked: str, limit_s: float | None = None) -> list[str]:
    """Makes a run in the process of this thread for this command (module and arguments), as :meth:`RunProcess.run` does; starts it first if
    there is none."""
    process: RunProcess | None = getattr(_own, "process", None)
    if process is None or _own.command != command or not process.is_alive:
        if process is not None:
            process.close()
        _own.process, _own.command = None, command
        _own.process = process = RunProcess(*command)
    return process.run(asked, limit_s)


def end_all() -> None:
    """Ends all processes that make runs for this one."""
    for process in list(_started):
        process.close()


def serve(prepare: Callable[[Report], Callable[[str], None]]) -> None:
    """Makes runs as the process of a :class:`RunProcess`. ``prepare`` gets the function that takes reports and returns the one that makes the
    run of a line."""
    # Output of libraries must not get between the messages.
    messages = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    asked: queue.SimpleQueue[str] = queue.SimpleQueue()

    def send(message: str | dict[str, str]) -> None:
        messages.write(json.dumps(message) + "\n")
        messages.flush()

    def listen() -> None:
        for line in sys.stdin:
            asked.put(line)
        # The other process has ended, and nothing else would stop a run that hangs.
        os._exit(0)

    try:
        make = prepare(lambda text: send({"report": text}))
    except Exception as why:
        send(str(why) or repr(why))
        return
    send("")
    threading.Thread(target=listen, daemon=True).start()
    while True:
        line = asked.get()
        try:
            make(line)
        except Exception as why:
            send(str(why) or repr(why))
        else:
            send("")
