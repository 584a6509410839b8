"""Traffic that an environment shows to its user: all vehicles as columns, a moment, a hold; and rewards and observations made of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from gymnasium.spaces import Box, Space
from numpy.typing import ArrayLike, NDArray

from codrive_sim._codrive import HOLD_MEASURES, VEHICLE_COLUMNS
from codrive_sim._drives import HoldResult, Observed, Seen
from codrive_sim._words import did_you_mean


class Vehicles(NamedTuple):
    """All vehicles at one moment as columns, by ascending number, the participant's vehicle first. Each is an array ``(vehicles,)``; with
    ``traffic="ring"`` and several rings ``(rings, vehicles)``, the ego first, then backwards.

    Names, units and axes are those of cars.parquet in recordings.
    """

    #: Number of the vehicle; the participant's has 0.
    car: NDArray[np.uint32]
    #: True for advised vehicles.
    is_advised: NDArray[np.bool_]
    #: Index of the lane in ``env.lanes``; -1 off all lanes.
    lane: NDArray[np.int32]
    #: Front bumper along the lane, m; NaN off all lanes.
    lane_s_m: NDArray[np.float64]
    #: Front bumper beside the middle of the lane, m, positive to the left; NaN off all lanes.
    lane_offset_m: NDArray[np.float64]
    #: Front bumper along the route of the drive, m; NaN beside it.
    s_m: NDArray[np.float64]
    #: Centre, to the east, m.
    x_m: NDArray[np.float64]
    #: Centre, to the north, m.
    y_m: NDArray[np.float64]
    #: Heading, rad, 0 east, positive to the left.
    yaw_rad: NDArray[np.float64]
    #: Speed, m/s.
    speed_mps: NDArray[np.float64]
    #: Acceleration, m/s2; NaN with ``traffic="ring"``.
    accel_mps2: NDArray[np.float64]
    #: Length, m.
    length_m: NDArray[np.float64]
    #: Width, m.
    width_m: NDArray[np.float64]

    @classmethod
    def of(cls, columns: NDArray[np.float64]) -> Vehicles:
        """Returns the vehicles of ``(columns, ...)`` in the order of the fields. Numbers of the native part are views of it."""
        car, is_advised, lane, *numbers = columns
        return cls(car.astype(np.uint32), is_advised.astype(np.bool_), lane.astype(np.int32), *numbers)

    def rows(self, cars: ArrayLike) -> NDArray[np.intp]:
        """Returns the places of vehicles with these numbers in the columns; -1 where there is none."""
        wanted = np.asarray(cars, np.uint32)
        found = np.searchsorted(self.car, wanted)
        is_there = (found < len(self.car)) & (self.car[np.minimum(found, len(self.car) - 1)] == wanted) if len(self.car) else False
        return np.where(is_there, found, -1)


if Vehicles._fields != tuple(VEHICLE_COLUMNS):
    raise ImportError("the native part of codrive is of another version; build the package again")


class Moment(NamedTuple):
    """Traffic at the beginning or the end of a hold."""

    #: Time since the episode began, s; with several fast rings ``(rings,)``.
    time_s: NDArray[np.float64] | float
    #: Names of the vehicles that can be advised, with several fast rings those of each ring.
    agents: list[str]
    #: Their numbers in ``vehicles``, ``(agents,)``.
    cars: NDArray[np.uint32]
    #: Their observations by the settings, float32, ``(agents, k)``; with several fast rings ring after ring, ``(rings * agents, k)``.
    observations: NDArray[np.float32]
    #: All vehicles.
    vehicles: Vehicles
    #: Letters that each signal shows, one for each of its links.
    signals: dict[str, str]


class Hold(NamedTuple):
    """Hold that has just been driven. ``rewards`` and ``terminations`` are of the agents at its beginning, ``(agents,)``."""

    before: Moment
    #: Actions of the agents at its beginning, float32, as ``step`` takes them.
    actions: NDArray[np.float32]
    after: Moment
    #: Rewards by the settings, m/s.
    rewards: NDArray[np.float64]
    terminations: NDArray[np.bool_]
    #: Measures over the hold by their names (docs/measures.md).
    measures: dict[str, Any]


#: Function from a hold to the reward of each agent, ``(agents,)``, or one for all.
RewardFunction = Callable[[Hold], ArrayLike]
#: Function from a moment to the observation of each agent, ``(agents, ...)``.
ObservationFunction = Callable[[Moment], ArrayLike]
#: Reward of an environment: a setting (``"all"``, ``"ego"``), a measure, weights of measures, or a function.
Reward = str | Mapping[str, float] | RewardFunction

#: Rewards that are settings.
_OF_SETTINGS = ("all", "ego")


def hold_info(result: HoldResult) -> dict[str, Any]:
    """Returns the info of a hold: its measures, and the time since the episode began, s."""
    info = dict(zip(HOLD_MEASURES, result.measures.tolist()))
    info["time_s"] = result.time_s
    return info


class OwnFunctions:
    """Reward and observation of the user in place of those of the settings."""

    def __init__(
        self,
        reward: Reward | None,
        observation: ObservationFunction | None,
        observation_space: Space[Any] | None,
        measures: tuple[str, ...] = tuple(HOLD_MEASURES),
    ) -> None:
        """
        Raises:
            TypeError: The reward is neither a name, weights nor a function, or only one of observation and its space is given.
            ValueError: There is no measure of that name.
        """
        if (observation is None) != (observation_space is None):
            raise TypeError("observation and observation_space belong together: a function, and the space of what it returns for one agent")
        if observation is not None and not callable(observation):
            raise TypeError(f"observation is {observation!r}; allowed: a function from a codrive_sim.Moment to an array (agents, ...)")
        self._reward = _reward_function(reward, measures)
        self._observation = observation
        self.space = observation_space

    @classmethod
    def taken_from(cls, settings: dict[str, Any], measures: tuple[str, ...] = tuple(HOLD_MEASURES)) -> OwnFunctions:
        """Takes the functions out of the keyword arguments of an environment, which keep a reward that is a setting."""
        reward = settings.get("reward")
        if not (isinstance(reward, str) and reward in _OF_SETTINGS):
            settings.pop("reward", None)
        return cls(reward, settings.pop("observation", None), settings.pop("observation_space", None), measures)

    @property
    def are_given(self) -> bool:
        """Returns True if there is any function."""
        return self._reward is not None or self._observation is not None

    @property
    def observe(self) -> bool:
        """Returns True if observations are the user's."""
        return self._observation is not None

    def observations(self, moment: Moment) -> NDArray[Any]:
        """Returns the observation of each agent, ``(agents, ...)``.

        Raises:
            ValueError: The function returns another shape.
        """
        if self._observation is None or self.space is None:
            return moment.observations
        made = np.asarray(self._observation(moment))
        wanted = (len(moment.observations), *(self.space.shape or ()))
        if made.shape != wanted:
            raise ValueError(f"observation returned shape {made.shape}; allowed: {wanted}, one row for each agent")
        return made.astype(self.space.dtype, copy=False)

    def rewards(self, hold: Hold) -> NDArray[np.float64]:
        """Returns the reward of each agent, float64, ``(agents,)``.

        Raises:
            ValueError: The function returns another shape, or a number that is not finite.
        """
        if self._reward is None:
            return hold.rewards
        made = np.asarray(self._reward(hold), np.float64)
        if made.shape not in ((), hold.rewards.shape):
            raise ValueError(f"reward returned shape {made.shape}; allowed: {hold.rewards.shape}, or one number for all agents")
        if not np.isfinite(made).all():
            raise ValueError(f"reward returned {made}; allowed: finite numbers")
        return np.array(np.broadcast_to(made, hold.rewards.shape))


