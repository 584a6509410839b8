"""Rings of traffic as environments of Gymnasium, over the fast engine."""

from __future__ import annotations

import json
from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from codrive_sim._camera import POSSIBLE_MODES, VECTOR_RENDER_MODES, Camera, picture_metadata
from codrive_sim._codrive import Configuration, Rings
from codrive_sim._ring_traffic import VIEWS, RingPictures, numbers_of, ring_columns
from codrive_sim._settings import configuration
from codrive_sim._spaces import (
    ENDED,
    NEVER,
    SEEDS,
    AdviceMeaning,
    Picklable,
    as_float32,
    check_open,
    check_settings,
    checked_count,
    checked_mask,
    checked_seed,
    checked_vector_seed,
    final_infos,
    spaces,
    vector_infos,
)
from codrive_sim._traffic import Hold, Moment, OwnFunctions, Vehicles

#: Measures of a hold of a fast ring.
RING_MEASURES = ("mean_speed_mps",)


class _Episodes:
    """Rings with their seed, the functions of their user, and whether a step is possible."""

    def __init__(self, settings: Configuration, num_envs: int, own_seed: int | None, own: OwnFunctions) -> None:
        self.rings = Rings(settings, num_envs)
        #: Names of the advised vehicles of each ring, in the order of its rows, and their numbers.
        self.agents: list[str] = settings.possible_agents()
        self._cars = numbers_of(self.agents)
        self.own = own
        self._settings = settings
        self.hold_s: float = json.loads(settings.json())["hold_s"]
        self._before: Moment | None = None
        self.levels = settings.levels
        self.is_begun = False
        rows = num_envs * len(self.agents)
        self._shape = (rows,) if settings.levels else (rows, 1)
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

    def observations(self) -> NDArray[Any]:
        """Returns what the agents observe at the beginning of episodes, ``(rows, k)``."""
        if not self.own.are_given:
            return self.rings.observations
        self._before = self._moment(self.rings.observations)
        return self.own.observations(self._before)

    def step(self, actions: NDArray[np.float32]) -> bool:
        """Drives one hold; returns True if an episode ended."""
        try:
            return self.rings.step(actions)
        except KeyboardInterrupt:
            # Some rings have driven the hold and others not.
            self.is_begun = False
            raise

    def owned(self, actions: NDArray[np.float32], has_ended: bool) -> tuple[NDArray[Any], NDArray[np.float64], NDArray[Any]]:
        """Returns observations, rewards and last observations of the hold just driven, by the user's functions if there are any."""
        rings = self.rings
        if not self.own.are_given:
            return rings.observations, rings.rewards, rings.final_observations
        before = self._before
        if before is None:
            raise RuntimeError("a hold before the episode has begun")
        try:
            now = self._moment(rings.observations)
            after = self._ended(before, now) if has_ended else now
            measures = {name: rings.mean_speeds_mps.copy() for name in RING_MEASURES}
            hold = Hold(before, actions, after, rings.rewards, rings.terminations, measures)
            rewards, final = self.own.rewards(hold), self.own.observations(after)
            self._before = now
            return self.own.observations(now) if has_ended else final, rewards, final
        except BaseException:
            # The function has not seen this hold.
            self.is_begun = False
            raise

    def vehicles(self, has_ended: bool = False) -> Vehicles:
        """Returns all vehicles now, or at the end of the last episodes, each column ``(rings, vehicles)``."""
        return ring_columns(self.rings, has_ended, self._cars)

    def ring_mask(self, rows: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Returns True for rings with a marked row."""
        return rows.reshape(-1, len(self.agents)).any(axis=1)

    def state(self) -> dict[str, Any]:
        """Returns the state of all rings."""
        if not self.is_begun:
            raise ResetNeeded(NEVER)
        return {"settings": self._settings.json(), "rings": self.rings.state()}

    def set_state(self, state: Any) -> NDArray[Any]:
        """Sets the state of all rings; returns their observations.

        Raises:
            ValueError: This is no state of rings, or that of other settings.
        """
        if not isinstance(state, dict) or not {"settings", "rings"} <= state.keys():
            raise ValueError("this is no state of rings; allowed: what get_state of such environments returns")
        check_settings(state["settings"], self._settings.json())
        self.rings.set_state(state["rings"])
        self.is_begun = True
        return self.observations()

    def _moment(self, observations: NDArray[np.float32]) -> Moment:
        return Moment(self.rings.times_s(), list(self.agents), self._cars.copy(), observations.copy(), self.vehicles(), {})

    def _ended(self, before: Moment, now: Moment) -> Moment:
        """Returns the moment after a hold in which episodes have ended, before the next ones began."""
        rings = self.rings
        ended = rings.terminations | rings.truncations
        ring_ended = self.ring_mask(ended)
        columns = zip(self.vehicles(has_ended=True), now.vehicles)
        vehicles = Vehicles(*(np.where(ring_ended[:, None], old, new) for old, new in columns))
        observations = np.where(ended[:, None], rings.final_observations, now.observations)
        time_s = np.where(ring_ended, before.time_s + self.hold_s, now.time_s)
        return Moment(time_s, now.agents, now.cars, observations, vehicles, {})

    def actions(self, actions: Any, shape: tuple[int, ...] | None = None) -> NDArray[np.float32]:
        """Returns actions as the engine takes them, float32, ``(rows,)``; raises for invalid ones."""
        return as_float32(actions, self.levels, self._shape if shape is None else shape)


class RingVectorEnv(Picklable, AdviceMeaning, gymnasium.vector.VectorEnv):
    """Many rings, each with one or several advised drivers among vehicles of the intelligent driver model.

    An action applies for one hold (``hold_s``). A step is one hold of every ring.

    * **Observation**, float32, ``(num_envs, k)``: the values that ``sees`` names, each scaled so that -1 and 1 are the ends of its range in
      ``inputs``; values beyond are not clipped.
    * **Action**, ``Box(-1, 1, (num_envs, 1))``: -1 and 1 are the ends of ``action_limits`` (m/s2 or m/s), values beyond are clipped; or
      ``MultiDiscrete`` with ``levels`` evenly spaced between them.
    * **Reward**, float64, m/s: the mean speed over the hold (of all vehicles, or of the advised one: ``reward``) minus penalties.
    * **Terminated**: vehicles collided. **Truncated**: the horizon (``horizon_s``) is reached.
    * **Info**: ``mean_speed_mps``, mean speed of all vehicles of each ring over the hold.

    With ``advised`` each advised vehicle of each ring is a row, ring after ring (``agents`` names those of a ring), so that ``num_envs`` of the
    environment is that of the rings times the agents of each. Each has its own observation, action, driver and penalties. A collision of one
    ends the episode for all agents of its ring, and its penalty is for the agents that touch another vehicle.

    A ring that ends begins another episode in the same step (``AutoresetMode.SAME_STEP``): its observation is the first of the new
    episode, the last of the old one is in ``infos["final_obs"]``, its info in ``infos["final_info"]``.

    The same seed, ``num_envs`` and actions make the same episodes to the bit, on any number of threads (``RAYON_NUM_THREADS``).
    """

    metadata = {"render_modes": list(VECTOR_RENDER_MODES), "autoreset_mode": AutoresetMode.SAME_STEP}

    def __init__(
        self,
        name: str = "ring-250",
        num_envs: int = 1,
        *,
        hold: float | None = None,
        advice: str | None = None,
        driver: str | None = None,
        copy: bool = True,
        render_mode: str | None = None,
        view: str | None = None,
        size: tuple[int, int] = (1280, 720),
        **settings: Any,
    ) -> None:
        """See ``codrive_sim.make_vec``."""
        camera = Camera(render_mode, view, size, VECTOR_RENDER_MODES, VIEWS)
        num_envs = checked_count(num_envs, 65536)
        own = OwnFunctions.taken_from(settings, RING_MEASURES)
        self.settings = configuration(name, hold, advice, driver, settings)
        self.copy = bool(copy)
        self._episodes = _Episodes(self.settings, num_envs, settings.get("seed"), own)
        #: Names of the agents of each ring, in the order of its rows. Vehicles are numbered backwards from the ego.
        self.agents: list[str] = list(self._episodes.agents)
        self.num_envs = num_envs * len(self.agents)
        self.single_observation_space, self.single_action_space = spaces(self.settings, own.space)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._everywhere = np.ones(self.num_envs, np.bool_)
        self.render_mode = render_mode
        self._pictures = RingPictures(camera, num_envs, self.settings)
        self.metadata = {**picture_metadata(self._episodes.hold_s, VECTOR_RENDER_MODES), "autoreset_mode": AutoresetMode.SAME_STEP}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[Any], dict[str, Any]]:
        """Begins an episode in each ring.

        Args:
            seed: Begins the episodes of this seed from the first one; None: the next ones.
            options: ``{"reset_mask": mask}``, bool, ``(num_envs,)``: resets only the rings with a marked agent.

        Returns:
            Observations, float32, ``(num_envs, k)``, and an empty dict.
        """
        check_open(self.closed)
        checked_vector_seed(seed, "ring has its own random numbers")
        super().reset(seed=seed)
        mask = checked_mask(options, self.num_envs)
        if not self._episodes.seed(seed, self.np_random):
            self._episodes.rings.begin(self._everywhere if mask is None else mask)
        begun = self._everywhere if mask is None or seed is not None else mask
        self._pictures.note(self._episodes.rings, self._episodes.ring_mask(begun))
        return self._given(self._episodes.observations()), {}

    def step(
        self, actions: Any
    ) -> tuple[
        NDArray[Any], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]
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
        given = self._episodes.actions(actions)
        has_ended = self._episodes.step(given)
        observations, rewards, final = self._episodes.owned(given, has_ended)
        mean_speed_mps = self._given(rings.mean_speeds_mps)
        infos = vector_infos({"mean_speed_mps": mean_speed_mps})
        terminations, truncations = self._given(rings.terminations), self._given(rings.truncations)
        if has_ended:
            infos.update(final_infos(terminations | truncations, final, {"mean_speed_mps": mean_speed_mps}))
        self._pictures.note(rings, self._episodes.ring_mask(terminations | truncations))
        return self._given(observations), self._given(rewards), terminations, truncations, infos

    @property
    def vehicles(self) -> Vehicles:
        """Returns all vehicles now, each column ``(rings, vehicles)``; NaN where a ring has fewer.

        Raises:
            ResetNeeded: No episode has begun.
        """
        check_open(self.closed)
        return self._episodes.vehicles()

    def get_state(self) -> dict[str, Any]:
        """Returns the state of all rings, with which ``set_state`` goes on to the same bits. It can be pickled."""
        check_open(self.closed)
        return {**self._episodes.state(), "random": self.np_random.bit_generator.state}

    def set_state(self, state: dict[str, Any]) -> NDArray[Any]:
        """Sets a state that ``get_state`` of an environment with the same settings and ``num_envs`` has returned. Returns the observations
        there, ``(num_envs, k)``.

        Raises:
            ValueError: This is no state, or that of other settings.
        """
        check_open(self.closed)
        observations = self._episodes.set_state(state)
        self.np_random.bit_generator.state = state["random"]
        return self._given(observations)

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Returns the present picture of each ring, uint8, ``(height, width, 3)``; None without a ``render_mode``.

        Raises:
            ResetNeeded: No episode has begun.
        """
        check_open(self.closed)
        return tuple(self._pictures.drawn()) if self.render_mode is not None else None

    def _given(self, array: NDArray[Any]) -> NDArray[Any]:
        return array.copy() if self.copy else array


class RingEnv(Picklable, AdviceMeaning, gymnasium.Env):
    """One ring; see ``RingVectorEnv`` for observations, actions, rewards and endings.

    After an episode has ended, call ``reset`` before the next ``step``.
    """

    metadata = {"render_modes": POSSIBLE_MODES}

    def __init__(
        self,
        name: str = "ring-250",
        *,
        hold: float | None = None,
        advice: str | None = None,
        driver: str | None = None,
        render_mode: str | None = None,
        view: str | None = None,
        size: tuple[int, int] = (1280, 720),
        **settings: Any,
    ) -> None:
        """See ``codrive_sim.make``."""
        camera = Camera(render_mode, view, size, views=VIEWS)
        own = OwnFunctions.taken_from(settings, RING_MEASURES)
        self.settings = configuration(name, hold, advice, driver, settings)
        if len(self.settings.possible_agents()) > 1:
            said = json.loads(self.settings.json())["advised"]
            raise ValueError(f"advised is {said!r}; allowed: 1, the ego; codrive_sim.make_vec has several advised vehicles, as rows")
        self.observation_space, self.action_space = spaces(self.settings, own.space)
        self._episodes = _Episodes(self.settings, 1, settings.get("seed"), own)
        self._has_ended = False
        self._is_closed = False
        self.render_mode = render_mode
        self._pictures = RingPictures(camera, 1, self.settings)
        self.metadata = picture_metadata(self._episodes.hold_s)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[Any], dict[str, Any]]:
        """Begins an episode: the first one of a seed, or the next one. Returns the observation, float32, ``(k,)``, and an empty dict."""
        check_open(self._is_closed)
        super().reset(seed=seed)
        if not self._episodes.seed(seed, self.np_random) and not self._has_ended:
            self._episodes.rings.begin(np.ones(1, np.bool_))
        self._has_ended = False
        self._pictures.note(self._episodes.rings, np.ones(1, np.bool_))
        return self._episodes.observations()[0].copy(), {}

    def step(self, action: Any) -> tuple[NDArray[Any], float, bool, bool, dict[str, Any]]:
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
        given = self._episodes.actions(action, shape)
        self._has_ended = self._episodes.step(given)
        observations, rewards, final = self._episodes.owned(given, self._has_ended)
        # The engine has already begun the next episode; ``reset`` returns its first observation.
        seen = final if self._has_ended else observations
        self._pictures.note(rings, np.zeros(1, np.bool_), self._has_ended)
        info = {"mean_speed_mps": float(rings.mean_speeds_mps[0])}
        return seen[0].copy(), float(rewards[0]), bool(rings.terminations[0]), bool(rings.truncations[0]), info

    @property
    def vehicles(self) -> Vehicles:
        """Returns all vehicles now as columns, the ego first, then backwards.

        Raises:
            ResetNeeded: No episode has begun.
        """
        check_open(self._is_closed)
        columns = self._episodes.vehicles(self._has_ended)
        is_there = columns.lane[0] >= 0
        return Vehicles(*(column[0, is_there] for column in columns))

    def get_state(self) -> dict[str, Any]:
        """Returns the state of the ring, with which ``set_state`` goes on to the same bits. It can be pickled.

        Raises:
            ResetNeeded: No episode has begun.
        """
        check_open(self._is_closed)
        random = self.np_random.bit_generator.state
        return {**self._episodes.state(), "random": random, "has_ended": self._has_ended}

    def set_state(self, state: dict[str, Any]) -> NDArray[Any]:
        """Sets a state that ``get_state`` of an environment with the same settings has returned. Returns the observation there.

        Raises:
            ValueError: This is no state, or that of other settings.
        """
        check_open(self._is_closed)
        observations = self._episodes.set_state(state)
        self.np_random.bit_generator.state = state["random"]
        self._has_ended = state["has_ended"]
        return observations[0].copy()

    def render(self) -> NDArray[np.uint8] | None:
        """Returns the present picture, uint8, ``(height, width, 3)``; None without a ``render_mode``, or where a window shows it.

        Raises:
            ResetNeeded: No episode has begun.
        """
        check_open(self._is_closed)
        return self._pictures.render()

    def close(self) -> None:
        """Ends the ring; the environment cannot be used afterwards."""
        self._pictures.close()
        self._is_closed = True
