"""Process that makes the runs of a plan: ``python -m codrive_sim._sweep_worker PLAN OUT``. It takes the number of a run and the name of its part."""

from __future__ import annotations

import sys
from collections.abc import Callable

from codrive_sim._codrive import Plan
from codrive_sim._run_process import Report, serve
from codrive_sim._run_store import Checkpoint, Store


def maker(plan: str, out: str, report: Report) -> Callable[[str], None]:
    """Returns the function that makes a run of a plan."""
    runs, store = Plan(plan), Store(out)

    def make(asked: str) -> None:
        number, name = asked.split()
        own = runs.part_name(int(number))
        if own != name:
            raise RuntimeError(
                f"run {number} is {own} on this machine and {name} on the machine that started the sweep\n"
                "  remedy: install the same version of codrive on all machines"
            )
        store.put(name, runs.execute(int(number), Checkpoint(store, name, report)))

    return make


if __name__ == "__main__":
    serve(lambda report: maker(*sys.argv[1:], report))
