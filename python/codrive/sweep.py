"""All runs of a plan on a Ray cluster: ``python -m codrive.sweep PLAN.toml --out FOLDER_OR_URL`` (or ``codrive sweep --on ray``).

Each run is a task of its own. Its part is written once, by the task, to a folder or to any address that fsspec knows
(``s3://bucket/path``), and what is there is not made again: a second start does what is missing. The parts are the same bytes as those of
``codrive sweep`` on one machine.
"""

from __future__ import annotations

import argparse
import hashlib
import pathlib
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from typing import Any

from codrive._codrive import Plan
from codrive._sweep_store import PARTS, Store
from codrive._sweep_worker import Worker

#: The files beside a plan are carried to every machine; so many bytes at the most.
MOST_BYTES = 64 << 20
#: Tasks that wait at a time for each core: enough that none is idle, few enough that a stop is heard at once.
WAITING = 4
#: So many failures are told; the others are counted.
TOLD = 10


def beside(plan: pathlib.Path, out: str) -> dict[str, bytes]:
    """The files of a plan's folder, which its runs may read, by their names in it; results are none of them.

    Raises:
        ValueError: They are too many to be carried.
    """
    folder = plan.resolve().parent
    results = pathlib.Path(out).resolve()
    files: dict[str, bytes] = {}
    size = 0
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder)
        if not path.is_file() or results in path.parents or any(part.startswith(".") for part in name.parts):
            continue
        size += path.stat().st_size
        if size > MOST_BYTES:
            raise ValueError(
                f"{folder}: more than {MOST_BYTES >> 20} MiB lie beside the plan\n"
                "  remedy: put it, with the files that it names, into a folder of its own"
            )
        files[str(name)] = path.read_bytes()
    return files


#: The process that makes runs for this one, and the plan and the place that it is for.
_at_work: dict[tuple[str, str], Worker] = {}
#: Private folders of this process with the files of sweeps, by the name of those files; they go with the process.
_files_of: dict[str, tempfile.TemporaryDirectory[str]] = {}


def _worker(plan: str, out: str) -> Worker:
    """The process for a plan: the one that is there, or a new one where it has ended or was for another."""
    for asked, worker in list(_at_work.items()):
        if asked != (plan, out) or not worker.is_alive:
            _at_work.pop(asked).close()
    if (plan, out) not in _at_work:
        _at_work[plan, out] = Worker(plan, out)
    return _at_work[plan, out]


def _digest(files: dict[str, bytes]) -> str:
    """A name for files with these contents."""
    contents = sorted((file, hashlib.sha256(text).hexdigest()) for file, text in files.items())
    return hashlib.sha256(repr(contents).encode()).hexdigest()[:24]


def execute(digest: str, files: list[Any], plan: str, number: int, name: str, limit_s: float | None, out: str) -> str:
    """One run, in a process of the cluster. Gives the name of its part, which is written.

    Args:
        digest: A name for the files.
        files: A reference to them, in a list, so that it is looked at on machines alone that do not have them yet.
        plan: Name of the plan among them.
        number: Number of the run.
        name: Name of its part.
        limit_s: How long it may take, s.
        out: Folder, or an address of fsspec.

    Raises:
        RuntimeError: It failed, took its process along, or was not done after ``limit_s`` seconds.
    """
    if digest not in _files_of:
        import ray

        # A name that can be guessed could be somebody else's folder, with a plan of theirs.
        made = tempfile.TemporaryDirectory(prefix="codrive-sweep-")
        for file, text in ray.get(files[0]).items():
            path = pathlib.Path(made.name) / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(text)
        _files_of[digest] = made
    folder = pathlib.Path(_files_of[digest].name)
    _worker(str(folder / plan), out).run(number, name, limit_s)
    return name


def sweep(
    plan: str,
    out: str,
    *,
    workers: int | None = None,
    retries: int = 1,
    address: str | None = None,
    progress: bool | None = None,
) -> dict[int, str]:
    """Carries out what is missing of a plan on a Ray cluster.

    Args:
        plan: The plan's file. The files beside it are carried along.
        out: Folder, or an address of fsspec that all machines reach.
        workers: Tasks at a time; None: the cores of the cluster.
        retries: How often a run that failed is tried again, after all others. What a node takes along that is no more is always
            made again.
        address: Of the cluster; None: the one of ``RAY_ADDRESS``, else one on this machine.
        progress: Says on the standard error how far it is; None: where a person watches.

    Returns:
        What failed in the end: number of the run, and why.

    Raises:
        ValueError: The plan is wrong.
    """
    try:
        import ray
    except ImportError:
        raise ImportError("a sweep on a cluster needs Ray: pip install 'codrive[ray]'") from None
    path = pathlib.Path(plan)
    runs = Plan(str(path))
    names, limits_s = runs.part_names(), runs.limits_s()
    # Processes of the cluster have working directories of their own.
    store = Store(out)
    out = out if store.folder is None else str(store.folder)
    there = store.names()
    due = [number for number, name in enumerate(names) if name not in there]
    meter = _Meter(len(names), len(names) - len(due), progress)
    if not due:
        meter.end()
        return {}
    carried = beside(path, out)
    if not ray.is_initialized():
        ray.init(address=address, log_to_driver=False, logging_level="warning")
    # SUMO runs once in a process, which Ray gives one task at a time; a task on a core has one thread.
    task = ray.remote(num_cpus=1, max_retries=-1, runtime_env={"env_vars": {"RAYON_NUM_THREADS": "1"}})(execute)
    files, digest = [ray.put(carried)], _digest(carried)
    at_a_time = workers or int(ray.cluster_resources().get("CPU", 1)) * WAITING
    failed: dict[int, str] = {}
    for _ in range(retries + 1):
        failed = {}
        waiting: Iterator[int] = iter(due)
        begun: dict[Any, int] = {}
        while True:
            while len(begun) < at_a_time and (number := next(waiting, None)) is not None:
                begun[task.remote(digest, files, path.name, number, names[number], limits_s[number], out)] = number
            if not begun:
                break
            done, _rest = ray.wait(list(begun), num_returns=1, timeout=1.0)
            for ref in done:
                number = begun.pop(ref)
                try:
                    ray.get(ref)
                    meter.one()
                except ray.exceptions.RayTaskError as why:
                    failed[number] = str(why.cause) if why.cause is not None else str(why)
                except ray.exceptions.RayError as why:
                    failed[number] = str(why)
            meter.show(len(failed))
        due = sorted(failed)
        if not due:
            break
    meter.end()
    return failed


