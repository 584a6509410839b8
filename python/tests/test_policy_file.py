"""Tests of policies trained in Python, as files for all parts of codrive."""

import numpy as np
import onnxruntime
import pytest

import codrive

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
    envs = codrive.make_vec(num_envs=6, hold=2.0, **action, **SHORT)
    layers = random_layers(np.random.default_rng(1), len(envs.inputs), 7, action.get("levels", 1))
    codrive.save_policy(tmp_path / f"mine.{ending}", layers, envs)

    def by_numpy(seen):
        outputs = answer(layers, seen)
        return np.argmax(outputs, axis=1) if "levels" in action else outputs

    asked = {"over": 6, "hold": 2.0, **action, **SHORT}
    of_file = codrive.evaluate(tmp_path / f"mine.{ending}", **asked)
    of_layers = codrive.evaluate(by_numpy, **asked)
    # Sums of float32 in another order differ in the last digit, which a traffic jam amplifies; levels hide it.
    assert np.allclose(of_file.mean_speed_mps, of_layers.mean_speed_mps, atol=1e-3)
    # Other policies give other results.
    assert not np.allclose(of_file.mean_speed_mps, codrive.evaluate("none", **asked).mean_speed_mps, atol=1e-2)


def test_another_program_reads_the_onnx_file(tmp_path):
    envs = codrive.make_vec(num_envs=1)
    layers = random_layers(np.random.default_rng(2), len(envs.inputs), 5, 4, 1)
    codrive.save_policy(tmp_path / "mine.onnx", layers, envs)
    session = onnxruntime.InferenceSession(tmp_path / "mine.onnx")
    seen = np.random.default_rng(3).normal(size=(9, len(envs.inputs))).astype(np.float32)
    (outputs,) = session.run(None, {session.get_inputs()[0].name: seen})
    assert np.allclose(outputs, answer(layers, seen), atol=1e-5)


def test_a_description_says_what_the_numbers_mean():
    envs = codrive.make_vec(num_envs=1, hold=2.0, advice="speed", sees="speed,gap")
    text = codrive.describe_policy(envs)
    low, high = envs.action_limits
    assert 'action = "speed"' in text and f"limits = [{low}, {high}]" in text.replace("\n", " ")
    assert [name in text for name in ("speed", "gap", "leader_speed")] == [True, True, False]
    same = {"hold": 2.0, "advice": "speed", "sees": "speed,gap"}
    assert text == codrive.describe_policy(codrive.make(**same))
    # A policy trained in whole drives on that ring has the same description.
    assert text == codrive.describe_policy(codrive.make(traffic="native", **same))
    assert text == codrive.describe_policy(codrive.make_parallel(advised=3, **same))


def test_what_cannot_be_a_policy_is_refused_and_nothing_is_written(tmp_path):
    envs = codrive.make_vec(num_envs=1)
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
            codrive.save_policy(tmp_path / "mine.onnx", layers, envs)
    with pytest.raises(ValueError, match=r"\.onnx or \.toml"):
        codrive.save_policy(tmp_path / "mine.pt", good, envs)
    with pytest.raises(OSError, match="nowhere"):
        codrive.save_policy(tmp_path / "nowhere/mine.onnx", good, envs)
    with pytest.raises(TypeError, match="codrive.make"):
        codrive.save_policy(tmp_path / "mine.onnx", good, "ring-250")
    assert list(tmp_path.iterdir()) == []
