"""Actions of policies of other libraries: callables, models of Stable-Baselines3, algorithms and modules of RLlib."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codrive_sim._spaces import MADE_WITH, AdviceSettings

#: Settings that give the numbers of observations and actions their meaning.
RESIDUAL = ("residual_over", "residual_mps")
MEANING = ("action", "levels", "accel_limit_mps2", "top_speed_mps", "speed_change_mps", *RESIDUAL, "sees", "scaling")

#: Function from observations, float32, ``(rings, k)``, to actions.
Ask = Callable[[NDArray[np.float32]], Any]


def label(policy: Any) -> str:
    """Returns the name of a policy in tables."""
    return getattr(policy, "__name__", None) or type(policy).__name__


def trained_with(policy: Any) -> dict[str, Any] | None:
    """Returns the settings of the environment in which a model was trained, if it knows them: models of Stable-Baselines3 and modules of
    RLlib keep the action space, loaded ones, too."""
    text = getattr(getattr(_module(policy), "action_space", None), MADE_WITH, None)
    return None if text is None else json.loads(text)


def _module(policy: Any) -> Any:
    """Returns the module of an algorithm of RLlib, and anything else as it is."""
    return policy.get_module() if hasattr(policy, "get_module") else policy


def actions_of(policy: Any, case: AdviceSettings, over: int) -> Callable[[NDArray[np.float32]], NDArray[np.float32]]:
    """Returns a function that asks a policy for the actions of ``over`` rings or vehicles and checks them. It keeps their states.

    Raises:
        TypeError: ``policy`` is not a policy.
    """
    ask = _asked(policy)

    def checked(seen: NDArray[np.float32]) -> NDArray[np.float32]:
        given = np.asarray(ask(seen))
        if given.dtype.kind not in "fiu" or given.shape not in ((over,), (over, 1)):
            raise ValueError(
                f"the policy gave {given.dtype} of shape {given.shape}; allowed: numbers of shape ({over}, 1) or ({over},)"
            )
        actions = np.ascontiguousarray(given, dtype=np.float32).reshape(-1)
        levels = case.levels
        wrong = ~np.isfinite(actions) if levels == 0 else (actions % 1 != 0) | (actions < 0) | (actions >= levels)
        if wrong.any():
            row = int(np.flatnonzero(wrong)[0])
            allowed = f"0 to {levels - 1}" if levels else "a finite number, -1 to 1 spans the limits"
            raise ValueError(f"the policy's action for observation {row} is {actions[row]}; allowed: {allowed}")
        return actions

    return checked


def _asked(policy: Any) -> Ask:
    if hasattr(policy, "predict"):
        return _of_sb3(policy)
    # An algorithm of RLlib has modules. PyTorch modules are callable, too, but for training.
    module = _module(policy)
    if hasattr(module, "forward_inference"):
        _check_connectors(policy)
        return _of_rllib(module)
    if callable(policy):
        return policy
    raise TypeError(
        f"policy is {policy!r}; allowed: a name, a file, a callable, something with predict, an algorithm or module of RLlib, "
        "or a list of such"
    )


def _of_sb3(model: Any) -> Ask:
    """Returns the actions of a model of Stable-Baselines3 without noise, with its memory and with the normaliser of its environment."""
    normaliser = model.get_vec_normalize_env() if hasattr(model, "get_vec_normalize_env") else None
    memory: dict[str, Any] = {}

    def ask(seen: NDArray[np.float32]) -> Any:
        if normaliser is not None:
            seen = normaliser.normalize_obs(seen)
        actions, state = model.predict(seen, **memory, deterministic=True)
        if state is not None:
            memory.update(state=state, episode_start=np.zeros(len(seen), np.bool_))
        return actions

    return ask


def _check_connectors(algorithm: Any) -> None:
    """Refuses an algorithm of RLlib that normalises observations outside of its module.

    Raises:
        ValueError: The algorithm has such a connector.
    """
    pipeline = getattr(getattr(algorithm, "env_runner", None), "_env_to_module", None)
    if any(type(connector).__name__ == "MeanStdFilter" for connector in getattr(pipeline, "connectors", [])):
        raise ValueError(
            "the algorithm normalises observations by MeanStdFilter, which its module does not have; "
            "give a callable that does both, or train without the filter: observations are scaled"
        )


def _batched(state: Any, rings: int, device: Any) -> Any:
    """Returns the initial state of a recurrent module for each ring."""
    import torch

    if isinstance(state, dict):
        return {key: _batched(part, rings, device) for key, part in state.items()}
    one = torch.as_tensor(state, device=device)
    return one.unsqueeze(0).repeat(rings, *[1] * one.dim())


def _of_rllib(module: Any) -> Ask:
    """Returns the actions of a PyTorch ``RLModule`` without exploration, as ``Algorithm.evaluate`` with ``explore=False``; a recurrent module
    keeps its state."""
    import torch

    parameters = getattr(module, "parameters", None)
    device = next((parameter.device for parameter in parameters()), "cpu") if parameters else "cpu"

    is_stateful = bool(module.is_stateful()) if hasattr(module, "is_stateful") else False
    memory: dict[str, Any] = {}

    def ask(seen: NDArray[np.float32]) -> Any:
        with torch.no_grad():
            observations = torch.as_tensor(seen, device=device)
            if is_stateful and not memory:
                memory["state_in"] = _batched(module.get_initial_state(), len(seen), device)
            # A recurrent module has an axis of time behind the axis of the rings.
            given = module.forward_inference({"obs": observations.unsqueeze(1) if is_stateful else observations, **memory})
            if is_stateful:
                memory["state_in"] = given["state_out"]
            if "actions" in given:
                actions = given["actions"]
            else:
                kind = module.get_inference_action_dist_cls()
                actions = kind.from_logits(given["action_dist_inputs"]).to_deterministic().sample()
        return (actions[:, 0] if is_stateful else actions).cpu().numpy()

    return ask
