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
from codrive._spaces import AdviceMeaning, Picklable, as_float32, check_actions, spaces
from codrive._words import did_you_mean

_ONE_EACH = (
    "traffic is 'ring'; allowed: native, sumo: the fast ring advises one vehicle of each ring, the ego; its other vehicles follow the "
    "intelligent driver model alone; traffic='native' drives the same ring with several advised vehicles"
)


class DriveParallelEnv(Picklable, AdviceMeaning, ParallelEnv):
    """One drive, in which each advised vehicle is an agent; see ``codrive.DriveEnv`` for observations, actions and rewards.

    * **Agents** are named as in recordings; ``"ego"`` is the participant's vehicle. On a closed road ``possible_agents`` lists them; on a
      road network they enter and leave, and there is no such list.
    * An agent that **enters** gets an entry in all five dicts of that step, with a reward of 0. An agent that has collided or arrived is
      **terminated** and no longer in ``agents``. At the horizon all are **truncated**.
    * Holds without an advised vehicle are driven without actions, so that ``agents`` is empty only after the end of the episode.
    """

    def __init__(
        self,
        name: str = "ring-250",
        *,
        advised: str | float,
        traffic: str | None = None,
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
        if traffic == "ring":
            raise ValueError(_ONE_EACH)
        setup = Setup(name, traffic, hold, advice, driver, {**settings, "advised": str(advised)})
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
        """Returns the observation space; the same object for all agents.

        Raises:
            ValueError: There is no such agent.
        """
        self._check_name(agent)
        return self._observation_space

    def action_space(self, agent: str) -> Space:
        """Returns the action space; the same object for all agents.

        Raises:
            ValueError: There is no such agent.
        """
        self._check_name(agent)
        return self._action_space

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[np.float32]], dict[str, dict[str, Any]]]:
        """Begins a drive: that of a seed, or the next one of the series that the last seed started. Returns for each agent its
        observation, float32, ``(k,)``, and an empty dict.

        Raises:
            ValueError: The settings or the seed allow no drive.
            RuntimeError: The drive has failed, or no vehicle is advised in it up to its horizon.
        """
        seed = self._series.first_seed(seed)
        if seed is not None or self._random is None:
            self._random, _ = np_random(seed)
        self.agents = []
        observed = self._series.begin(seed, self._random)
        if not observed.agents:
            self._series.fail()
            raise RuntimeError("no vehicle is advised up to the horizon; set a larger `advised`, `horizon_s` or demand")
        self.agents = list(observed.agents)
        return dict(zip(observed.agents, observed.observations)), {agent: {} for agent in observed.agents}

    def step(
        self, actions: Mapping[str, Any]
    ) -> tuple[
        dict[str, NDArray[np.float32]], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]
    ]:
        """Drives one hold under these actions, one for each of ``agents``, ``(1,)``, or the number of a level.

        Raises:
            TypeError: The actions are not a dict, or an action is not a number.
            ValueError: An action is missing or superfluous, has another shape, is NaN or is out of range.
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
        """Returns the present picture, uint8, ``(height, width, 3)``; None without a ``render_mode``."""
        return self._series.render()

    def fingerprint(self) -> str:
        """Returns a hash over all states of this drive so far; equal states have equal hashes, to the bit."""
        return self._series.fingerprint()

    def close(self) -> None:
        """Ends the drive; the environment cannot be used afterwards."""
        self._series.close()

    def _checked(self, actions: Mapping[str, Any]) -> NDArray[np.float32]:
        """Returns the checked actions in the order of ``agents``."""
        if not isinstance(actions, Mapping):
            raise TypeError(f"actions are {type(actions).__name__}; allowed: a dict with an action for each of env.agents")
        missing = [agent for agent in self.agents if agent not in actions]
        if missing:
            raise ValueError(f"actions have no entry for {missing[0]!r}; allowed: one for each of env.agents, {len(self.agents)} now")
        for agent in actions:
            if agent not in self.agents:
                near = did_you_mean(agent, self.agents)
                raise ValueError(f"actions have an entry for {agent!r}{near}, which is not among env.agents now")
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
