"""Tests of policies trained in Python, as files for all parts of codrive."""

import os
import pathlib
import subprocess

import numpy as np
import onnxruntime
import pytest

import codrive_sim

ROOT = pathlib.Path(__file__).parents[2]
PROGRAM = pathlib.Path(os.environ.get("CODRIVE_PROGRAM", ROOT / "target/debug/codrive"))
SHORT = {"warm_up_s": 20.0, "horizon_s": 30.0}


def random_layers(rng, *widths):
    return [(rng.normal(size=(a, b)), rng.normal(size=b)) for a, b in zip(widths, widths[1:], strict=False)]


def answer(layers, seen):
    """Returns y = x W + b, with tanh between layers, in numpy."""
    for number, (weights, bias) in enumerate(layers):
        seen = (np.tanh(seen) if number else seen) @ np.float32(weights) + np.float32(bias)
    return seen


@pytest.mark.parametrize("ending", ["onnx", "toml"])
@pytest.mark.parametrize("action", [{"advice": "speed"}, {"levels": 5}])
def test_a_saved_policy_drives_as_its_layers_do(tmp_path, ending, action):
    envs = codrive_sim.make_vec(num_envs=6, hold=2.0, **action, **SHORT)
    layers = random_layers(np.random.default_rng(1), len(envs.inputs), 7, action.get("levels", 1))
    codrive_sim.save_policy(tmp_path / f"mine.{ending}", layers, envs)

    def by_numpy(seen):
        outputs = answer(layers, seen)
        return np.argmax(outputs, axis=1) if "levels" in action else outputs

    asked = {"over": 6, "hold": 2.0, **action, **SHORT}
    of_file = codrive_sim.evaluate(tmp_path / f"mine.{ending}", **asked)
    of_layers = codrive_sim.evaluate(by_numpy, **asked)
    # Sums of float32 in another order differ in the last digit, which a traffic jam amplifies; levels hide it.
    assert np.allclose(of_file.mean_speed_mps, of_layers.mean_speed_mps, atol=1e-3)
    # Other policies give other results.
    assert not np.allclose(of_file.mean_speed_mps, codrive_sim.evaluate("none", **asked).mean_speed_mps, atol=1e-2)


def test_another_program_reads_the_onnx_file(tmp_path):
    envs = codrive_sim.make_vec(num_envs=1)
    layers = random_layers(np.random.default_rng(2), len(envs.inputs), 5, 4, 1)
    codrive_sim.save_policy(tmp_path / "mine.onnx", layers, envs)
    session = onnxruntime.InferenceSession(tmp_path / "mine.onnx")
    seen = np.random.default_rng(3).normal(size=(9, len(envs.inputs))).astype(np.float32)
    (outputs,) = session.run(None, {session.get_inputs()[0].name: seen})
    assert np.allclose(outputs, answer(layers, seen), atol=1e-5)


def sigmoid(x):
    return 1.0 / (1.0 + np.exp(-x))


def random_recurrent(rng, kind, inputs, units):
    gates = {"lstm": 4, "gru": 3}[kind] * units
    shapes = (inputs, gates), gates, (units, gates), gates
    return codrive_sim.RecurrentLayer(kind, *(rng.normal(size=shape) for shape in shapes))


def one_hold(layer, seen, states):
    """Returns the outputs and states of a recurrent layer, by the equations of PyTorch's documentation."""
    h, units = states[0], len(layer.state_weights)
    of_input, of_state = seen @ layer.weights + layer.bias, h @ layer.state_weights + layer.state_bias
    if layer.kind == "gru":
        x, s = np.split(of_input, 3, axis=1), np.split(of_state, 3, axis=1)
        reset, update = sigmoid(x[0] + s[0]), sigmoid(x[1] + s[1])
        h = (1.0 - update) * np.tanh(x[2] + reset * s[2]) + update * h
        return h, [h]
    i, f, g, o = np.split(of_input + of_state, 4, axis=1)
    c = sigmoid(f) * states[1] + sigmoid(i) * np.tanh(g)
    h = sigmoid(o) * np.tanh(c)
    assert h.shape[1] == units
    return h, [h, c]