def collect(plan: str, out: str) -> list[tuple[str, int, int]]:
    """Puts the runs of a plan that are there into one table a kind, beside the parts. Gives (file, runs, rows) of each."""
    runs, store = Plan(plan), Store(out)
    if store.folder is not None:
        return [(str(path), count, rows) for path, count, rows in runs.collect(str(store.folder))]
    with tempfile.TemporaryDirectory(prefix="codrive-sweep-") as folder:
        root = pathlib.Path(folder)
        (root / PARTS).mkdir()
        there = store.names()
        store.get((name for name in dict.fromkeys(runs.part_names()) if name in there), root / PARTS)
        tables = runs.collect(folder)
        for path, _, _ in tables:
            store.upload(pathlib.Path(path))
        return [(f"{out.rstrip('/')}/{pathlib.Path(path).name}", count, rows) for path, count, rows in tables]


class _Meter:
    """How far a sweep is, in one line."""

    def __init__(self, runs: int, there: int, shown: bool | None) -> None:
        self._runs, self._there, self._done = runs, there, 0
        self._start = time.monotonic()
        self._is_shown = sys.stderr.isatty() if shown is None else shown

    def one(self) -> None:
        """One more is done."""
        self._done += 1

    def show(self, failed: int) -> None:
        """Says it, where somebody watches."""
        if not self._is_shown:
            return
        left = self._runs - self._there - self._done
        eta = f", {(time.monotonic() - self._start) / self._done * left:.0f} s left" if self._done else ""
        bad = f", {failed} failed" if failed else ""
        print(f"\r\033[K{self._there + self._done} of {self._runs} runs{eta}{bad}", end="", file=sys.stderr, flush=True)

    def end(self) -> None:
        """All are done."""
        if self._is_shown:
            print(file=sys.stderr)


def main(arguments: list[str] | None = None) -> int:
    """The command. Gives its exit status: 0 done, 1 something failed, 2 the plan is wrong, 130 stopped."""
    parser = argparse.ArgumentParser(prog="python -m codrive.sweep", description=__doc__.splitlines()[0])
    parser.add_argument("plan", help="the plan (TOML); files that it names lie beside it")
    parser.add_argument("--out", required=True, help="folder of the results, or an address of fsspec such as s3://bucket/path")
    parser.add_argument("--workers", type=int, help="runs at a time [default: the cores of the cluster]")
    parser.add_argument("--retries", type=int, default=1, help="how often a run that failed is tried again [default: 1]")
    parser.add_argument("--address", help="of the Ray cluster [default: RAY_ADDRESS, else one on this machine]")
    parser.add_argument("--collect", action="store_true", help="run nothing; put the runs that are there into tables")
    given = parser.parse_args(arguments)
    try:
        failed = {}
        if not given.collect:
            options = {"workers": given.workers, "retries": given.retries, "address": given.address}
            failed = sweep(given.plan, given.out, **options)
        if not failed:
            for path, runs, rows in collect(given.plan, given.out):
                print(f"{path}: {runs} runs, {rows} rows")
            return 0
    except (ValueError, ImportError) as why:
        print(f"codrive: {why}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("\ncodrive: stopped; the same command makes what is missing", file=sys.stderr)
        return 130
    plan = Plan(given.plan)
    print(f"codrive: {len(failed)} runs failed; the same command tries them again", file=sys.stderr)
    for number, why in list(failed.items())[:TOLD]:
        table, varied = plan.words(number)
        print(f"  run {number}, {table}: {varied}: {why}", file=sys.stderr)
    if len(failed) > TOLD:
        print(f"  and {len(failed) - TOLD} more", file=sys.stderr)
    return 1


if __name__ == "__main__":
    # By its own name, so that the cluster's processes find what they are given in the package.
    from codrive.sweep import main as command

    sys.exit(command())
