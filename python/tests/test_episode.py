"""Test of the episode that Rust and Python both drive (tests/simulation/python_episode.rs), to the bit."""

import pathlib
import subprocess
import sys

import numpy as np
import pytest

import codrive_sim

EXPECTED = pathlib.Path(__file__).with_name("episode.txt")
RINGS, HOLDS = 20, 8


def fnv_1a(data: bytes) -> int:
    """Returns the FNV-1a hash, 64 bits (Fowler, Noll, Vo)."""
    value = 0xCBF29CE484222325
    for byte in data:
        value = ((value ^ byte) * 0x100000001B3) % 2**64
    return value


def driven(copy: bool = True) -> str:
    envs = codrive_sim.make_vec(
        "ring-250", RINGS, hold=1.0, advice="speed", driver="late", warm_up_s=10.0, horizon_s=3.0, copy=copy
    )
    envs.reset(seed=7)
    text = "hold, reward of ring 0 and of ring 19, FNV-1a of all rewards (f64) and of all observations (f32)\n"
    for hold in range(HOLDS):
        # Same actions as in the Rust test, in float32.
        drawn = ((np.arange(RINGS) * 7 + hold * 3) % 11).astype(np.float32) / np.float32(5.0) - np.float32(1.0)
        seen, rewards, _, _, _ = envs.step(drawn[:, None])
        hashes = f"{fnv_1a(rewards.tobytes()):016x} {fnv_1a(seen.tobytes()):016x}"
        text += f"{hold} {float(rewards[0])!r} {float(rewards[19])!r} {hashes}\n"
    return text


@pytest.mark.parametrize("copy", [True, False])
def test_an_episode_in_python_is_that_of_rust(copy):
    assert driven(copy) == EXPECTED.read_text(encoding="utf-8")


@pytest.mark.parametrize("threads", ["1", "3"])
def test_the_number_of_threads_changes_no_bit(threads):
    program = "import sys, test_episode; sys.stdout.write(test_episode.driven())"
    environment = {"RAYON_NUM_THREADS": threads, "PYTHONPATH": ":".join([str(EXPECTED.parent), *sys.path])}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout == EXPECTED.read_text(encoding="utf-8")
