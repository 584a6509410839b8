"""Process that makes the runs of a cluster task, so that a run that hangs or crashes affects nothing else.

The process runs this module. It speaks the protocol of the program's own workers (src/sweep/supervisor.rs), with the name of the part
after each number. It ends with the process that started it.
"""

from __future__ import annotations

import json
import os
import queue
import subprocess
import sys
import threading
from typing import IO

from codrive._codrive import Plan
from codrive._sweep_store import Store


class Worker:
    """Handle of the process for the one that started it."""

    def __init__(self, plan: str, out: str) -> None:
        """Starts the process, and waits until it has read the plan.

        Raises:
            RuntimeError: The process cannot read the plan.
        """
        command = [sys.executable, "-m", __name__, plan, out]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self._answers: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        threading.Thread(target=self._listen, daemon=True).start()
        self._check(self._answers.get())

    @property
    def is_alive(self) -> bool:
        """Returns True if the process can take a run."""
        return self._process.poll() is None

    def run(self, number: int, name: str, limit_s: float | None) -> None:
        """Makes a run in the process, which writes its part.

        Raises:
            RuntimeError: The run failed, crashed the process, or was not done after ``limit_s`` seconds.
        """
        try:
            self._process.stdin.write(f"{number} {name}\n")
            self._process.stdin.flush()
        except OSError:
            pass  # The missing response below reports a process that has ended.
        try:
            answer = self._answers.get(timeout=limit_s)
        except queue.Empty:
            self.close()
            raise RuntimeError(Plan.timed_out(limit_s)) from None
        self._check(answer)

    def close(self) -> None:
        """Ends the process. Its part is then complete or missing."""
        self._process.kill()
        self._process.wait()

    def _check(self, answer: str | None) -> None:
        if answer is None:
            raise RuntimeError(Plan.process_ended(f"exit status {self._process.wait()}"))
        if answer:
            raise RuntimeError(answer)

    def _listen(self) -> None:
        for line in self._process.stdout:
            self._answers.put(json.loads(line))
        self._answers.put(None)


def _make(plan: Plan, store: Store, asked: str) -> None:
    """Makes the run of a line with its number and the name of its part."""
    number, name = asked.split()
    own = plan.part_name(int(number))
    if own != name:
        raise RuntimeError(
            f"run {number} is {own} on this machine and {name} on the machine that started the sweep\n"
            "  remedy: install the same version of codrive on all machines"
        )
    store.put(name, plan.execute(int(number)))


def main(plan: str, out: str) -> None:
    """Runs the process."""
    # Output of libraries must not get between the responses.
    answers: IO[str] = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    asked: queue.SimpleQueue[str] = queue.SimpleQueue()

    def listen() -> None:
        for line in sys.stdin:
            asked.put(line)
        # The other process has ended, and nothing else would stop a run that hangs.
        os._exit(0)

    def answer(text: str) -> None:
        answers.write(json.dumps(text) + "\n")
        answers.flush()

    try:
        runs, store = Plan(plan), Store(out)
    except Exception as why:
        answer(str(why) or repr(why))
        return
    answer("")
    threading.Thread(target=listen, daemon=True).start()
    while True:
        line = asked.get()
        try:
            _make(runs, store, line)
        except Exception as why:
            answer(str(why) or repr(why))
        else:
            answer("")


if __name__ == "__main__":
    main(*sys.argv[1:])
