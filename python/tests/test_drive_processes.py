"""Tests of drives in processes of their own: events that end them, and the messages. No process is left behind."""

import contextlib
import gc
import multiprocessing
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time
import warnings

import gymnasium
import numpy as np
import pytest

import codrive_sim
from codrive_sim import _settings
from codrive_sim._workers import _GRACE_S, WorkerDrive

SHORT = {"warm_up_s": 1.0, "horizon_s": 5.0}
STILL = np.zeros(1)


def children(of=None):
    """Returns the child processes of this one, including zombies."""
    of = os.getpid() if of is None else of
    found = []
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            number, rest = stat.read_text().split(" ", 1)
        except OSError:
            continue
        if int(rest.rsplit(")", 1)[1].split()[1]) == of:
            found.append(int(number))
    return set(found)


@pytest.fixture(autouse=True)
def nobody_is_left():
    gc.collect()
    before = children()
    yield
    gc.collect()
    assert children() <= before


def begun(**arguments):
    """Returns an environment in a process, and the process."""
    before = children()
    env = codrive_sim.make("ring-250", traffic="sumo", **{**SHORT, **arguments})
    env.reset(seed=1)
    (process,) = children() - before
    return env, process


def test_its_end_ends_the_process():
    env, process = begun()
    env.close()
    assert process not in children()
    env, process = begun()
    del env
    gc.collect()
    assert process not in children()
    envs = codrive_sim.make_vec("ring-250", 3, traffic="native", **SHORT)
    before = children()
    envs.reset(seed=1)
    assert len(children() - before) == 3
    envs.close()
    assert children() == before


def variable_of(process, name):
    """Returns an environment variable of a process, if it was started with it."""
    variables = pathlib.Path(f"/proc/{process}/environ").read_bytes().split(b"\0")
    found = [each.split(b"=", 1)[1] for each in variables if each.startswith(f"{name}=".encode())]
    return os.fsdecode(found[0]) if found else None


def test_libraries_of_graphics_find_a_private_folder_for_their_sockets(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    env, process = begun()
    assert variable_of(process, "XDG_RUNTIME_DIR") == str(tmp_path)
    env.close()
    monkeypatch.delenv("XDG_RUNTIME_DIR")
    env, process = begun()
    folder = pathlib.Path(variable_of(process, "XDG_RUNTIME_DIR"))
    assert folder.is_dir() and folder.stat().st_mode & 0o777 == 0o700 and folder.stat().st_uid == os.getuid()
    env.close()


def test_that_folder_goes_with_the_python_that_made_it():
    program = "from codrive_sim._runtime_folder import runtime_variables as v; print(v()['XDG_RUNTIME_DIR'], v() == v())"
    variables = {name: value for name, value in os.environ.items() if name != "XDG_RUNTIME_DIR"}
    done = subprocess.run([sys.executable, "-c", program], env=variables, capture_output=True, text=True, check=True)
    folder, is_one = done.stdout.split()
    assert is_one == "True" and not pathlib.Path(folder).exists()


def test_the_end_of_python_ends_the_process():
    program = """if True:
        import codrive_sim
        env = codrive_sim.make("ring-250", traffic="sumo", warm_up_s=1.0)
        env.reset(seed=1)
        print(env._series._drive.pid)
    """
    variables = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, env=variables)
    # Only the output of this process: the output of the worker goes to standard error.
    assert not pathlib.Path(f"/proc/{int(done.stdout)}").exists()


def test_what_is_printed_there_does_not_come_between(tmp_path, monkeypatch, capfd):
    # Prints all the time, starting before the program.
    (tmp_path / "sitecustomize.py").write_text("""if True:
        import os, threading, time
        def talk():
            while True:
                os.write(1, b"Hello from a library")
                time.sleep(0.001)
        threading.Thread(target=talk, daemon=True).start()
    """)
    quiet, _ = begun()
    monkeypatch.syspath_prepend(tmp_path)
    env, _ = begun()
    for _ in range(3):
        assert np.array_equal(env.step(STILL)[0], quiet.step(STILL)[0])
    out, errors = capfd.readouterr()
    assert out == "" and "Hello from a library" in errors


@pytest.mark.parametrize("fatal", [signal.SIGKILL, signal.SIGSEGV])
def test_a_process_that_is_gone_is_said_and_reset_starts_another(fatal):
    env, process = begun()
    expected = env.step(STILL)[0]
    os.kill(process, fatal)
    with pytest.raises(RuntimeError, match=rf"process has ended \({fatal.name}\); reset\(\) starts another"):
        env.step(STILL)
    assert process not in children()
    with pytest.raises(gymnasium.error.ResetNeeded, match="failed.*reset"):
        env.step(STILL)
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.fingerprint()
    env.reset(seed=1)
    assert np.array_equal(env.step(STILL)[0], expected)


def test_one_of_many_that_is_gone_is_named_and_reset_begins_all_anew():
    before = children()
    envs = codrive_sim.make_vec("ring-250", 3, traffic="native", **SHORT)
    first = envs.reset(seed=1)[0]
    processes = sorted(children() - before)
    os.kill(processes[1], signal.SIGKILL)
    with pytest.raises(RuntimeError, match=r"environment 1: the drive's process has ended \(SIGKILL\)"):
        envs.step(np.zeros((3, 1)))
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.step(np.zeros((3, 1)))
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.fingerprints()
    assert np.array_equal(envs.reset(seed=1)[0], first)
    envs.step(np.zeros((3, 1)))


