"""Tests of runs on a Ray cluster of two nodes: the same results as without one, to the byte; a killed node loses nothing."""

import os
import pathlib
import re
import subprocess
import sys
import threading
import time

import fsspec
import pyarrow.parquet
import pytest
import ray
from fsspec.implementations.memory import MemoryFile, MemoryFileSystem
from ray.cluster_utils import Cluster

import codrive_sim.sweep
from codrive_sim._run_process import RunProcess
from codrive_sim._run_store import Checkpoint

PLAN = """
[[rings]]
rings = 16
[rings.settings]
horizon_s = HORIZON
warm_up_s = 5
[rings.each]
policy = ["calm.toml", "pi"]
seed = "1-4"

[[drives]]
[drives.settings]
traffic = "native"
duration_s = 2
trees = 0
[drives.each]
seed = "1-2"
"""
#: Module whose process makes the runs of a plan.
WORKER = "codrive_sim._sweep_worker"
CALM = 'format = "codrive controller 1"\nkind = "constant"\nspeed_mps = 4.0\n'


def plan(folder: pathlib.Path, horizon_s: int = 20) -> pathlib.Path:
    """Writes a plan of ten runs with a file beside it."""
    (folder / "calm.toml").write_text(CALM)
    path = folder / "plan.toml"
    path.write_text(PLAN.replace("HORIZON", str(horizon_s)))
    return path


@pytest.fixture
def head_cores() -> int:
    """Returns the number of cores of the first node."""
    return 1


@pytest.fixture
def cluster(head_cores):
    """Starts two nodes, the second one with one core, as processes of this machine."""
    made = Cluster(initialize_head=True, head_node_args={"num_cpus": head_cores, "object_store_memory": 80 << 20})
    made.second = made.add_node(num_cpus=1, object_store_memory=80 << 20)
    ray.init(address=made.address, log_to_driver=False, logging_level="error")
    yield made
    ray.shutdown()
    made.shutdown()


def tables(out: pathlib.Path) -> dict[str, bytes]:
    """Returns each table by its name."""
    return {path.name: path.read_bytes() for path in out.glob("*.parquet")}


def test_two_nodes_come_to_the_table_of_the_program_to_the_byte(tmp_path, cluster):
    path = plan(tmp_path)
    program = os.environ["CODRIVE_PROGRAM"]
    subprocess.run([program, "sweep", path, "--out", tmp_path / "local"], check=True, capture_output=True)
    out = tmp_path / "ray"
    assert codrive_sim.sweep.sweep(str(path), str(out)) == {}
    assert [table[1:] for table in codrive_sim.sweep.collect(str(path), str(out))] == [(2, 2), (8, 128)]
    assert tables(out) == tables(tmp_path / "local")
    parts = {part.name: part.stat().st_mtime_ns for part in (out / "parts").iterdir()}
    assert len(parts) == 10

    # A second start makes only the missing parts.
    lost = sorted(parts)[3]
    (out / "parts" / lost).unlink()
    assert codrive_sim.sweep.sweep(str(path), str(out)) == {}
    again = {part.name: part.stat().st_mtime_ns for part in (out / "parts").iterdir()}
    assert {name for name in parts if again[name] != parts[name]} == {lost}


