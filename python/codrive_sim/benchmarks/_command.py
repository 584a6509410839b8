"""Results and trainings of the benchmarks, on the cores of this computer or on a Ray cluster.

    python -m codrive_sim.benchmarks                                            the table of results; also: table [NAMES]
    python -m codrive_sim.benchmarks train Flow-Merge-v1 --seeds 1-3 --out trained
    python -m codrive_sim.benchmarks table Flow-Merge-v1 --policies trained

With --out, each drive and each training is made once: after Ctrl-C or a failure, the same command makes what is missing. A training keeps a
checkpoint after each generation and goes on from it, on any machine.
"""

from __future__ import annotations

import argparse
import json
import pathlib
import sys
import tempfile
from collections.abc import Callable

from codrive_sim._codrive import Plan
from codrive_sim._distribute import Cores, Place, RayCluster
from codrive_sim._run_store import Store
from codrive_sim.benchmarks import BENCHMARKS, Benchmark
from codrive_sim.benchmarks._policies import POLICIES
from codrive_sim.benchmarks._runs import FailedRuns, Training, make_all
from codrive_sim.benchmarks._table import Evaluated, csv, drives, fingerprint, table
from codrive_sim.benchmarks.train import library

#: Largest seed of a training: its episodes have seeds below those of evaluations.
_MOST_SEED = 99


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line. Returns the exit status: 0 done, 1 runs failed, 2 the arguments are wrong, 130 stopped."""
    given = sys.argv[1:] if arguments is None else arguments
    # The table is the command without a name.
    if not given or given[0] not in ("table", "train", "-h", "--help"):
        given = ["table", *given]
    parser = _parser()
    options = parser.parse_args(given)
    options.names = _chosen(parser, options.names)
    try:
        options.command(parser, options)
    except FailedRuns as why:
        print(f"codrive: {why}", file=sys.stderr)
        return 1
    except (ValueError, ImportError, FileNotFoundError) as why:
        print(f"codrive: {why}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print(f"\ncodrive: {Plan.stopped() if options.out else 'ended by Ctrl-C'}", file=sys.stderr)
        return 130
    return 0


def _parser() -> argparse.ArgumentParser:
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="python -m codrive_sim.benchmarks", description=__doc__, formatter_class=raw)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    names = f"benchmarks, without the version or with it: {', '.join(benchmark.name for benchmark in BENCHMARKS)}"
    made = commands.add_parser("table", help="make the table of results; the command without a name")
    made.set_defaults(command=_table)
    made.add_argument("names", nargs="*", metavar="NAME", help=f"{names}; all without a name")
    made.add_argument("--drives", type=_whole(1), default=10, help="drives of each benchmark and policy, default 10")
    made.add_argument("--policies", type=pathlib.Path, default=POLICIES, help="folder of policies, NAME.SEED.json; default: the shipped ones")
    made.add_argument("--out", help="folder, or address of fsspec such as s3://bucket/path, that keeps the drives; else each is made again")
    trained = commands.add_parser("train", help="train policies by CMA-ES, one for each benchmark and seed")
    trained.set_defaults(command=_train)
    trained.add_argument("names", nargs="+", metavar="NAME", help=names)
    trained.add_argument("--seeds", type=_seeds, default=[1], help="seeds of the trainings, such as 1-3 or 1,4; default 1")
    trained.add_argument("--episodes", type=_whole(1), default=100, help="episodes of each training, default 100")
    trained.add_argument("--out", required=True, help="folder, or an address of fsspec such as s3://bucket/path, of the policies")
    for command in (made, trained):
        command.add_argument("--actions", type=_whole(0), default=0, help="end each drive after this many actions, for a trial; 0 is its horizon")
        command.add_argument("--on", choices=["cores", "ray"], default="cores", help="place of the runs: the cores of this computer, or a Ray cluster")
        command.add_argument("--address", help="address of the Ray cluster [default: RAY_ADDRESS, else a cluster on this machine]")
        command.add_argument("--workers", type=_whole(1), help="number of runs at a time [default: the cores]")
        command.add_argument("--retries", type=_whole(0), default=1, help="number of further attempts for a failed run, default 1")
    return parser


def _table(parser: argparse.ArgumentParser, options: argparse.Namespace) -> None:
    """Makes the table, and ``drives.csv`` in ``--out``."""
    if options.out is None and options.on == "ray":
        parser.error("--on ray needs --out, a folder or an address that all machines reach")
    chosen = drives(options.names, options.policies, options.drives, options.actions)
    with tempfile.TemporaryDirectory(prefix="codrive-benchmarks-") as folder:
        store = Store(options.out or folder)
        made = make_all([drive for _, _, drive in chosen], _place(options), store, options.retries)
        results = [Evaluated(*about, *result) for about, result in zip(chosen, made)]
        store.write("drives.csv", csv(results).encode())
    print(table(results))
    print(f"\n{len(results)} drives, fingerprint {fingerprint(results)}")


def _train(parser: argparse.ArgumentParser, options: argparse.Namespace) -> None:
    """Trains, and writes ``NAME.SEED.json`` of each training and ``curves.csv`` into ``--out``."""
    library()
    store = Store(options.out)
    trainings = [Training(benchmark.name, seed, options.episodes, options.actions) for benchmark in options.names for seed in options.seeds]
    rows = ["benchmark,seed,generation,reward,evaluation"]
    for result in make_all(trainings, _place(options), store, options.retries):
        curve = result.pop("curve")
        file = f"{result['benchmark']}.{result['seed']}.json"
        store.write(file, f"{json.dumps(result)}\n".encode())
        rows += [f"{result['benchmark']},{result['seed']},{k},{reward!r},{value!r}" for k, (reward, value) in enumerate(curve, 1)]
        reached = f"reward {curve[-1][0]:.4f}, evaluation {curve[-1][1]:.2f}"
        print(f"{options.out.rstrip('/')}/{file}: {result['episodes']} episodes, best of the last generation: {reached}")
    store.write("curves.csv", ("\n".join(rows) + "\n").encode())


def _place(options: argparse.Namespace) -> Place:
    return RayCluster(options.workers, options.address) if options.on == "ray" else Cores(options.workers)


def _chosen(parser: argparse.ArgumentParser, names: list[str]) -> list[Benchmark]:
    """Returns the benchmarks whose names begin with one of these; all without a name."""
    known = [benchmark.name for benchmark in BENCHMARKS]
    for name in names:
        if not any(own.startswith(name) for own in known):
            parser.error(f"no benchmark is called {name!r}; allowed: {', '.join(known)}")
    return [benchmark for benchmark in BENCHMARKS if not names or benchmark.name.startswith(tuple(names))]


def _whole(least: int) -> Callable[[str], int]:
    """Returns the reader of a whole number that is not below ``least``."""

    def number(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"{text!r}; allowed: a whole number, {least} or more")
        return int(text)

    return number


def _seeds(text: str) -> list[int]:
    """Returns the seeds of a range such as ``1-3``, or of a list such as ``1,4``."""
    first, _, last = text.partition("-")
    numbers = text.split(",")
    if first.isdecimal() and last.isdecimal():
        seeds = list(range(int(first), int(last) + 1))
    else:
        seeds = [int(number) for number in numbers if number.isdecimal()] if all(map(str.isdecimal, numbers)) else []
    if not seeds or not all(1 <= seed <= _MOST_SEED for seed in seeds):
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: a range such as 1-3 or a list such as 1,4, of seeds from 1 to {_MOST_SEED}")
    return sorted(set(seeds))
