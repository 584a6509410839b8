"""Tests of evaluations: the same numbers as the program, and policies of all kinds."""

import json
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import time

import numpy as np
import pandas
import polars
import pytest

import codrive_sim

SHORT = {"warm_up_s": 20.0, "horizon_s": 30.0}
ROOT = pathlib.Path(__file__).parents[2]
PROGRAM = pathlib.Path(os.environ.get("CODRIVE_PROGRAM", ROOT / "target/debug/codrive"))


def of_the_program(*arguments):
    """Returns the results of ``codrive evaluate --json`` on rings of ``SHORT``."""
    assert PROGRAM.is_file(), f"{PROGRAM} is not there: cargo build, or CODRIVE_PROGRAM says where it is"
    command = [PROGRAM, "evaluate", "--json", "--warm-up", "20", "--horizon", "30", *arguments]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT).stdout)


def same(row, result):
    """Returns True if a row has the numbers of a ring to the bit."""
    for key, value in result.items():
        own = row[key]
        assert (value is None and pandas.isna(own)) or own == value, f"{key}: {own} is not {value}"
    return True


def test_named_policies_have_the_numbers_of_the_program_to_the_bit():
    names = ["follower-stopper", "none", "ring-250-speed"]
    asked = [word for name in names for word in ("--policy", name)]
    told = of_the_program(*asked, "--holds", "1,5", "--driver", "sloppy", "--over", "18", "--seed", "4")
    own = codrive_sim.evaluate(names, over=18, hold=[1.0, 5.0], driver="sloppy", seed=4, **SHORT)
    assert len(own) == 3 * 2 * 18 and len(told["rows"]) == 6
    for row in told["rows"]:
        rings = own[(own.policy == row["policy"]) & (own.hold_s == row["hold_s"])]
        assert list(rings.ring) == list(range(18))
        assert all(same(ring, result) for (_, ring), result in zip(rings.iterrows(), row["rings"], strict=True))
    # The numbers differ, so the policies and drivers had an effect.
    assert own.groupby(["policy", "hold_s"]).mean_speed_mps.mean().nunique() >= 5


def test_files_and_auto_have_the_numbers_of_the_program_to_the_bit():
    for file in ("assets/policies/ring-250-speed/policy.onnx", "assets/policies/ring-250-personal/policy.toml"):
        told = of_the_program("--policy", file, "--over", "2", "--driver", "people", "--holds", "5")["rows"][0]
        own = codrive_sim.evaluate(ROOT / file, over=2, driver="people", hold=5.0, **SHORT)
        assert all(same(ring, result) for (_, ring), result in zip(own.iterrows(), told["rings"], strict=True))
    own = codrive_sim.evaluate("auto", "ring-641", over=2, hold=5.0, **SHORT)
    assert set(own.policy) == {"ring-641-speed"}


def test_a_callable_drives_as_the_policy_that_it_is():
    # 4.3 m/s on a scale of 0 to 10 is an action of -0.14. The program's constant policy aims at 4.3.
    constant = codrive_sim.evaluate("constant", over=18, policy_speed=4.3, hold=2.0, **SHORT)

    def answer(seen):
        assert seen.shape == (18, 4) and seen.dtype == np.float32
        return np.full((18, 1), 2 * 4.3 / 10.0 - 1.0)

    own = codrive_sim.evaluate(answer, over=18, hold=2.0, advice="speed", **SHORT)
    assert set(own.policy) == {"answer"}
    # The action is float32, so 4.3 is accurate to 3e-7.
    assert own.mean_speed_mps.to_numpy() == pytest.approx(constant.mean_speed_mps.to_numpy(), abs=1e-5)
    assert own.min_gap_to_neighbours_m.to_numpy() == pytest.approx(constant.min_gap_to_neighbours_m.to_numpy(), abs=1e-4)


def test_something_with_predict_is_asked_without_noise():
    class Model:
        def predict(self, observation, deterministic=False):
            assert deterministic
            return np.zeros((len(observation), 1), np.float32), None

    own = codrive_sim.evaluate(Model(), over=3, advice="speed", **SHORT)
    # The middle of 0 to 10 m/s.
    middle = codrive_sim.evaluate("constant", over=3, policy_speed=5.0, **SHORT)
    assert set(own.policy) == {"Model"}
    assert list(own.mean_speed_mps) == list(middle.mean_speed_mps)