# A warm-up longer than any wait here: it waits for a wave that no ring has.
ENDLESS = {"warm_up_s": 3600.0, "wave_sd_mps": 10.0, "wave_wait_s": 3600.0, "step_s": 0.01, "vehicles": 40}


def interrupt_reset(env, after_s):
    """Presses Ctrl-C during a warm-up, and returns the time until it ended, in seconds."""
    main = threading.main_thread().ident
    # A shell starts what runs in its background without it.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    interrupt = threading.Timer(after_s, lambda: signal.pthread_kill(main, signal.SIGINT))
    interrupt.start()
    begun = time.monotonic()
    try:
        with pytest.raises(KeyboardInterrupt):
            env.reset(seed=1)
            pytest.fail("the warm-up was over before it was stopped")
    finally:
        interrupt.cancel()
    return time.monotonic() - begun - after_s


@pytest.mark.parametrize("many", [False, True])
def test_ctrl_c_stops_a_drive_and_ends_its_process(many):
    before = children()
    long = {"traffic": "sumo", **ENDLESS}
    env = codrive_sim.make_vec("ring-641", 2, **long) if many else codrive_sim.make("ring-641", **long)
    took_s = interrupt_reset(env, 2.0)
    # The process is killed, without a wait for its own end.
    assert children() == before and took_s < _GRACE_S
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(np.zeros((2, 1)) if many else STILL)
    env.close()


def test_ctrl_c_ends_the_warm_up_of_a_drive_in_this_process_within_a_second():
    env = codrive_sim.make("ring-641", traffic="native", **ENDLESS)
    assert interrupt_reset(env, 1.0) < 1.0
    env.close()


def test_the_process_itself_does_not_hear_ctrl_c():
    env, process = begun()
    os.kill(process, signal.SIGINT)
    assert np.isfinite(env.step(STILL)[0]).all()


def test_a_fault_in_the_process_is_raised_here_by_its_own_type():
    # Settings are checked in this process first, so the test bypasses that check.
    drive = WorkerDrive(("no-such-map", None, {}), {}, os.getcwd())
    with pytest.raises(ValueError, match="no-such-map"):
        drive.call("begin", 1)
    drive.close()
    env, _ = begun()
    with pytest.raises(ValueError, match="2 actions"):
        env._series.hold(np.zeros(2, np.float32))


@pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="this system forks no processes")
def test_a_fork_leaves_the_process_to_who_started_it():
    env, process = begun()

    def child(queue):
        try:
            env.step(STILL)
        except RuntimeError as why:
            queue.put(str(why))
        env.reset(seed=1)
        queue.put(env.fingerprint())
        env.close()

    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        forked = context.Process(target=child, args=(queue,))
        forked.start()
    assert "reset() starts another" in queue.get(timeout=60)
    fingerprint = queue.get(timeout=60)
    forked.join(timeout=60)
    forked.close()
    queue.close()
    queue.join_thread()
    assert process in children()
    assert env.step(STILL)[0].dtype == np.float32
    env.reset(seed=1)
    assert env.fingerprint() == fingerprint


def test_paths_are_those_of_the_folder_where_it_was_made(tmp_path, monkeypatch):
    network = pathlib.Path(__file__).parents[2] / "tests/data/networks/ramps.net.xml"
    (tmp_path / "here.net.xml").write_bytes(network.read_bytes())
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path)
    env = codrive_sim.make("here.net.xml", horizon_s=2.0)
    monkeypatch.chdir(tmp_path / "elsewhere")
    env.reset(seed=1)
    env.step(STILL)


def test_without_sumo_it_is_said_what_to_install_and_the_native_engine_drives(tmp_path, monkeypatch):
    monkeypatch.setenv("CODRIVE_SUMO_HOME", str(tmp_path))
    for make in (codrive_sim.make, codrive_sim.make_vec):
        with pytest.raises(gymnasium.error.DependencyNotInstalled, match="pip install eclipse-sumo==1.28.0"):
            make("ring-250", traffic="sumo")
    env = codrive_sim.make("ring-250", traffic="native", **SHORT)
    env.reset(seed=1)
    env.step(STILL)


def test_sumo_of_pip_is_found_where_nothing_else_is_said(tmp_path, monkeypatch):
    package = tmp_path / "sumo"
    (package / "lib64").mkdir(parents=True)
    (package / "__init__.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delenv("CODRIVE_SUMO_HOME", raising=False)
    monkeypatch.setenv("SUMO_HOME", str(tmp_path))
    # A folder without the library, such as a system's SUMO, does not count; a module in a checkout finds that checkout's SUMO.
    with contextlib.suppress(gymnasium.error.DependencyNotInstalled):
        assert "SUMO_HOME" not in _settings.sumo_variables()
    (package / "lib64/libsumocpp.so").write_text("")
    assert _settings.sumo_variables() == {"SUMO_HOME": str(package)}
    monkeypatch.setenv("CODRIVE_SUMO_HOME", str(tmp_path))
    with pytest.raises(gymnasium.error.DependencyNotInstalled):
        _settings.sumo_variables()