def test_a_node_that_is_killed_loses_nothing_and_costs_no_wrong_row(tmp_path, cluster):
    path = plan(tmp_path, horizon_s=20_000)
    out = tmp_path / "ray"
    runner = subprocess.Popen(
        [sys.executable, "-m", "codrive_sim.sweep", path, "--out", out, "--address", cluster.address],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    while not list(out.glob("parts/[!.]*")):
        assert runner.poll() is None, runner.communicate()
        time.sleep(0.05)
    cluster.remove_node(cluster.second, allow_graceful=False)
    said, errors = runner.communicate(timeout=300)
    assert runner.returncode == 0, errors
    assert "rings.parquet: 8 runs, 128 rows" in said
    rows = pyarrow.parquet.read_table(out / "rings.parquet").to_pandas()
    assert len(rows) == 128 and not rows.duplicated(["run", "ring"]).any()
    # The same run made here, without a cluster.
    runs = codrive_sim.sweep.Plan(str(path))
    assert runs.execute(0) == (out / "parts" / runs.part_names()[0]).read_bytes()


def begin(*command) -> subprocess.Popen:
    """Starts a command of Python's modules."""
    return subprocess.Popen([sys.executable, "-m", *command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def replace_the_node_after_a_checkpoint(cluster, runner: subprocess.Popen, out: pathlib.Path) -> str:
    """Kills the only node that makes runs once a run has a checkpoint, and starts another. Returns what the command says on standard error."""
    while not list(out.glob("checkpoints/[!.]*")):
        assert runner.poll() is None, runner.communicate()
        time.sleep(0.02)
    cluster.remove_node(cluster.second, allow_graceful=False)
    cluster.add_node(num_cpus=1, object_store_memory=80 << 20)
    _, errors = runner.communicate(timeout=300)
    assert runner.returncode == 0, errors
    assert list(out.glob("checkpoints/*")) == []
    return errors


#: Plan of two trainings; 100 updates take about a second.
TRAININGS = """
[[trainings]]
[trainings.settings]
iterations = UPDATES
judge_every = UPDATES
batch = 600
rings = 16
horizon_s = 10
warm_up_s = 5
[trainings.each]
seed = "1-2"
"""


# With one core in all, one training runs at a time: the node that is killed has the run with the checkpoint.
@pytest.mark.parametrize("head_cores", [0])
def test_a_training_goes_on_from_its_checkpoint_when_its_node_is_killed(tmp_path, cluster):
    path, out = tmp_path / "plan.toml", tmp_path / "ray"
    path.write_text(TRAININGS.replace("UPDATES", "600"))
    runner = begin("codrive_sim.sweep", path, "--out", out, "--address", cluster.address)
    errors = replace_the_node_after_a_checkpoint(cluster, runner, out)
    # The first checkpoint follows the first update, the next one a minute later.
    continued = re.search(r"run ([01]), trainings 1: seed [12]: continues from its checkpoint after update \d+ of 600", errors)
    assert continued, errors
    runs, number = codrive_sim.sweep.Plan(str(path)), int(continued[1])
    assert runs.execute(number) == (out / "parts" / runs.part_names()[number]).read_bytes()


@pytest.mark.parametrize("head_cores", [0])
def test_a_training_of_a_benchmark_goes_on_when_its_node_is_killed(tmp_path, cluster):
    train = ["codrive_sim.benchmarks", "train", "Flow-Merge-v0", "--seeds", "1-2", "--episodes", "80", "--actions", "20", "--out"]
    out, alone = tmp_path / "ray", tmp_path / "alone"
    runner = begin(*train, out, "--on", "ray", "--address", cluster.address)
    errors = replace_the_node_after_a_checkpoint(cluster, runner, out)
    continued = re.search(r"Flow-Merge-v0, seed [12]: continues from its checkpoint after generation (\d) of 8", errors)
    assert continued and 1 <= int(continued[1]) <= 8, errors
    reference = begin(*train, alone, "--workers", "1")
    said, errors = reference.communicate(timeout=300)
    assert reference.returncode == 0 and errors == "" and "Flow-Merge-v0.2.json: 80 episodes" in said, errors
    names = {path.relative_to(alone) for path in alone.rglob("*") if path.is_file()}
    assert {str(name) for name in names} > {"Flow-Merge-v0.1.json", "Flow-Merge-v0.2.json", "curves.csv"} and len(names) == 5
    assert all((out / name).read_bytes() == (alone / name).read_bytes() for name in names)


def test_what_fails_is_told_with_its_reason_and_the_others_are_kept(tmp_path, cluster, monkeypatch):
    path = plan(tmp_path)
    out = tmp_path / "ray"
    names = codrive_sim.sweep.Plan(str(path)).part_names()
    # A folder has the name of a part.
    (out / "parts" / names[2]).mkdir(parents=True)
    (out / "parts" / names[2] / "x").write_text("")
    files = lambda self: {part.name for part in (out / "parts").iterdir() if part.is_file()}  # noqa: E731
    monkeypatch.setattr(codrive_sim.sweep.Store, "names", files)
    failed = codrive_sim.sweep.sweep(str(path), str(out))
    assert list(failed) == [2] and names[2] in failed[2], failed
    assert sum(part.is_file() for part in (out / "parts").iterdir()) == 9


#: Plan with a drive of a second, and one that would take most of an hour.
HANGING = """
[[drives]]
limit_s = 5
[drives.settings]
traffic = "native"
trees = 0
[drives.each]
duration_s = [604800, 1]
"""


def test_a_run_that_hangs_is_ended_at_its_limit_tried_again_and_told(tmp_path, cluster):
    path = tmp_path / "plan.toml"
    path.write_text(HANGING)
    start = time.monotonic()
    failed = codrive_sim.sweep.sweep(str(path), str(tmp_path / "out"))
    assert failed == {0: "the run was not done after limit_s, 5 s"}
    # The first attempt and one retry.
    assert time.monotonic() - start >= 10.0
    runs = codrive_sim.sweep.Plan(str(path))
    assert [part.name for part in (tmp_path / "out" / "parts").iterdir()] == [runs.part_names()[1]]


def test_a_run_that_takes_its_process_along_costs_itself_alone(tmp_path):
    path = tmp_path / "plan.toml"
    path.write_text(HANGING)
    names = codrive_sim.sweep.Plan(str(path)).part_names()
    codrive_sim.sweep.Store(str(tmp_path / "out")).names()
    worker = RunProcess(WORKER, str(path), str(tmp_path / "out"))
    with pytest.raises(RuntimeError, match=r"run 1 is .* on the machine that started the sweep\n  remedy: install the same version"):
        worker.run(f"1 {names[0]}")
    assert worker.run(f"1 {names[1]}") == []
    threading.Timer(0.5, worker._process.kill).start()
    with pytest.raises(RuntimeError, match=r"the process of the run ended \(exit status -9\)"):
        worker.run(f"0 {names[0]}")
    assert not worker.is_alive
    path.write_text("[[drives]]\nlimit_s = 0\n")
    with pytest.raises(RuntimeError, match="limit_s is 0; allowed"):
        RunProcess(WORKER, str(path), str(tmp_path / "out"))


def test_nothing_goes_on_after_whoever_started_it(tmp_path):
    path = tmp_path / "plan.toml"
    path.write_text(HANGING)
    name = codrive_sim.sweep.Plan(str(path)).part_names()[0]
    text = (
        "import sys; from codrive_sim._run_process import RunProcess\n"
        "worker = RunProcess(*sys.argv[1:4])\n"
        "print(worker._process.pid, flush=True)\n"
        "worker.run(f'0 {sys.argv[4]}')\n"
    )
    command = [sys.executable, "-c", text, WORKER, path, tmp_path / "out", name]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as starter:
        child = int(starter.stdout.readline())
        # The run is in progress: it has used processor time.
        before = cpu_ticks(child)
        while cpu_ticks(child) < before + 20:
            time.sleep(0.02)
        starter.kill()
    deadline = time.monotonic() + 30.0
    while is_running(child):
        assert time.monotonic() < deadline, "the run goes on without anybody who waits for it"
        time.sleep(0.02)


def stat(process: int) -> list[str]:
    """Returns the fields of /proc/PID/stat after the name of a process, the state first (proc(5))."""
    return pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()


def cpu_ticks(process: int) -> int:
    """Returns the processor time that a process has used."""
    return int(stat(process)[11])


def is_running(process: int) -> bool:
    """Returns True if a process runs and is not a zombie."""
    try:
        return stat(process)[0] != "Z"
    except OSError:
        return False


class ObjectStore(MemoryFileSystem):
    """File system like S3 by s3fs: a folder exists only once it has contents."""

    protocol = "objects"
    store, pseudo_dirs = {}, [""]  # noqa: RUF012

    @classmethod
    def _strip_protocol(cls, path):
        return super()._strip_protocol(path.removeprefix("objects://"))

    def makedirs(self, path, exist_ok=False):
        """Does nothing."""

    def pipe_file(self, path, value, mode="overwrite", **kwargs):
        """Writes an object completely."""
        self.store[path] = MemoryFile(self, path, value)


def test_parts_and_tables_in_an_object_store_are_those_of_a_folder(tmp_path):
    fsspec.register_implementation("objects", ObjectStore, clobber=True)
    path = plan(tmp_path)
    runs, out = codrive_sim.sweep.Plan(str(path)), "objects://study/holds"
    store, folder = codrive_sim.sweep.Store(out), codrive_sim.sweep.Store(str(tmp_path / "folder"))
    assert store.folder is None and store.names() == set() == folder.names()
    for number, name in enumerate(runs.part_names()):
        part = runs.execute(number)
        store.put(name, part)
        folder.put(name, part)
    assert store.names() == set(runs.part_names()) == folder.names()
    told = codrive_sim.sweep.collect(str(path), out)
    assert not fsspec.filesystem("objects").exists("/study/holds/checkpoints")
    assert [table[0] for table in told] == [f"{out}/drives.parquet", f"{out}/rings.parquet"]
    codrive_sim.sweep.collect(str(path), str(tmp_path / "folder"))
    tables_there = {name: fsspec.filesystem("objects").cat_file(f"/study/holds/{name}") for name in ("drives.parquet", "rings.parquet")}
    assert tables_there == tables(tmp_path / "folder")


@pytest.mark.parametrize("address", ["objects://study/checkpoints", "FOLDER"])
def test_a_checkpoint_is_used_or_ignored_aloud_wherever_it_is(tmp_path, address):
    fsspec.register_implementation("objects", ObjectStore, clobber=True)
    path, store = tmp_path / "plan.toml", codrive_sim.sweep.Store(address.replace("FOLDER", str(tmp_path / "out")))
    path.write_text(TRAININGS.replace("UPDATES", "3"))
    runs, reports = codrive_sim.sweep.Plan(str(path)), []
    name, part = runs.part_names()[0], runs.execute(0)
    checkpoint = Checkpoint(store, name, reports.append)
    assert runs.execute(0, checkpoint) == part and reports == []
    assert runs.execute(0, checkpoint) == part and checkpoint.load() is not None
    checkpoint.save(checkpoint.load()[:-1])
    assert runs.execute(0, checkpoint) == part
    assert reports == [
        "run 0, trainings 1: seed 1: continues from its checkpoint after update 1 of 3",
        "run 0, trainings 1: seed 1: warning: the checkpoint is ignored and the training starts anew: damaged",
    ]
    store.put(name, part)
    assert checkpoint.load() is None and store.read(f"parts/{name}") == part
    assert [table[1:] for table in codrive_sim.sweep.collect(str(path), store.out)] == [(1, 3)]
    assert b'action = "' in store.read(f"policies/{name.removeprefix('trainings-').removesuffix('.parquet')}.toml")


def test_a_wrong_plan_is_refused_before_anything_is_begun(tmp_path, capsys):
    path = tmp_path / "plan.toml"
    path.write_text("[[drives]]\n[drives.each]\nhold = [1]\n")
    assert codrive_sim.sweep.main([str(path), "--out", str(tmp_path / "out")]) == 2
    assert f"{path}:3:1: unknown key `hold`; did you mean `hold_s`?" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    with pytest.raises(IndexError, match="allowed: 0 to 9"):
        codrive_sim.sweep.Plan(str(plan(tmp_path))).execute(10)
