"""Several advised vehicles of one drive as the agents of a ``pettingzoo.ParallelEnv``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Space
from gymnasium.utils.seeding import np_random
from numpy.typing import NDArray

try:
    from pettingzoo import ParallelEnv
except ImportError as fault:
    raise ImportError("codrive.make_parallel needs PettingZoo: pip install pettingzoo") from fault

from codrive._codrive import DriveConfiguration
from codrive._drive_series import Camera, DriveSeries, Setup, drive_metadata
from codrive._spaces import AdviceMeaning, as_float32, check_actions, spaces
from codrive._words import did_you_mean

_ONE_EACH = (
    "engine is 'ring'; allowed: native, sumo: the fast ring advises one vehicle of each ring, the ego, and its other cars follow the "
    "intelligent driver model alone; engine='native' drives the same ring with several advised vehicles"
)


class DriveParallelEnv(AdviceMeaning, ParallelEnv):
    """One drive, in which each advised vehicle is an agent; see ``codrive.DriveEnv`` for what they see, do and are rewarded for.

    * **Agents** are named as in recordings; ``"ego"`` is the participant's. On a closed road they are known before,
      ``possible_agents``; on a road network they come and go, and there is no such list.
    * An agent that **comes** has an entry in all five dicts of that step, with a reward of 0; whoever has collided or arrived is
      **terminated** and no longer among ``agents``. At the horizon all are **truncated**.
    * Holds in which nobody is advised are driven without asking, so that ``agents`` is empty only where the episode has ended.
    """

    def __init__(
        self,
        name: str = "ring-250",
        *,
        advised: str | float,
        engine: str | None = None,
        hold: float | None = None,
        advice: str | None = None,
        driver: str | None = None,
        render_mode: str | None = None,
        view: str = "driver",
        size: tuple[int, int] = (1280, 720),
        **settings: Any,
    ) -> None:
        """See ``codrive.make_parallel``."""
        camera = Camera(render_mode, view, size)
        if isinstance(advised, bool) or not isinstance(advised, (str, int, float, np.integer, np.floating)):
            raise TypeError(f"advised is {advised!r}; allowed: a number of vehicles, or a share such as '20%' or 0.2")
        if engine == "ring":
            raise ValueError(_ONE_EACH)
        setup = Setup(name, engine, hold, advice, driver, {**settings, "advised": str(advised)})
        self.render_mode = render_mode
        self.settings: DriveConfiguration = setup.configuration
        self.metadata = {"name": "codrive_drive", "is_parallelizable": True, **drive_metadata(setup.hold_s)}
        self.agents: list[str] = []
        if not self.settings.is_open:
            self.possible_agents = self.settings.possible_agents()
        self._observation_space, self._action_space = spaces(self.settings)
        self._series = DriveSeries(setup, camera)
        self._random: np.random.Generator | None = None

    def observation_space(self, agent: str) -> Box:
        """What an agent sees; the same object for all.

        Raises:
            ValueError: It can be no agent.
        """
        self._check_name(agent)
        return self._observation_space

    def action_space(self, agent: str) -> Space:
        """What an agent is advised; the same object for all.

        Raises:
            ValueError: It can be no agent.
        """
        self._check_name(agent)
        return self._action_space

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[np.float32]], dict[str, dict[str, Any]]]:
        """Begins a drive: the one of a seed, or the next one of the series that the last seed has begun. Gives of each agent its
        observation, float32, ``(k,)``, and an empty dict.

        Raises:
            ValueError: There can be no such drive.
            RuntimeError: The drive has failed, or nobody is advised in it up to its horizon.
        """
        seed = self._series.first_seed(seed)
        if seed is not None or self._random is None:
            self._random, _ = np_random(seed)
        self.agents = []
        observed = self._series.begin(seed, self._random)
        if not observed.agents:
            self._series.fail()
            raise RuntimeError("nobody is advised up to the horizon; a larger `advised`, `horizon_s` or demand brings somebody")
        self.agents = list(observed.agents)
        return dict(zip(observed.agents, observed.observations)), {agent: {} for agent in observed.agents}

    def step(
        self, actions: Mapping[str, Any]
    ) -> tuple[
        dict[str, NDArray[np.float32]], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]
    ]:
        """One hold under these actions, of each of ``agents`` one, ``(1,)``, or the number of a level.

        Raises:
            TypeError: They are no dict, or an action is no number.
            ValueError: One is missing or too many, its shape is another, or it is NaN or out of range.
            ResetNeeded: No episode has begun, or it has ended.
            RuntimeError: The drive has failed.
        """
        self._series.check_step()
        acted = self.agents
        result = self._series.hold(self._checked(actions))
        observations = dict(zip(acted, result.final_observations))
        rewards = dict(zip(acted, map(float, result.rewards)))
        terminations = dict(zip(acted, map(bool, result.terminations)))
        truncations = {agent: result.is_truncated and not terminations[agent] for agent in acted}
        infos = {agent: {"mean_speed_mps": result.mean_speed_mps} for agent in acted}
        self.agents = list(result.after.agents)
        if not self.agents:
            self._series.end()
        for agent, seen in zip(self.agents, result.after.observations):
            if agent not in rewards:
                observations[agent], rewards[agent], infos[agent] = seen, 0.0, {}
                terminations[agent] = truncations[agent] = False
        return observations, rewards, terminations, truncations, infos

    def render(self) -> NDArray[np.uint8] | None:
        """What is seen now, uint8, ``(height, width, 3)``; None without a ``render_mode``."""
        return self._series.render()

    def fingerprint(self) -> str:
        """A hash over all states of this drive so far: equal where all of them are, to the bit."""
        return self._series.fingerprint()

    def close(self) -> None:
        """Ends the drive; nothing can be done with it afterwards."""
        self._series.close()

    def _checked(self, actions: Mapping[str, Any]) -> NDArray[np.float32]:
        """The actions in the order of ``agents``."""
        if not isinstance(actions, Mapping):
            raise TypeError(f"actions are {type(actions).__name__}; allowed: a dict with an action for each of env.agents")
        missing = [agent for agent in self.agents if agent not in actions]
        if missing:
            raise ValueError(f"actions have none for {missing[0]!r}; allowed: one for each of env.agents, {len(self.agents)} now")
        for agent in actions:
            if agent not in self.agents:
                raise ValueError(f"actions have one for {agent!r}{did_you_mean(agent, self.agents)}, who is not among env.agents now")
        levels = self.settings.levels
        shape = () if levels else (1,)
        given = [as_float32(actions[agent], levels, shape, f" of {agent!r}") for agent in self.agents]
        array = np.concatenate(given)
        check_actions(array, levels, [f" of {agent!r}" for agent in self.agents])
        return array

    def _check_name(self, agent: str) -> None:
        known = getattr(self, "possible_agents", None)
        if known is not None and agent not in known:
            raise ValueError(f"there is no agent {agent!r}{did_you_mean(agent, known)}; allowed: {', '.join(known)}")