def _reward_function(reward: Any, measures: tuple[str, ...]) -> RewardFunction | None:
    if reward is None or (isinstance(reward, str) and reward in _OF_SETTINGS):
        return None
    if callable(reward):
        return reward
    weights = {reward: 1.0} if isinstance(reward, str) else reward
    if not isinstance(weights, Mapping):
        raise TypeError(f"reward is {reward!r}; allowed: a name, a dict of weights of measures, or a function from a codrive_sim.Hold")
    for name, weight in weights.items():
        if name not in measures:
            near = did_you_mean(str(name), (*_OF_SETTINGS, *measures))
            raise ValueError(f"reward names {name!r}{near}; allowed: {', '.join((*_OF_SETTINGS, *measures))}, or a function")
        if isinstance(weight, bool) or not isinstance(weight, (int, float, np.number)) or not np.isfinite(weight):
            raise ValueError(f"the weight of {name} is {weight!r}; allowed: a finite number")

    def weighted(hold: Hold) -> ArrayLike:
        # Fuel per distance is not defined where nothing has moved.
        return sum(weight * np.nan_to_num(hold.measures[name]) for name, weight in weights.items())

    return weighted



def moment(agents: list[str], observations: NDArray[np.float32], seen: Seen) -> Moment:
    """Returns the moment of a drive."""
    cars = np.array([car_of(agent) for agent in agents], np.uint32)
    return Moment(seen.time_s, agents, cars, observations, Vehicles.of(seen.columns), dict(seen.signals))


