"""Tests of evaluations by whole drives: the same numbers as the program, and policies of Python."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import time
import tomllib

import numpy as np
import pandas
import pytest

import codrive_sim

SHORT = {"warm_up_s": 10.0, "horizon_s": 20.0}
ROOT = pathlib.Path(__file__).parents[2]
PROGRAM = pathlib.Path(os.environ.get("CODRIVE_PROGRAM", ROOT / "target/debug/codrive"))


def of_the_program(*arguments):
    """Returns what ``codrive evaluate`` writes for whole drives of ``SHORT``."""
    command = [PROGRAM, "evaluate", "--warm-up", "10", "--horizon", "20", *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT).stdout


def assert_same(rows, results):
    """Checks that the rows of a table have the numbers of the program's results to the bit."""
    for (_, row), result in zip(rows.iterrows(), results, strict=True):
        for key, value in {**result, **result.get("network", {})}.items():
            if key != "network":
                assert (value is None and pandas.isna(row[key])) or row[key] == value, f"{key}: {row[key]} is not {value}"


def advised_rows(text, share):
    """Returns the program's row with this share of advised vehicles, whose drivers follow the advice."""
    (row,) = [row for row in json.loads(text)["rows"] if row["advised_share"] == share and not row["ignores_advice"]]
    return row


def test_named_policies_on_a_ring_have_the_numbers_of_the_program():
    asked = ("--traffic", "native", "--over", "3", "--seed", "4", "--driver", "sloppy", "--holds", "2")
    told = json.loads(of_the_program("--json", *asked, "--policy", "pi", "--policy", "ring-250-speed", "--policy", "none"))
    settings = {"traffic": "native", "over": 3, "seed": 4, "driver": "sloppy", "hold": 2.0, **SHORT}
    own = codrive_sim.evaluate(["pi", "ring-250-speed", "none"], **settings)
    assert [row["policy"] for row in told["rows"]] == ["pi", "ring-250-speed", "none"]
    for row in told["rows"]:
        rows = own[own.policy == row["policy"]]
        assert_same(rows, row["rings"])
        assert set(rows.advised_vehicles) == {row["advised_vehicles"]} and set(rows.advised_share) == {row["advised_share"]}
    assert own.mean_speed_mps.nunique() == 9
    four = codrive_sim.evaluate("pi", advised=4, **settings)
    told = advised_rows(of_the_program("--json", *asked, "--policy", "pi", "--advised", "4"), 4 / 22)
    assert_same(four, told["rings"])
    assert set(four.advised_vehicles) == {4} and list(four.mean_speed_mps) != list(own[own.policy == "pi"].mean_speed_mps)


def test_without_advised_vehicles_the_traffic_drives_alone():
    told = advised_rows(of_the_program("--json", "--traffic", "native", "--over", "2", "--policy", "pi", "--advised", "4"), 0.0)
    own = codrive_sim.evaluate("pi", traffic="native", advised=0, over=2, **SHORT)
    assert_same(own, told["rings"])
    assert set(own.advised_vehicles) == {0} and set(own.policy) == {"pi"}


def test_a_share_on_a_network_in_sumo_has_the_numbers_of_the_program():
    asked = ("--map", "merge", "--traffic", "sumo", "--policy", "constant", "--policy-speed", "8", "--advised", "50%", "--over", "2")
    told = advised_rows(of_the_program("--json", *asked), 0.5)
    own = codrive_sim.evaluate("constant", "merge", advised="50%", policy_speed=8.0, over=2, **SHORT)
    assert_same(own, told["rings"])
    assert list(own.vehicles) == [ring["network"]["vehicles"] for ring in told["rings"]] and (own.advised_vehicles > 0).all()
    assert set(own.traffic) == {"sumo"} and set(own.advised_share) == {0.5}


@pytest.mark.parametrize("traffic", ["ring", "native"])
def test_the_columns_are_those_of_the_program(tmp_path, traffic):
    of_the_program("--traffic", traffic, "--policy", "none", "--over", "2", "--out", str(tmp_path / "out"))
    written = pandas.read_csv(tmp_path / "out" / "rings.csv")
    own = codrive_sim.evaluate("none", traffic=traffic, over=2, **SHORT)
    assert list(own.columns) == list(written.columns)
    # The file has true as 1.
    for column in own.columns:
        assert np.array_equal(own[column].astype(float), written[column], equal_nan=True) if column not in ("policy", "driver", "traffic") else True


