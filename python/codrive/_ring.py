"""Rings of traffic as environments of Gymnasium, over the fast engine."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from codrive._codrive import Configuration, Rings
from codrive._settings import configuration
from codrive._spaces import (
    ENDED,
    NEVER,
    SEEDS,
    AdviceMeaning,
    Picklable,
    RenderModeError,
    as_float32,
    check_open,
    checked_count,
    checked_mask,
    checked_seed,
    checked_vector_seed,
    final_infos,
    spaces,
)


def _check_render_mode(render_mode: object) -> None:
    if render_mode is not None:
        raise RenderModeError(f"render_mode is {render_mode!r}; allowed: None; traffic='native' and traffic='sumo' draw rings")


class _Episodes:
    """Rings with their seed, and whether a step is possible."""

    def __init__(self, settings: Configuration, num_envs: int, own_seed: int | None) -> None:
        self.rings = Rings(settings, num_envs)
        self.levels = settings.levels
        self.is_begun = False
        self._shape = (num_envs,) if settings.levels else (num_envs, 1)
        self._own_seed = own_seed

    def seed(self, seed: int | None, random: np.random.Generator) -> bool:
        """Begins the episodes of a seed if needed; returns True if it did."""
        if seed is None and self.is_begun:
            return False
        if seed is None:
            seed = self._own_seed if self._own_seed is not None else int(random.integers(SEEDS))
        seed = checked_seed(seed)
        # Ctrl-C ends a reset without an episode.
        self.is_begun = False
        self.rings.reset(seed)
        self.is_begun = True
        return True

    def step(self, actions: NDArray[np.float32]) -> bool:
        """Drives one hold; returns True if an episode ended."""
        try:
            return self.rings.step(actions)
        except KeyboardInterrupt:
            # Some rings have driven the hold and others not.
            self.is_begun = False
            raise

    def actions(self, actions: Any, shape: tuple[int, ...] | None = None) -> NDArray[np.float32]:
        """Returns actions as the engine takes them, float32, ``(num_envs,)``; raises for invalid ones."""
        return as_float32(actions, self.levels, self._shape if shape is None else shape)


class RingVectorEnv(Picklable, AdviceMeaning, gymnasium.vector.VectorEnv):
    """Many rings, each with one advised driver among vehicles of the intelligent driver model.

    An action applies for one hold (``hold_s``). A step is one hold of every ring.

    * **Observation**, float32, ``(num_envs, k)``: the values that ``sees`` names, each scaled so that -1 and 1 are the ends of its range in
      ``inputs``; values beyond are not clipped.
    * **Action**, ``Box(-1, 1, (num_envs, 1))``: -1 and 1 are the ends of ``action_limits`` (m/s2 or m/s), values beyond are clipped; or
      ``MultiDiscrete`` with ``levels`` evenly spaced between them.
    * **Reward**, float64, m/s: the mean speed over the hold (of all vehicles, or of the advised one: ``reward``) minus penalties.
    * **Terminated**: vehicles collided. **Truncated**: the horizon (``horizon_s``) is reached.
    * **Info**: ``mean_speed_mps``, mean speed of all vehicles of each ring over the hold.

    A ring that ends begins another episode in the same step (``AutoresetMode.SAME_STEP``): its observation is the first of the new
    episode, the last of the old one is in ``infos["final_obs"]``, its info in ``infos["final_info"]``.

    The same seed, ``num_envs`` and actions make the same episodes to the bit, on any number of threads (``RAYON_NUM_THREADS``).
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.SAME_STEP}

    def __init__(
        self,
        name: str = "ring-250",
        num_envs: int = 1,
        *,
        hold: float | None = None,
        advice: str | None = None,
        driver: str | None = None,
        copy: bool = True,
        render_mode: None = None,
        **settings: Any,
    ) -> None:
        """See ``codrive.make_vec``."""
        _check_render_mode(render_mode)
        num_envs = checked_count(num_envs, 65536)
        self.settings = configuration(name, hold, advice, driver, settings)
        self.copy = bool(copy)
        self.num_envs = num_envs
        self.single_observation_space, self.single_action_space = spaces(self.settings)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._episodes = _Episodes(self.settings, self.num_envs, settings.get("seed"))
        self._everywhere = np.ones(self.num_envs, np.bool_)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins an episode in each ring.

        Args:
            seed: Begins the episodes of this seed from the first one; None: the next ones.
            options: ``{"reset_mask": mask}``, bool, ``(num_envs,)``: resets only the marked rings.

        Returns:
            Observations, float32, ``(num_envs, k)``, and an empty dict.
        """
        check_open(self.closed)
        checked_vector_seed(seed, "ring has its own random numbers")
        super().reset(seed=seed)
        mask = checked_mask(options, self.num_envs)
        if not self._episodes.seed(seed, self.np_random):
            self._episodes.rings.begin(self._everywhere if mask is None else mask)
        return self._given(self._episodes.rings.observations), {}

    def step(
        self, actions: Any
    ) -> tuple[
        NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]
    ]:
        """Drives one hold of every ring under these actions, ``(num_envs, 1)``, or ``(num_envs,)`` for levels.

        Raises:
            ValueError: The actions have another shape, or one is NaN or out of range.
            ResetNeeded: No episode has begun.
        """
        check_open(self.closed)
        rings = self._episodes.rings
        if not self._episodes.is_begun:
            raise ResetNeeded(NEVER)
        has_ended = self._episodes.step(self._episodes.actions(actions))
        mean_speed_mps = self._given(rings.mean_speeds_mps)
        infos = {"mean_speed_mps": mean_speed_mps, "_mean_speed_mps": self._everywhere.copy()}
        terminations, truncations = self._given(rings.terminations), self._given(rings.truncations)
        if has_ended:
            infos.update(final_infos(terminations | truncations, rings.final_observations, mean_speed_mps))
        return self._given(rings.observations), self._given(rings.rewards), terminations, truncations, infos

    def _given(self, array: NDArray[Any]) -> NDArray[Any]:
        return array.copy() if self.copy else array


class RingEnv(Picklable, AdviceMeaning, gymnasium.Env):
    """One ring; see ``RingVectorEnv`` for observations, actions, rewards and endings.

    After an episode has ended, call ``reset`` before the next ``step``.
    """

    metadata = {"render_modes": []}

    def __init__(
        self,
        name: str = "ring-250",
        *,
        hold: float | None = None,
        advice: str | None = None,
        driver: str | None = None,
        render_mode: None = None,
        **settings: Any,
    ) -> None:
        """See ``codrive.make``."""
        _check_render_mode(render_mode)
        self.settings = configuration(name, hold, advice, driver, settings)
        self.observation_space, self.action_space = spaces(self.settings)
        self._episodes = _Episodes(self.settings, 1, settings.get("seed"))
        self._has_ended = False
        self._is_closed = False

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins an episode: the first one of a seed, or the next one. Returns the observation, float32, ``(k,)``, and an empty dict."""
        check_open(self._is_closed)
        super().reset(seed=seed)
        if not self._episodes.seed(seed, self.np_random) and not self._has_ended:
            self._episodes.rings.begin(np.ones(1, np.bool_))
        self._has_ended = False
        return self._episodes.rings.observations[0].copy(), {}

    def step(self, action: Any) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Drives one hold under this action, ``(1,)``, or the number of a level.

        Raises:
            ValueError: The action has another shape, is NaN or is out of range.
            ResetNeeded: No episode has begun, or it has ended.
        """
        check_open(self._is_closed)
        if not self._episodes.is_begun:
            raise ResetNeeded(NEVER)
        if self._has_ended:
            raise ResetNeeded(ENDED)
        rings = self._episodes.rings
        shape = () if self._episodes.levels else (1,)
        self._has_ended = self._episodes.step(self._episodes.actions(action, shape))
        # The engine has already begun the next episode; ``reset`` returns its first observation.
        seen = rings.final_observations if self._has_ended else rings.observations
        info = {"mean_speed_mps": float(rings.mean_speeds_mps[0])}
        return seen[0].copy(), float(rings.rewards[0]), bool(rings.terminations[0]), bool(rings.truncations[0]), info

    def close(self) -> None:
        """Ends the ring; the environment cannot be used afterwards."""
        self._is_closed = True
