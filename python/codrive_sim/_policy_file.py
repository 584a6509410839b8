"""Policy files: policies trained in Python, for drives, studies and other programs."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from codrive_sim._codrive import Configuration, DriveConfiguration, network_description, write_network

#: Gates of each recurrent layer, in the order of their columns, which is PyTorch's.
GATES = {"lstm": ("input", "forget", "candidate", "output"), "gru": ("reset", "update", "candidate")}


class RecurrentLayer(NamedTuple):
    """Recurrent layer of a network with ``n`` units: an LSTM or a GRU. The columns of its gates lie side by side, each of ``n``, in
    PyTorch's order (LSTM: input, forget, candidate, output; GRU: reset, update, candidate)."""

    #: ``"lstm"`` or ``"gru"``.
    kind: str
    #: Weights of its inputs, ``(inputs, gates n)``, and their biases, ``(gates n,)``.
    weights: Any
    bias: Any
    #: Weights of its outputs of the hold before, ``(n, gates n)``, and their biases, ``(gates n,)``.
    state_weights: Any
    state_bias: Any


def save_policy(path: str | os.PathLike[str], layers: Sequence[Any], envs: Any) -> None:
    """Writes a network as a policy that drives, studies and evaluations take.

    Args:
        path: ``NAME.onnx``, which other programs read, too, or ``NAME.toml``, codrive's own format. An existing file is replaced.
        layers: Layers in their order. A pair of weights ``(inputs, outputs)`` and biases ``(outputs,)`` is y = x W + b, then tanh after all
            pairs but the last layer. A ``codrive_sim.RecurrentLayer``, or a ``torch.nn.LSTM`` or ``torch.nn.GRU`` of any depth, has a state of
            its own, which is zero at the first hold of a drive; it needs ``NAME.onnx``. The first layer takes an observation of ``envs``;
            the last returns an action: one number, or one per level, of which the largest wins.
        envs: The environments that it was trained in (``make``, ``make_vec``, ``make_parallel``, ``codrive_sim.sb3.VecEnv``), which define the
            meaning of its numbers.

    Raises:
        ValueError: Layers do not match each other or ``envs``, or contain numbers that are not finite.
        OSError: The file cannot be written.
    """
    given = [numbers for number, layer in enumerate(layers, 1) for numbers in _numbers(layer, number)]
    write_network(os.fspath(path), _settings(envs), given)


def recurrent_layers(module: Any) -> list[RecurrentLayer]:
    """Returns the layers of a ``torch.nn.LSTM`` or ``torch.nn.GRU``.

    Raises:
        ValueError: The module is of another kind, reads time backwards, or projects its outputs.
    """
    kind = type(module).__name__.lower()
    if kind not in GATES or module.bidirectional or module.proj_size:
        raise ValueError(f"the recurrent layer is {module!r}; allowed: torch.nn.LSTM or torch.nn.GRU, in one direction and without proj_size")

    def part(name: str, number: int) -> NDArray[np.float32]:
        return getattr(module, f"{name}_l{number}").detach().cpu().numpy()

    def layer(number: int) -> RecurrentLayer:
        weights, state_weights = part("weight_ih", number).T, part("weight_hh", number).T
        zeros = np.zeros(weights.shape[1], np.float32)
        biases = [part(name, number) if module.bias else zeros for name in ("bias_ih", "bias_hh")]
        return RecurrentLayer(kind, weights, biases[0], state_weights, biases[1])

    return [layer(number) for number in range(module.num_layers)]


def _numbers(layer: Any, number: int) -> list[tuple[str, list[list[float]], list[float], list[list[float]], list[float]]]:
    """Returns the numbers of the ``number``th given layer; a module of PyTorch may have several."""
    if hasattr(layer, "weight_ih_l0"):
        return [numbers for one in recurrent_layers(layer) for numbers in _numbers(one, number)]
    if isinstance(layer, RecurrentLayer):
        if layer.kind not in GATES:
            raise ValueError(f"layer {number} is of kind {layer.kind!r}; allowed: {', '.join(GATES)}")
        weights, bias, state_weights, state_bias = (np.ascontiguousarray(part, dtype=np.float32) for part in layer[1:])
        columns = len(GATES[layer.kind]) * len(state_weights)
        shapes = [part.shape for part in (weights, bias, state_weights, state_bias)]
        if weights.ndim != 2 or shapes[1:] != [(columns,), (len(state_weights), columns), (columns,)] or weights.shape[1] != columns:
            raise ValueError(
                f"layer {number}, {layer.kind}, has weights and biases of shape {shapes[0]}, {shapes[1]} and for its state {shapes[2]}, "
                f"{shapes[3]}; allowed: (inputs, {len(GATES[layer.kind])} n), one number for each column, and (n, {len(GATES[layer.kind])} n)"
            )
        return [(layer.kind, weights.tolist(), bias.tolist(), state_weights.tolist(), state_bias.tolist())]
    try:
        weights, bias = (np.ascontiguousarray(part, dtype=np.float32) for part in layer)
    except (TypeError, ValueError) as fault:
        raise ValueError(f"layer {number} is not a pair of weights and biases: {fault}") from None
    if weights.ndim != 2 or bias.shape != (weights.shape[1],):
        raise ValueError(
            f"layer {number} has weights of shape {weights.shape} and biases of shape {bias.shape}; allowed: (inputs, outputs) and (outputs,)"
        )
    return [("dense", weights.tolist(), bias.tolist(), [], [])]


def describe_policy(envs: Any) -> str:
    """Returns the description of a policy trained in ``envs``: the text of ``NAME.onnx.toml`` beside an ONNX file of other origin."""
    return network_description(_settings(envs))


def _settings(envs: Any) -> Configuration:
    settings = getattr(getattr(envs, "unwrapped", envs), "settings", None)
    if isinstance(settings, DriveConfiguration):
        settings = settings.learning
    if not isinstance(settings, Configuration):
        raise TypeError(f"envs is {envs!r}; allowed: an environment of codrive_sim.make, codrive_sim.make_vec or codrive_sim.sb3.VecEnv")
    return settings