def test_a_callable_drives_as_the_policy_that_it_is():
    asked = {"traffic": "native", "advised": 3, "over": 2, "hold": 2.0, **SHORT}
    constant = codrive_sim.evaluate("constant", policy_speed=5.0, **asked)

    def middle(seen):
        assert seen.shape == (1, 4) and seen.dtype == np.float32
        return np.zeros((1, 1), np.float32)

    # The middle of 0 to 10 m/s is exact in float32.
    own = codrive_sim.evaluate(middle, advice="speed", **asked)
    assert set(own.policy) == {"middle"}
    pandas.testing.assert_frame_equal(own.drop(columns="policy"), constant.drop(columns="policy"))


def test_a_callable_on_a_network_drives_as_the_policy_that_it_is():
    asked = {"name": "merge", "advised": "50%", "over": 1, **SHORT}
    constant = codrive_sim.evaluate("constant", policy_speed=8.0, **asked)
    # The middle of 0 to 16 m/s.
    own = codrive_sim.evaluate(lambda seen: np.zeros((1, 1), np.float32), advice="speed", top_speed_mps=16.0, **asked)
    pandas.testing.assert_frame_equal(own.drop(columns="policy"), constant.drop(columns="policy"))


class Counting:
    """Advises 1, 2, 3, ... m/s, the number of holds that it remembers."""

    def __init__(self):
        self.counts = []

    def predict(self, observation, state=None, episode_start=None, deterministic=False):
        state = np.zeros(len(observation)) if state is None else state
        self.counts.append(int(state[0]))
        return (2.0 * (state[:, None] + 1.0) / 10.0 - 1.0).astype(np.float32), state + 1.0


def test_a_model_with_memory_has_a_state_for_each_vehicle_and_drive():
    model = Counting()
    own = codrive_sim.evaluate(model, traffic="native", advised=2, over=3, advice="speed", hold=5.0, **SHORT)
    # 20 s are four holds, of two vehicles in three drives.
    assert sorted(model.counts) == sorted([0, 1, 2, 3] * 6)
    again = codrive_sim.evaluate(model, traffic="native", advised=2, over=3, advice="speed", hold=5.0, **SHORT)
    pandas.testing.assert_frame_equal(own, again)


def test_a_model_brings_the_meaning_of_its_numbers():
    class Model:
        def __init__(self, env):
            self.action_space = env.action_space

        def predict(self, observation, deterministic=False):
            assert observation.shape == (1, 2)
            return np.zeros((1, 1), np.float32), None

    asked = {"traffic": "native", "over": 1, **SHORT}
    own = codrive_sim.evaluate(Model(codrive_sim.make(advice="speed", hold=4.0, sees="speed,gap", top_speed_mps=8.0)), **asked)
    middle = codrive_sim.evaluate("constant", policy_speed=4.0, hold=4.0, **asked)
    assert list(own.mean_speed_mps) == list(middle.mean_speed_mps) and set(own.hold_s) == {4.0}
    corrects = Model(codrive_sim.make(advice="speed", sees="speed,gap", residual_over="pi"))
    with pytest.raises(ValueError, match="residual_over 'pi'(?s:.*)remedy: evaluate the file of codrive_sim.save_policy"):
        codrive_sim.evaluate(corrects, **asked)


