"""Runs all runs of a plan on a Ray cluster: ``python -m codrive_sim.sweep PLAN.toml --out FOLDER_OR_URL`` (or ``codrive sweep --on ray``).

Each run is a task of its own. The task writes the part of its run once, to a folder or to any address that fsspec knows
(``s3://bucket/path``). Existing parts are not made again: a second start makes the missing ones, and a training continues from its
checkpoint there. The parts are the same bytes as in ``codrive sweep`` on one machine. Limits and texts of failures are those of the
program; distribution and retries are Ray's, which also repeats runs that were lost with a machine.
"""

from __future__ import annotations

import argparse
import hashlib
import pathlib
import sys
import tempfile
from typing import Any

from codrive_sim._codrive import Plan
from codrive_sim._distribute import Meter, RayCluster, distribute
from codrive_sim._run_process import run_beside
from codrive_sim._run_store import PARTS, Store

#: Maximum size of the files beside a plan, which are copied to every machine, bytes.
MOST_BYTES = 64 << 20


def beside(plan: pathlib.Path, out: str) -> dict[str, bytes]:
    """Returns the files of a plan's folder, which its runs may read, by their names in it, without results.

    Raises:
        ValueError: The files are too large to be copied.
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
                "  remedy: put the plan and the files that it names into a separate folder"
            )
        files[str(name)] = path.read_bytes()
    return files


#: Private folders of this process with the files of sweeps, by their digest; removed with the process.
_files_of: dict[str, tempfile.TemporaryDirectory[str]] = {}


def _digest(files: dict[str, bytes]) -> str:
    """Returns a name for files with these contents."""
    contents = sorted((file, hashlib.sha256(text).hexdigest()) for file, text in files.items())
    return hashlib.sha256(repr(contents).encode()).hexdigest()[:24]


def execute(digest: str, files: list[Any], plan: str, number: int, name: str, limit_s: float | None, out: str) -> list[str]:
    """Makes one run in a process of the cluster and writes its part. Returns the reports about it.

    Args:
        digest: Name of the files.
        files: Reference to the files, in a list, so that only machines without the files resolve it.
        plan: Name of the plan among the files.
        number: Number of the run.
        name: Name of its part.
        limit_s: Time limit of the run, s.
        out: Folder, or an address of fsspec.

    Raises:
        RuntimeError: The run failed, crashed its process, or was not done after ``limit_s`` seconds.
    """
    if digest not in _files_of:
        import ray

        # A folder with a predictable name could belong to another user, with their plan.
        made = tempfile.TemporaryDirectory(prefix="codrive-sweep-")
        for file, text in ray.get(files[0]).items():
            path = pathlib.Path(made.name) / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(text)
        _files_of[digest] = made
    folder = pathlib.Path(_files_of[digest].name)
    return run_beside(("codrive_sim._sweep_worker", str(folder / plan), out), f"{number} {name}", limit_s)


def sweep(
    plan: str,
    out: str,
    *,
    workers: int | None = None,
    retries: int = 1,
    address: str | None = None,
    progress: bool | None = None,
) -> dict[int, str]:
    """Makes the missing runs of a plan on a Ray cluster.

    Args:
        plan: File of the plan. The files beside it are copied to the machines.
        out: Folder, or an address of fsspec that all machines reach.
        workers: Number of tasks at a time; None: from the cores of the cluster.
        retries: Number of further attempts for a failed run, after all others. Runs lost with a failed node are always repeated.
        address: Address of the cluster; None: that of ``RAY_ADDRESS``, else a cluster on this machine.
        progress: Shows progress on standard error; None: if it is a terminal.

    Returns:
        The runs that failed after all attempts, with the reason, by number.

    Raises:
        ValueError: The plan is wrong.
    """
    path = pathlib.Path(plan)
    runs = Plan(str(path))
    names, limits_s = runs.part_names(), runs.limits_s()
    # Processes of the cluster have their own working directories.
    store = Store(out)
    out = out if store.folder is None else str(store.folder)
    there = store.names()
    due = [number for number, name in enumerate(names) if name not in there]
    meter = Meter(len(names), len(names) - len(due), progress)
    if not due:
        meter.end()
        return {}
    carried = beside(path, out)
    cluster = RayCluster(workers, address)
    files, digest = [cluster.shared(carried)], _digest(carried)
    due_runs = {number: (digest, files, path.name, number, names[number], limits_s[number], out) for number in due}
    return distribute(cluster, execute, due_runs, retries, meter)


def collect(plan: str, out: str) -> list[tuple[str, int, int]]:
    """Joins the existing runs of a plan into one table per kind, beside the parts, and writes the policies of trainings.

    Returns:
        (file, runs, rows) of each table.
    """
    runs, store = Plan(plan), Store(out)
    if store.folder is not None:
        return [(str(path), count, rows) for path, count, rows in runs.collect(str(store.folder))]
    with tempfile.TemporaryDirectory(prefix="codrive-sweep-") as folder:
        root = pathlib.Path(folder)
        (root / PARTS).mkdir()
        there = store.names()
        store.get((name for name in dict.fromkeys(runs.part_names()) if name in there), root / PARTS)
        tables = runs.collect(folder)
        made = (path for path in root.rglob("*") if path.is_file() and path.parent.name != PARTS)
        for path in made:
            store.upload(path, path.relative_to(root).as_posix())
        return [(f"{out.rstrip('/')}/{pathlib.Path(path).name}", count, rows) for path, count, rows in tables]


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line. Returns the exit status: 0 done, 1 runs failed, 2 the plan is wrong, 130 stopped."""
    parser = argparse.ArgumentParser(prog="python -m codrive_sim.sweep", description=__doc__.splitlines()[0])
    parser.add_argument("plan", help="file of the plan (TOML), beside the files that it names")
    parser.add_argument("--out", required=True, help="folder of the results, or an address of fsspec such as s3://bucket/path")
    parser.add_argument("--workers", type=int, help="number of runs at a time [default: the cores of the cluster]")
    parser.add_argument("--retries", type=int, default=1, help="number of further attempts for a failed run [default: 1]")
    parser.add_argument("--address", help="address of the Ray cluster [default: RAY_ADDRESS, else a cluster on this machine]")
    parser.add_argument("--collect", action="store_true", help="run nothing; join the finished runs into tables")
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
        print(f"\ncodrive: {Plan.stopped()}", file=sys.stderr)
        return 130
    print(f"codrive: {Plan(given.plan).failure_report(sorted(failed.items()))}", file=sys.stderr)
    return 1


if __name__ == "__main__":
    # Imported by its package name, so that processes of the cluster find the functions in the package.
    from codrive_sim.sweep import main as command

    sys.exit(command())
