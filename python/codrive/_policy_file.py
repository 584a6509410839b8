"""Policy files: policies trained in Python, for drives, studies and other programs."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import numpy as np

from codrive._codrive import Configuration, DriveConfiguration, network_description, write_network


def save_policy(path: str | os.PathLike[str], layers: Sequence[tuple[Any, Any]], envs: Any) -> None:
    """Writes a network as a policy that drives, studies and evaluations take.

    Args:
        path: ``NAME.onnx``, which other programs read, too, or ``NAME.toml``, codrive's own format. An existing file is replaced.
        layers: Weights ``(inputs, outputs)`` and biases ``(outputs,)`` of each layer: y = x W + b, then tanh on all but the last. The first
            layer takes an observation of ``envs``; the last returns an action: one number, or one per level, of which the largest wins.
        envs: The environments that it was trained in (``make``, ``make_vec``, ``make_parallel``, ``codrive.sb3.VecEnv``), which define the
            meaning of its numbers.

    Raises:
        ValueError: Layers do not match each other or ``envs``, or contain numbers that are not finite.
        OSError: The file cannot be written.
    """
    given = []
    for number, layer in enumerate(layers, 1):
        try:
            weights, bias = (np.ascontiguousarray(part, dtype=np.float32) for part in layer)
        except (TypeError, ValueError) as fault:
            raise ValueError(f"layer {number} is not a pair of weights and biases: {fault}") from None
        if weights.ndim != 2 or bias.shape != (weights.shape[1],):
            raise ValueError(
                f"layer {number} has weights of shape {weights.shape} and biases of shape {bias.shape}; allowed: (inputs, outputs) and (outputs,)"
            )
        given.append((weights.tolist(), bias.tolist()))
    write_network(os.fspath(path), _settings(envs), given)


def describe_policy(envs: Any) -> str:
    """Returns the description of a policy trained in ``envs``: the text of ``NAME.onnx.toml`` beside an ONNX file of other origin."""
    return network_description(_settings(envs))


def _settings(envs: Any) -> Configuration:
    settings = getattr(getattr(envs, "unwrapped", envs), "settings", None)
    if isinstance(settings, DriveConfiguration):
        settings = settings.learning
    if not isinstance(settings, Configuration):
        raise TypeError(f"envs is {envs!r}; allowed: an environment of codrive.make, codrive.make_vec or codrive.sb3.VecEnv")
    return settings