@pytest.mark.parametrize("kind", ["lstm", "gru"])
def test_a_recurrent_policy_drives_as_its_equations(tmp_path, kind):
    envs = codrive_sim.make_vec(num_envs=1, hold=2.0, advice="speed", **SHORT)
    rng = np.random.default_rng(5)
    # Actions within the limits, 2 to 6 m/s, in which the state shows.
    layers = [random_recurrent(rng, kind, len(envs.inputs), 6), *random_layers(rng, 6, 5), (rng.normal(size=(5, 1)) / 10.0, np.full(1, -0.2))]
    codrive_sim.save_policy(tmp_path / "mine.onnx", layers, envs)

    def by_numpy(over):
        states = [np.zeros((over, 6)), np.zeros((over, 6))]

        def ask(seen):
            out, new = one_hold(layers[0], seen, states)
            states[: len(new)] = new
            # The output of the recurrent layer goes on as it is.
            return np.tanh(out @ layers[1][0] + layers[1][1]) @ layers[2][0] + layers[2][1]

        return ask

    session = onnxruntime.InferenceSession(tmp_path / "mine.onnx")
    names = [one.name for one in session.get_inputs()]
    assert names == ["observation", "state_in_h0", "state_in_c0"][: len(names)] and len(names) == {"lstm": 3, "gru": 2}[kind]
    ask, held = by_numpy(3), [np.zeros((3, 6), np.float32)] * (len(names) - 1)
    for _ in range(100):
        seen = rng.normal(size=(3, len(envs.inputs))).astype(np.float32)
        action, *held = session.run(None, dict(zip(names, [seen, *held], strict=True)))
        # A hundred float32 products: each output has about 20 sums of numbers of about 1, with 24 binary digits; gates forget older ones.
        assert np.allclose(action, ask(seen), rtol=0.0, atol=2e-5)
    asked = {"over": 6, "hold": 2.0, **SHORT}
    of_file = codrive_sim.evaluate(tmp_path / "mine.onnx", **asked)
    of_layers = codrive_sim.evaluate(by_numpy(6), advice="speed", **asked)
    # Sums of float32 differ from sums of float64 in the last digit, which a traffic jam amplifies.
    assert np.allclose(of_file.mean_speed_mps, of_layers.mean_speed_mps, rtol=0.0, atol=1e-3)
    without_state = codrive_sim.evaluate(lambda seen: by_numpy(6)(seen), advice="speed", **asked)
    assert not np.allclose(of_file.mean_speed_mps, without_state.mean_speed_mps, rtol=0.0, atol=1e-2)
    # In whole drives each advised vehicle has its own state.
    drive = {"traffic": "native", "advised": 3, "hold": 2.0, "over": 1, **SHORT}
    engaged = []

    class Model:
        def predict(self, seen, state=None, episode_start=None, deterministic=False):
            if state is None:
                engaged.append(by_numpy(1))
                state = engaged[-1]
            return state(seen), state

        action_space = envs.single_action_space

    own = codrive_sim.evaluate(Model(), **drive)
    assert len(engaged) == 3
    assert np.allclose(codrive_sim.evaluate(tmp_path / "mine.onnx", **drive).mean_speed_mps, own.mean_speed_mps, rtol=0.0, atol=1e-3)


def test_a_recorded_drive_by_a_recurrent_policy_is_replayed_to_the_bit(tmp_path):
    envs = codrive_sim.make_vec(num_envs=1, advice="speed")
    rng = np.random.default_rng(6)
    codrive_sim.save_policy(tmp_path / "mine.onnx", [random_recurrent(rng, "gru", len(envs.inputs), 4), *random_layers(rng, 4, 1)], envs)
    drive = ["run", "--traffic", "native", "--policy", tmp_path / "mine.onnx", "--advised", "2", "--warm-up", "5", "--duration", "20"]
    subprocess.run([PROGRAM, *drive, "--out", tmp_path / "out"], check=True, capture_output=True)
    advice = codrive_sim.read(tmp_path / "out")["advice"]
    assert advice.target_mps.nunique() > 10
    replayed = subprocess.run([PROGRAM, "replay", tmp_path / "out"], capture_output=True, text=True)
    assert replayed.returncode == 0, replayed.stderr