def test_a_model_with_memory_is_asked_with_its_state():
    class Counting:
        """Advises 1, 2, 3, ... m/s, the number of holds that it remembers."""

        def predict(self, observation, state=None, episode_start=None, deterministic=False):
            state = np.zeros(len(observation)) if state is None else state
            assert deterministic and (episode_start is None or not episode_start.any())
            return (2.0 * (state[:, None] + 1.0) / 10.0 - 1.0).astype(np.float32), state + 1.0

    model = Counting()
    first = codrive_sim.evaluate(model, over=2, advice="speed", hold=5.0, **SHORT)
    holds = iter(range(1, 7))
    wanted = codrive_sim.evaluate(
        lambda seen: np.full((2, 1), 2.0 * next(holds) / 10.0 - 1.0, np.float32), over=2, advice="speed", hold=5.0, **SHORT
    )
    assert list(first.mean_speed_mps) == list(wanted.mean_speed_mps) and next(holds, None) is None
    # Another evaluation begins without memory.
    again = codrive_sim.evaluate(model, over=2, advice="speed", hold=5.0, **SHORT)
    assert list(again.mean_speed_mps) == list(first.mean_speed_mps)


def test_a_model_brings_the_meaning_of_its_numbers():
    class Model:
        def __init__(self, env):
            # Libraries store the space in a model's file.
            self.action_space = pickle.loads(pickle.dumps(env.action_space))

        def predict(self, observation, deterministic=False):
            assert observation.shape == (2, 2)
            return np.zeros((len(observation), 1), np.float32), None

    model = Model(codrive_sim.make(advice="speed", hold=3.0, sees="speed,gap", top_speed_mps=8.0))
    own = codrive_sim.evaluate(model, over=2, **SHORT)
    # The middle of 0 to 8 m/s, held 3 s.
    middle = codrive_sim.evaluate("constant", over=2, policy_speed=4.0, hold=3.0, **SHORT)
    assert set(own.hold_s) == {3.0} and list(own.mean_speed_mps) == list(middle.mean_speed_mps)
    assert set(codrive_sim.evaluate(model, over=2, hold=5.0, **SHORT).hold_s) == {5.0}
    said = "advice is 'acceleration', and Model was trained with 'speed'; leave it out"
    with pytest.raises(ValueError, match=said):
        codrive_sim.evaluate(model, over=2, advice="acceleration", **SHORT)
    with pytest.raises(ValueError, match="top_speed_mps is 10.0, and Model was trained with 8.0"):
        codrive_sim.evaluate(model, over=2, top_speed_mps=10.0, **SHORT)


def test_the_table_is_of_pandas_or_of_polars():
    own = codrive_sim.evaluate("none", over=2, **SHORT)
    assert isinstance(own, pandas.DataFrame)
    other = codrive_sim.evaluate("none", over=2, as_="polars", **SHORT)
    assert isinstance(other, polars.DataFrame)
    assert other["mean_speed_mps"].to_list() == list(own.mean_speed_mps)


def test_without_a_name_all_built_in_policies_drive():
    own = codrive_sim.evaluate(over=1, **SHORT)
    assert list(own.policy) == ["none", "constant", "two-phase", "follower-stopper", "pi", "linear-feedback"]
    assert set(own.policy) < set(codrive_sim.policies()) and "ring-641-acceleration" in codrive_sim.policies()


def test_a_hold_that_a_policy_was_not_trained_for_is_warned_of():
    with pytest.warns(UserWarning, match="trained for holds of"):
        codrive_sim.evaluate("ring-641-speed", "ring-641", over=1, hold=1.0, **SHORT)


def test_progress_is_said_where_it_is_asked_for(capfd):
    codrive_sim.evaluate("none", over=1, progress=True, **SHORT)
    assert "1 of 1 rings" in capfd.readouterr().err
    codrive_sim.evaluate("none", over=1, progress=False, **SHORT)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(
    ("policy", "horizon_s"), [("'follower-stopper'", 800.0), ("lambda seen: seen[:, :1] * 0", 36_000.0)], ids=["by name", "by a callable"]
)
def test_ctrl_c_ends_an_evaluation(policy, horizon_s):
    # The evaluation would take hours; it is stopped once it has begun.
    program = (
        "import codrive_sim, signal\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "print('begun', flush=True)\n"
        f"codrive_sim.evaluate({policy}, over=100_000 if isinstance({policy}, str) else 64, horizon_s={horizon_s}, warm_up_s=0.0)\n"
    )
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as done:
        assert done.stdout.readline() == "begun\n"
        time.sleep(1.0)
        assert done.poll() is None, done.stderr.read()
        done.send_signal(signal.SIGINT)
        start = time.monotonic()
        try:
            _, said = done.communicate(timeout=120)
        finally:
            done.kill()
    # A second is promised; ten times as much are for a machine with other things to do.
    assert said.rstrip().endswith("KeyboardInterrupt") and time.monotonic() - start < 10.0
