"""``codrive_sim.sb3.VecEnv``: rings or whole drives as a vector environment of Stable-Baselines3, which has its own interface.

Example::

    from stable_baselines3 import PPO
    import codrive_sim.sb3

    model = PPO("MlpPolicy", codrive_sim.sb3.VecEnv("ring-250", num_envs=1024, advice="speed"), device="cpu")
    model.learn(1_000_000)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

try:
    from stable_baselines3.common.vec_env.base_vec_env import VecEnv as _VecEnv
except ImportError as fault:
    raise ImportError("codrive_sim.sb3 needs Stable-Baselines3: pip install stable-baselines3") from fault

from codrive_sim._codrive import Configuration, DriveConfiguration
from codrive_sim._policy_file import recurrent_layers
from codrive_sim._register import make_vec


class VecEnv(_VecEnv):
    """All rings or drives as one environment: 1,024 rings are one call, not 1,024. Takes the arguments of ``codrive_sim.make_vec``; with
    ``advised`` each advised vehicle is one of its environments."""

    def __init__(self, name: str = "ring-250", num_envs: int = 1, **arguments: Any) -> None:
        # Copies are made below, where the rewards become float32.
        self.rings = make_vec(name, num_envs, **{**arguments, "copy": False})
        self._actions: np.ndarray | None = None
        super().__init__(self.rings.num_envs, self.rings.single_observation_space, self.rings.single_action_space)

    @property
    def settings(self) -> Configuration | DriveConfiguration:
        """Returns the settings, for ``codrive_sim.save_policy``."""
        return self.rings.settings

    def reset(self) -> np.ndarray:
        """Begins an episode in each ring, by the seed of ``seed()`` or else the next one. Returns observations, float32, ``(n, k)``."""
        # SB3 gives each environment its own seed, counted up; the first one defines all.
        observations, _ = self.rings.reset(seed=self._seeds[0])
        self._reset_seeds()
        self._reset_options()
        self.reset_infos = [{} for _ in range(self.num_envs)]
        return observations.copy()

    def step_async(self, actions: np.ndarray) -> None:
        """Stores actions, ``(n, 1)``, or ``(n,)`` for levels."""
        self._actions = actions

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Returns observations, rewards (float32), endings, and infos; after an ending the info has the last observation and the reason."""
        observations, rewards, terminations, truncations, infos = self.rings.step(self._actions)
        told: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        ended = terminations | truncations
        for ring in np.flatnonzero(ended):
            told[ring] = {
                "terminal_observation": infos["final_obs"][ring],
                "TimeLimit.truncated": bool(truncations[ring] and not terminations[ring]),
                "mean_speed_mps": float(infos["mean_speed_mps"][ring]),
            }
        return observations.copy(), rewards.astype(np.float32), ended, told

    def close(self) -> None:
        """Ends the rings."""
        self.rings.close()

    def get_attr(self, attr_name: str, indices: None | int | Sequence[int] = None) -> list[Any]:
        """Returns an attribute of the rings, once for each requested ring."""
        return [getattr(self.rings, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: None | int | Sequence[int] = None) -> None:
        """Refuses: the rings are one environment."""
        raise NotImplementedError(f"{attr_name} cannot be set for single rings; make the environment with other settings")

    def env_method(
        self, method_name: str, *method_args: Any, indices: None | int | Sequence[int] = None, **method_kwargs: Any
    ) -> list[Any]:
        """Refuses: the rings are one environment."""
        raise NotImplementedError(f"{method_name} cannot be called for single rings")

    def env_is_wrapped(self, wrapper_class: type, indices: None | int | Sequence[int] = None) -> list[bool]:
        """Returns False for each ring: rings are not wrapped individually."""
        return [False for _ in self._get_indices(indices)]


def layers(model: Any) -> list[Any]:
    """Returns the policy network of a model, for ``codrive_sim.save_policy``: weights ``(inputs, outputs)`` and biases of each layer, and a
    ``codrive_sim.RecurrentLayer`` for each layer of an LSTM. The first layer takes the normaliser of a ``VecNormalize`` over, but for its limit
    ``clip_obs``.

    Args:
        model: One of PPO, TRPO or A2C with ``MlpPolicy``, or RecurrentPPO of sb3-contrib with ``MlpLstmPolicy``, and tanh between its
            layers, their default.

    Raises:
        ValueError: The network has another structure; export it as ONNX, with the text of ``codrive_sim.describe_policy`` beside it.
    """
    policy = model.policy
    # Without hidden layers it is empty, and the policy is a linear map.
    hidden = getattr(getattr(policy, "mlp_extractor", None), "policy_net", None)
    kinds = [] if hidden is None else [type(part).__name__ for part in hidden]
    if hidden is None or kinds != ["Linear", "Tanh"] * (len(kinds) // 2) or type(policy.features_extractor).__name__ != "FlattenExtractor":
        raise ValueError(
            f"the policy is {type(policy).__name__} of {kinds or 'no'} layers; allowed: MlpPolicy or MlpLstmPolicy with layers of tanh. "
            "Export it as ONNX, and write codrive_sim.describe_policy(envs) beside it as NAME.onnx.toml"
        )
    recurrent = recurrent_layers(policy.lstm_actor) if hasattr(policy, "lstm_actor") else []
    linear = [*hidden[::2], policy.action_net]
    made = [*recurrent, *((part.weight.detach().cpu().numpy().T, part.bias.detach().cpu().numpy()) for part in linear)]
    normaliser = model.get_vec_normalize_env()
    if normaliser is not None and normaliser.norm_obs:
        weights, bias = (made[0].weights, made[0].bias) if recurrent else made[0]
        scaled = weights / np.sqrt(normaliser.obs_rms.var + normaliser.epsilon)[:, None]
        first = scaled.astype(np.float32), (bias - normaliser.obs_rms.mean @ scaled).astype(np.float32)
        made[0] = made[0]._replace(weights=first[0], bias=first[1]) if recurrent else first
    return made
