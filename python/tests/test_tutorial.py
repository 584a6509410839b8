"""Tests of docs/tutorial.md and docs/tutorials: run everything on each page, in order, in an empty folder."""

import contextlib
import io
import os
import pathlib
import re
import signal
import subprocess
import time

import pytest

ROOT = pathlib.Path(__file__).parents[2]
PROGRAM = pathlib.Path(os.environ.get("CODRIVE_PROGRAM", ROOT / "target/debug/codrive"))
PAGES = sorted((ROOT / "docs/tutorials").glob("*.md"))
BLOCK = re.compile(r"^```(\S+) ?(.*)\n((?:.*\n)*?)```$", re.MULTILINE)


@contextlib.contextmanager
def screen():
    """Starts a screen in memory for windows."""
    reading, writing = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(writing), "-screen", "0", "800x600x24", "-nolisten", "tcp"],
        pass_fds=[writing],
        stderr=subprocess.DEVNULL,
    )
    os.close(writing)
    with os.fdopen(reading) as told:
        number = told.readline().strip()
    try:
        assert number, "Xvfb did not start: scripts/setup --test installs it"
        yield f":{number}"
    finally:
        server.terminate()
        server.wait()


def windows(display):
    """Returns the titles of the visible windows."""
    asked = ["xdotool", "search", "--onlyvisible", "--name", "."]
    found = subprocess.run(asked, capture_output=True, text=True, env={**os.environ, "DISPLAY": display}).stdout.split()
    name = ["xdotool", "getwindowname"]
    return [subprocess.run([*name, one], capture_output=True, text=True, env={**os.environ, "DISPLAY": display}).stdout for one in found]


def driven_in_a_window(command, environment):
    """Opens the window, and ends the program by Ctrl-C once the window is visible."""
    with screen() as display:
        drive = subprocess.Popen(
            ["bash", "-c", f"exec {command}"],
            env={**environment, "DISPLAY": display, "WAYLAND_DISPLAY": ""},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        # The first picture is drawn in software; after five minutes it will not come.
        end = time.monotonic() + 300
        while not windows(display) and drive.poll() is None and time.monotonic() < end:
            time.sleep(0.5)
        seen = windows(display)
        drive.send_signal(signal.SIGINT)
        said = drive.communicate(timeout=120)[0]
        assert seen and drive.returncode in (0, 130), f"{command}: windows {seen}, exit status {drive.returncode}\n{said}"


def shortened(text):
    """Returns commands with trainings of two updates: what they reach is no promise of a page, and minutes."""
    return re.sub(r"--iterations \d+", "--iterations 2", text)


def done(page, tmp_path, monkeypatch):
    """Does all that a page says. Returns the names that its Python has made, and its output."""
    assert PROGRAM.is_file(), f"{PROGRAM} is not there: cargo build, or CODRIVE_PROGRAM says where it is"
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin/codrive").symlink_to(PROGRAM)
    environment = {**os.environ, "PATH": f"{tmp_path / 'bin'}:{os.environ['PATH']}", "CODRIVE_DATA": str(ROOT)}
    text = page.read_text(encoding="utf-8")
    names, said, blocks = {"__name__": "tutorial"}, io.StringIO(), []
    for kind, word, block in BLOCK.findall(text):
        blocks.append((kind, word))
        if kind == "toml" and word:
            name, _, add = word.partition(" ")
            with open(tmp_path / name, "a" if add == "add" else "w", encoding="utf-8") as file:
                file.write(block)
        elif (kind, word) == ("sh", "window"):
            driven_in_a_window(block.strip(), environment)
        elif (kind, word) == ("sh", ""):
            run = subprocess.run(["bash", "-euc", shortened(block)], env=environment, capture_output=True, text=True)
            assert run.returncode == 0, f"{block}{run.stdout}{run.stderr}"
        elif (kind, word) == ("python", ""):
            with contextlib.redirect_stdout(said):
                exec(compile(block, f"block {len(blocks)} of {page.name}", "exec"), names)
        else:
            assert word == "no-test", f"{page.name}: a block {kind} {word} is of no kind that this test knows"
    # Only parts that are marked so were skipped.
    assert text.count("\n```") == 2 * len(blocks) and blocks.count(("sh", "no-test")) <= 1
    return names, said.getvalue()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_all_that_is_on_a_page_can_be_done(page, tmp_path, monkeypatch):
    done(page, tmp_path, monkeypatch)


def test_the_python_tutorial_trains_a_policy_that_helps(tmp_path, monkeypatch):
    names, said = done(ROOT / "docs/tutorial.md", tmp_path, monkeypatch)
    # The page promises a policy that is faster than no advice on unseen rings.
    speeds = names["table"].groupby("policy").mean_speed_mps.mean()
    assert speeds["my-policy.toml"] > speeds["none"] + 0.3, said
    # The study was rehearsed and analysed with that policy.
    assert (tmp_path / "data/derivatives/codrive/report.html").stat().st_size > 10_000
    measured = names["data"].measures()
    assert set(measured.condition) == {"none", "mine"} and len(measured) == 8
    driven = measured.groupby("condition").mean_speed_mps.mean()
    assert driven["mine"] > driven["none"] + 0.2, driven
