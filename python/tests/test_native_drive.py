"""Tests of the whole drive that Rust and Python both make (tests/simulation/episode.rs), to the bit, and of errors in wrong states."""

import pathlib

import numpy as np
import pytest
from test_episode import fnv_1a

from codrive_sim._codrive import HAS_DESKTOP, Drive, DriveConfiguration

EXPECTED = pathlib.Path(__file__).with_name("drive.txt")
AGENTS, HOLDS = 3, 10
SETTINGS = {"traffic": "native", "advised": "3", "action": "speed", "hold_s": 2.0, "horizon_s": 20.0, "warm_up_s": 30.0}


def begun(driver="follow", seed=7, **settings):
    drive = Drive(DriveConfiguration("ring-250", driver, {**SETTINGS, **settings}))
    drive.begin(seed)
    return drive


def test_a_drive_in_python_is_that_of_rust():
    drive = begun("late")
    text = "hold, reward of the first and of the last agent, FNV-1a of the observations (f32); hash of all states so far\n"
    for hold in range(HOLDS):
        # Same actions as in the Rust test, in float32.
        actions = ((np.arange(AGENTS) * 7 + hold * 3) % 11).astype(np.float32) / np.float32(5.0) - np.float32(1.0)
        rewards, _, last, is_truncated, *_ = drive.hold(actions)
        seen = fnv_1a(last.tobytes())
        text += f"{hold} {float(rewards[0])!r} {float(rewards[2])!r} {seen:016x} {drive.fingerprint()}\n"
    assert is_truncated and drive.agents() == []
    assert text == EXPECTED.read_text(encoding="utf-8")


def test_what_is_asked_before_its_time_is_told_and_changes_nothing():
    drive = Drive(DriveConfiguration("ring-250", None, SETTINGS))
    for ask in (drive.agents, drive.observations, drive.fingerprint, lambda: drive.hold(np.zeros(3, np.float32))):
        with pytest.raises(RuntimeError, match="no drive has begun: reset first"):
            ask()
    drive.begin(7)
    before = drive.fingerprint()
    with pytest.raises(ValueError, match="2 actions; allowed: 3"):
        drive.hold(np.zeros(2, np.float32))
    with pytest.raises(ValueError, match="the action of vehicle_7 is NaN"):
        drive.hold(np.array([0.0, np.nan, 0.0], np.float32))
    assert drive.fingerprint() == before
    with pytest.raises(ValueError, match="seed is 9007199254740992; allowed"):
        drive.begin(2**53)
    drive.close()
    with pytest.raises(RuntimeError, match="no drive has begun"):
        drive.agents()


def test_a_picture_is_drawn_or_the_message_says_how_to_build_what_draws():
    drive = begun()
    if not HAS_DESKTOP:
        with pytest.raises(RuntimeError, match="--features desktop"):
            drive.render(64, 48, "chase")
        return
    above = drive.render(96, 64, "birdseye")
    assert above.shape == (64, 96, 3) and above.dtype == np.uint8 and above.std() > 5
    assert np.array_equal(above, drive.render(96, 64, "birdseye"))
    drive.hold(np.ones(3, np.float32))
    assert not np.array_equal(above, drive.render(96, 64, "birdseye"))
    with pytest.raises(ValueError, match="view is 'above'; allowed: driver, mirror, birdseye, chase"):
        drive.render(96, 64, "above")
    with pytest.raises(ValueError, match="a side of the picture is 0 pixels"):
        drive.render(0, 64, "chase")