def test_what_cannot_be_a_recurrent_layer_is_refused(tmp_path):
    envs = codrive_sim.make_vec(num_envs=1)
    gru = random_recurrent(np.random.default_rng(7), "gru", len(envs.inputs), 3)
    last = (np.zeros((3, 1)), np.zeros(1))
    bad = {
        "layer 1 is of kind 'rnn'; allowed: lstm, gru": [gru._replace(kind="rnn"), last],
        r"layer 1, gru, has weights and biases of shape (?s:.*); allowed: \(inputs, 3 n\)": [gru._replace(state_bias=np.zeros(3)), last],
        "mine.onnx": [gru, (np.zeros((4, 1)), np.zeros(1))],
        "NaN": [gru._replace(bias=np.full(9, np.nan)), last],
    }
    for why, layers in bad.items():
        with pytest.raises(ValueError, match=why):
            codrive_sim.save_policy(tmp_path / "mine.onnx", layers, envs)
    with pytest.raises(ValueError, match="no recurrent layers; allowed for these: a name that ends in .onnx"):
        codrive_sim.save_policy(tmp_path / "mine.toml", [gru, last], envs)
    assert list(tmp_path.iterdir()) == []


def test_a_description_says_what_the_numbers_mean():
    envs = codrive_sim.make_vec(num_envs=1, hold=2.0, advice="speed", sees="speed,gap")
    text = codrive_sim.describe_policy(envs)
    low, high = envs.action_limits
    assert 'action = "speed"' in text and f"limits = [{low}, {high}]" in text.replace("\n", " ")
    assert [name in text for name in ("speed", "gap", "leader_speed")] == [True, True, False]
    same = {"hold": 2.0, "advice": "speed", "sees": "speed,gap"}
    assert text == codrive_sim.describe_policy(codrive_sim.make(**same))
    # A policy trained in whole drives on that ring has the same description.
    assert text == codrive_sim.describe_policy(codrive_sim.make(traffic="native", **same))
    assert text == codrive_sim.describe_policy(codrive_sim.make_parallel(advised=3, **same))


def test_what_cannot_be_a_policy_is_refused_and_nothing_is_written(tmp_path):
    envs = codrive_sim.make_vec(num_envs=1)
    good = random_layers(np.random.default_rng(4), len(envs.inputs), 3, 1)
    bad = {
        "layer 1 .*inputs, outputs": [(np.zeros(3), np.zeros(3))],
        "layer 2 .*pair": [good[0], 3.0],
        "(?i)layer": [],
        "(?i)finite|number": [(np.full((len(envs.inputs), 1), np.nan), np.zeros(1))],
        "(?i)inputs|first": [(np.zeros((len(envs.inputs) + 1, 1)), np.zeros(1))],
        "(?i)outputs|last": [(np.zeros((len(envs.inputs), 2)), np.zeros(2))],
    }
    for why, layers in bad.items():
        with pytest.raises(ValueError, match=why):
            codrive_sim.save_policy(tmp_path / "mine.onnx", layers, envs)
    with pytest.raises(ValueError, match=r"\.onnx or \.toml"):
        codrive_sim.save_policy(tmp_path / "mine.pt", good, envs)
    with pytest.raises(OSError, match="nowhere"):
        codrive_sim.save_policy(tmp_path / "nowhere/mine.onnx", good, envs)
    with pytest.raises(TypeError, match="codrive_sim.make"):
        codrive_sim.save_policy(tmp_path / "mine.onnx", good, "ring-250")
    assert list(tmp_path.iterdir()) == []