def car_of(vehicle: str | int) -> int:
    """Returns the number of a vehicle from its name or number.

    Raises:
        ValueError: This is neither.
    """
    if isinstance(vehicle, (int, np.integer)) and not isinstance(vehicle, bool) and vehicle >= 0:
        return int(vehicle)
    number = "0" if vehicle == "ego" else str(vehicle).removeprefix("vehicle_")
    if not number.isdecimal():
        raise ValueError(f"vehicle is {vehicle!r}; allowed: 'ego', a name such as 'vehicle_7', or its number")
    return int(number)


class OwnDrive:
    """One drive with the functions of its user: keeps the moment before the hold, and the last observation of each agent."""

    def __init__(self, own: OwnFunctions) -> None:
        self._own = own
        self._before: Moment | None = None
        self._last: dict[str, NDArray[Any]] = {}

    def begin(self, observed: Observed, seen: Seen) -> Observed:
        """Returns what the agents observe at the beginning of a drive."""
        self._before = moment(observed.agents, observed.observations, seen)
        made = self._own.observations(self._before)
        self._last = dict(zip(observed.agents, made))
        return Observed(observed.agents, made)

    def hold(self, actions: NDArray[np.float32], result: HoldResult, seen: Seen) -> HoldResult:
        """Returns the result of a hold with the user's rewards and observations. An agent that has left keeps its last observation."""
        before = self._before
        if before is None:
            raise RuntimeError("a hold before the drive has begun")
        agents, observations = result.after
        if not agents:
            # The drive is over; its vehicles are still there.
            is_there = Vehicles.of(seen.columns).rows(before.cars) >= 0
            agents, observations = [a for a, there in zip(before.agents, is_there) if there], result.final_observations[is_there]
        after = moment(agents, observations, seen)
        hold = Hold(before, actions, after, result.rewards, result.terminations, dict(zip(HOLD_MEASURES, result.measures.tolist())))
        rewards, made = self._own.rewards(hold), self._own.observations(after)
        self._last.update(zip(agents, made))
        final = np.stack([self._last[agent] for agent in before.agents]) if self._own.observe else result.final_observations
        self._before = after
        self._last = {agent: self._last[agent] for agent in agents}
        shown = Observed(result.after.agents, made if result.after.agents else made[:0])
        return result._replace(rewards=rewards, final_observations=final, after=shown)
