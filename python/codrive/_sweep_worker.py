"""A process beside a task of a cluster that makes the runs: one that hangs, or that takes its process along, costs itself and nothing else.

The process is this module by its own name. It says an empty text when it has read the plan; then it takes lines of a number and the name of
a part, and says of each an empty text when the part is written, else why it failed: JSON, a line each. It ends with whoever
started it.
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
    """The process, as seen by the one that started it."""

    def __init__(self, plan: str, out: str) -> None:
        """Starts it, and waits until it has read the plan.

        Raises:
            RuntimeError: It cannot read it.
        """
        command = [sys.executable, "-m", __name__, plan, out]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self._answers: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        threading.Thread(target=self._listen, daemon=True).start()
        self._check(self._answers.get())

    @property
    def is_alive(self) -> bool:
        """Whether it takes a run."""
        return self._process.poll() is None

    def run(self, number: int, name: str, limit_s: float | None) -> None:
        """Has it make a run; its part is written afterwards.

        Raises:
            RuntimeError: It failed, took the process along, or was not done after ``limit_s`` seconds.
        """
        try:
            self._process.stdin.write(f"{number} {name}\n")
            self._process.stdin.flush()
        except OSError:
            pass  # A process that is no more is told by its silence.
        try:
            answer = self._answers.get(timeout=limit_s)
        except queue.Empty:
            self.close()
            raise RuntimeError(f"it was not done after limit_s, {limit_s:g} s") from None
        self._check(answer)

    def close(self) -> None:
        """Ends it. A part is there whole or not at all."""
        self._process.kill()
        self._process.wait()

    def _check(self, answer: str | None) -> None:
        if answer is None:
            raise RuntimeError(f"its process ended (exit status {self._process.wait()})")
        if answer:
            raise RuntimeError(answer)

    def _listen(self) -> None:
        for line in self._process.stdout:
            self._answers.put(json.loads(line))
        self._answers.put(None)


def _make(plan: Plan, store: Store, asked: str) -> None:
    """A run: its number, and the name of its part."""
    number, name = asked.split()
    own = plan.part_name(int(number))
    if own != name:
        raise RuntimeError(
            f"run {number} is {own} on this machine and {name} where the sweep was started\n"
            "  remedy: install the same version of codrive on all machines"
        )
    store.put(name, plan.execute(int(number)))


def main(plan: str, out: str) -> None:
    """The process itself."""
    # What libraries print must not get between the answers.
    answers: IO[str] = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    asked: queue.SimpleQueue[str] = queue.SimpleQueue()

    def listen() -> None:
        for line in sys.stdin:
            asked.put(line)
        # Whoever asked is no more, and nobody is there who would stop a run that hangs.
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