def test_an_exception_of_a_policy_ends_the_evaluation():
    with pytest.raises(ZeroDivisionError):
        codrive_sim.evaluate(lambda seen: 1 / 0, traffic="native", over=2, **SHORT)
    with pytest.raises(ValueError, match="action for observation 0 is nan"):
        codrive_sim.evaluate(lambda seen: np.full(1, np.nan), traffic="native", over=2, **SHORT)


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"traffic": "ring", "advised": 23}, ValueError, "advised is 23; allowed: 1 to 22, as many as there are vehicles"),
        ({"traffic": "suma"}, ValueError, "did you mean sumo"),
        ({"traffic": "native", "advised": True}, TypeError, "advised is True; allowed: a number of vehicles, or a share"),
        ({"traffic": "native", "advised": "half"}, ValueError, 'advised is "half"; allowed: a share'),
        ({"traffic": "native", "advised": 23}, ValueError, "advised is 23; allowed: 0 to 22, as many as there are vehicles"),
        ({"traffic": "native", "participant": False}, TypeError, "participant: .*leave it out"),
        ({"traffic": "native", "driver": "people"}, ValueError, "driver is drawn(?s:.*)remedy: driver='follow'"),
        ({"traffic": "native", "policy": "pii"}, ValueError, "policy `pii` is unknown"),
        ({"traffic": "native", "policy": 3}, TypeError, "policy is 3; allowed"),
        ({"name": "merge"}, ValueError, 'name is "merge", a network(?s:.*)remedy: advised=\'25%\''),
        ({"name": "merge", "advised": 3}, ValueError, "advised is 3; allowed on map merge, where vehicles enter and leave: a share"),
        ({"name": "merge", "advised": 1}, ValueError, "advised is 1; allowed: a share(?s:.*)remedy: advised='25%'"),
        ({"name": "merge", "advised": "25%", "policy": "auto"}, ValueError, "policy 'auto' has no policy there(?s:.*)remedy: policy='pi'"),
        ({"name": "merge", "advised": "25%", "traffic": "native"}, ValueError, "remedy: traffic='sumo'"),
    ],
)
def test_what_is_refused(arguments, error, words):
    with pytest.raises(error, match=words):
        codrive_sim.evaluate(**{"policy": "pi", "over": 2, **SHORT, **arguments})


@pytest.mark.parametrize("network, share", [("merge", "25%"), ("grid", "100%")])
def test_policies_for_shares_on_networks_are_no_worse_than_none(network, share):
    # A loss below 0.01 m/s is less than ten drives can tell from none, and no gain may cost vehicles out. These policies advise a speed above
    # what any driver wants or the limit allows (docs/results.md: several advised vehicles), and their drives are those of none.
    for world in ["ring-study", "safe-followers", "gap-closers"]:
        files = {f"{percent}%": ROOT / f"assets/benchmarks/shares/{network}-{world}-{percent}.toml" for percent in [5, 10, 25, 50, 100]}
        shares = [tomllib.loads(file.read_text(encoding="utf-8"))["advised_share"] for file in files.values()]
        assert shares == [0.05, 0.1, 0.25, 0.5, 1.0]
        settings = {"driver": "follow", "traffic_drivers": world, "advised": share, "over": 2, "seed": 41, "warm_up_s": 0.0, "horizon_s": 60.0}
        rows = codrive_sim.evaluate(["none", str(files[share])], network, progress=False, **settings)
        plain, advised = [rows[rows.policy == policy] for policy in rows.policy.unique()]
        assert advised.mean_speed_mps.mean() - plain.mean_speed_mps.mean() > -0.01
        assert advised.outflow_per_h.mean() >= plain.outflow_per_h.mean()
        assert set(advised.advised_share) == {float(share.rstrip("%")) / 100} and not advised.crashed.any()


def test_progress_counts_the_drives(capfd):
    codrive_sim.evaluate(["pi", "none"], traffic="native", over=2, progress=True, **SHORT)
    assert "4 of 4 drives\n" in capfd.readouterr().err


def test_ctrl_c_ends_the_drives_and_their_processes():
    # Each drive would take hours.
    program = (
        "import codrive_sim, signal\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "print('begun', flush=True)\n"
        "codrive_sim.evaluate('pi', traffic='native', advised='100%', over=4, horizon_s=36_000.0, advised_body='full')\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as done:
        assert done.stdout.readline() == "begun\n"
        while not (workers := children(done.pid)):
            assert done.poll() is None, done.stderr.read()
            time.sleep(0.05)
        time.sleep(1.0)
        done.send_signal(signal.SIGINT)
        asked = time.monotonic()
        try:
            _, said = done.communicate(timeout=60)
        finally:
            done.kill()
    assert said.rstrip().endswith("KeyboardInterrupt")
    # Within a second, and the end of Python itself on a loaded machine.
    assert time.monotonic() - asked < 5.0
    assert not [pid for pid in workers if pathlib.Path(f"/proc/{pid}").exists()]


def children(pid):
    """Returns the ids of the processes that a process has started."""
    text = pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="utf-8")
    return [int(word) for word in text.split()]
