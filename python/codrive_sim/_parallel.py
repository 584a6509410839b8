"""Several advised vehicles of one drive as the agents of a ``pettingzoo.ParallelEnv``."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium.spaces import Space
from numpy.typing import NDArray

try:
    from pettingzoo import ParallelEnv
except ImportError as fault:
    raise ImportError("codrive_sim.make_parallel needs PettingZoo: pip install pettingzoo") from fault

from codrive_sim._camera import Camera, picture_metadata
from codrive_sim._codrive import DriveConfiguration
from codrive_sim._drive_series import DriveSeries, Setup
from codrive_sim._drives import Order
from codrive_sim._open_drive import OpenDrive
from codrive_sim._settings import advised_text
from codrive_sim._spaces import AdviceMeaning, Picklable, as_float32, check_actions, spaces, with_lane
from codrive_sim._traffic import OwnFunctions, car_of, hold_info
from codrive_sim._words import did_you_mean

_FAST_RING = (
    "traffic is 'ring'; allowed: native, sumo, which drive one road; codrive_sim.make_vec(..., advised=...) has several advised vehicles of many "
    "fast rings, as rows"
)


#: Smallest size of the second number of an action that changes the lane.
_SIDE = 1.0 / 3.0


def _all_as_float32(given: list[Any], levels: int, shape: tuple[int, ...], agents: list[str]) -> NDArray[np.float32]:
    """Returns the actions of all agents, each of this shape, as the engines take them, float32, flat.

    Raises:
        TypeError: An action is not a number.
        ValueError: An action has another shape.
    """
    try:
        # All at once, as each array of one number costs as much as an array of all.
        return as_float32(np.asarray(given), levels, (len(given), *shape))
    except (TypeError, ValueError):
        # One after the other for a message that names the agent.
        return np.concatenate([as_float32(one, levels, shape, f" of {agent!r}") for one, agent in zip(given, agents)])


def _check_lane_changes(settings: dict[str, Any], is_open: bool) -> None:
    """Refuses lane changes where there are none.

    Raises:
        ValueError: The road has one lane, or a vehicle has a full body, which keeps to its path.
    """
    if not is_open:
        raise ValueError("lane_changes is True; allowed: on a network with a demand, because a closed route is one lane")
    if settings["advised_body"] != "light":
        raise ValueError("lane_changes is True; allowed: with advised_body='light', because a driver of a full body keeps to the path")
    if settings["participant"]:
        raise ValueError("lane_changes is True; allowed: with participant=False, because the participant's vehicle keeps to its path")


class DriveParallelEnv(OpenDrive, Picklable, AdviceMeaning, ParallelEnv):
    """One drive, in which each advised vehicle is an agent; see ``codrive_sim.DriveEnv`` for observations, actions and rewards.

    * **Agents** are named as in recordings; ``"ego"`` is the participant's vehicle. On a closed road ``possible_agents`` lists them; on a
      road network they enter and leave, and there is no such list.
    * An agent that **enters** gets an entry in all five dicts of that step, with a reward of 0. An agent that has collided or arrived is
      **terminated** and no longer in ``agents``. At the horizon all are **truncated**.
    * With ``lane_changes`` an action is two numbers, ``Box(-1, 1, (2,))``: the advice, and the lane: below -1/3 to the right, above 1/3 to
      the left; with ``levels`` it is ``MultiDiscrete([levels, 3])``, of which 0 is to the right, 1 to stay and 2 to the left.
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
        lane_changes: bool = False,
        own_process: bool = True,
        render_mode: str | None = None,
        view: str | None = None,
        size: tuple[int, int] = (1280, 720),
        **settings: Any,
    ) -> None:
        """See ``codrive_sim.make_parallel``."""
        camera = Camera(render_mode, view, size)
        asked = advised_text(advised)
        if traffic == "ring":
            raise ValueError(_FAST_RING)
        own = OwnFunctions.taken_from(settings)
        setup = Setup(name, traffic, hold, advice, driver, {**settings, "advised": asked}, own_process)
        self.render_mode = render_mode
        self.settings: DriveConfiguration = setup.configuration
        self.metadata = {"name": "codrive_drive", "is_parallelizable": True, **picture_metadata(setup.hold_s)}
        self.agents: list[str] = []
        if not self.settings.is_open:
            self.possible_agents = self.settings.possible_agents()
        self._hold_s = setup.hold_s
        self._lane_changes = bool(lane_changes)
        self._shape = (2,) if lane_changes else () if setup.configuration.levels else (1,)
        if self._lane_changes:
            _check_lane_changes(json.loads(self.settings.json()), self.settings.is_open)
        self._observation_space, advice_space = spaces(self.settings, own.space)
        self._action_space = with_lane(advice_space) if self._lane_changes else advice_space
        self._series = DriveSeries(setup, camera, own)

    def observation_space(self, agent: str) -> Space[Any]:
        """Returns the observation space; the same object for all agents.

        Raises:
            ValueError: There is no such agent.
        """
        self._check_name(agent)
        return self._observation_space

    def action_space(self, agent: str) -> Space[Any]:
        """Returns the action space; the same object for all agents.

        Raises:
            ValueError: There is no such agent.
        """
        self._check_name(agent)
        return self._action_space

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[Any]], dict[str, dict[str, Any]]]:
        """Begins a drive: that of a seed, or the next one of the series that the last seed started. Returns for each agent its
        observation, float32, ``(k,)``, and an empty dict.

        Raises:
            ValueError: The settings or the seed allow no drive.
            RuntimeError: The drive has failed, or no vehicle is advised in it up to its horizon.
        """
        seed = self._series.first_seed(seed)
        self.agents = []
        observed = self._series.begin(seed)
        if not observed.agents:
            self._series.fail()
            raise RuntimeError("no vehicle is advised up to the horizon; set a larger `advised`, `horizon_s` or demand")
        self.agents = list(observed.agents)
        return dict(zip(observed.agents, observed.observations)), {agent: {} for agent in observed.agents}

    def step(
        self, actions: Mapping[str, Any]
    ) -> tuple[
        dict[str, NDArray[Any]], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]
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
        result = self._series.hold(*self._checked(actions))
        observations = dict(zip(acted, result.final_observations))
        rewards = dict(zip(acted, result.rewards.tolist()))
        terminations = dict(zip(acted, result.terminations.tolist()))
        truncations = {agent: result.is_truncated and not terminations[agent] for agent in acted}
        info = hold_info(result)
        infos = {agent: dict(info) for agent in acted}
        self.agents = list(result.after.agents)
        if not self.agents:
            self._series.end()
        for agent, seen in zip(self.agents, result.after.observations):
            if agent not in rewards:
                observations[agent], rewards[agent], infos[agent] = seen, 0.0, {}
                terminations[agent] = truncations[agent] = False
        return observations, rewards, terminations, truncations, infos

    def set_state(self, state: dict[str, Any]) -> dict[str, NDArray[Any]]:
        """Drives again to a state that ``get_state`` of an environment with the same settings has returned. Returns for each agent its
        observation there.

        The bits are those of the first drive; it takes as long as that drive has taken.

        Raises:
            ValueError: This is no state, or that of other settings.
        """
        self.agents = []
        observed = self._series.set_state(state)
        self.agents = list(observed.agents)
        return dict(zip(observed.agents, observed.observations))

    def _checked(self, actions: Mapping[str, Any]) -> tuple[NDArray[np.float32], list[Order] | None]:
        """Returns the checked actions in the order of ``agents``, and the orders to change lanes."""
        if not isinstance(actions, Mapping):
            raise TypeError(f"actions are {type(actions).__name__}; allowed: a dict with an action for each of env.agents")
        agents = self.agents
        if len(actions) != len(agents) or not all(agent in actions for agent in agents):
            self._refuse_owners(actions)
        levels = self.settings.levels
        array = _all_as_float32([actions[agent] for agent in agents], levels, self._shape, agents)
        lanes = None
        if self._lane_changes:
            array, lanes = map(np.ascontiguousarray, array.reshape(-1, 2).T)

        def owner(place: int) -> str:
            return f" of {agents[place]!r}"

        check_actions(array, levels, owner)
        if lanes is None:
            return array, None
        check_actions(lanes, 3 if levels else 0, owner)
        ways = lanes.astype(int) - 1 if levels else (lanes > _SIDE).astype(int) - (lanes < -_SIDE)
        return array, [("change_lane", (car_of(agent), int(way), self._hold_s)) for agent, way in zip(self.agents, ways)]

    def _refuse_owners(self, actions: Mapping[str, Any]) -> None:
        """
        Raises:
            ValueError: An agent has no action, or an action is of none.
        """
        for agent in self.agents:
            if agent not in actions:
                raise ValueError(f"actions have no entry for {agent!r}; allowed: one for each of env.agents, {len(self.agents)} now")
        for agent in actions:
            if agent not in self.agents:
                near = did_you_mean(agent, self.agents)
                raise ValueError(f"actions have an entry for {agent!r}{near}, which is not among env.agents now")

    def _check_name(self, agent: str) -> None:
        known = getattr(self, "possible_agents", None)
        if known is not None and agent not in known:
            raise ValueError(f"there is no agent {agent!r}{did_you_mean(agent, known)}; allowed: {', '.join(known)}")
