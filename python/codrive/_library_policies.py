"""Actions of policies of other libraries: callables, models of Stable-Baselines3, algorithms and modules of RLlib."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codrive._codrive import Configuration

#: Function from observations, float32, ``(rings, k)``, to actions.
Ask = Callable[[NDArray[np.float32]], Any]


def label(policy: Any) -> str:
    """Returns the name of a policy in tables."""
    return getattr(policy, "__name__", None) or type(policy).__name__


def actions_of(policy: Any, case: Configuration, over: int) -> Callable[[NDArray[np.float32]], NDArray[np.float32]]:
    """Returns a function that asks a policy for the actions of all rings and checks them.

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
            ring = int(np.flatnonzero(wrong)[0])
            allowed = f"0 to {levels - 1}" if levels else "a finite number, -1 to 1 spans the limits"
            raise ValueError(f"the policy's action for ring {ring} is {actions[ring]}; allowed: {allowed}")
        return actions

    return checked


def _asked(policy: Any) -> Ask:
    if hasattr(policy, "predict"):
        return lambda seen: policy.predict(seen, deterministic=True)[0]
    # An algorithm of RLlib has modules. PyTorch modules are callable, too, but for training.
    module = policy.get_module() if hasattr(policy, "get_module") else policy
    if hasattr(module, "forward_inference"):
        return _of_rllib(module)
    if callable(policy):
        return policy
    raise TypeError(
        f"policy is {policy!r}; allowed: a name, a file, a callable, something with predict, an algorithm or module of RLlib, "
        "or a list of such"
    )


def _of_rllib(module: Any) -> Ask:
    """Returns the actions of a PyTorch ``RLModule`` without exploration, as ``Algorithm.evaluate`` with ``explore=False``."""
    import torch

    parameters = getattr(module, "parameters", None)
    device = next((parameter.device for parameter in parameters()), "cpu") if parameters else "cpu"

    def ask(seen: NDArray[np.float32]) -> Any:
        with torch.no_grad():
            given = module.forward_inference({"obs": torch.as_tensor(seen, device=device)})
            if "actions" in given:
                actions = given["actions"]
            else:
                kind = module.get_inference_action_dist_cls()
                actions = kind.from_logits(given["action_dist_inputs"]).to_deterministic().sample()
        return actions.cpu().numpy()

    return ask
