"""Policies of the benchmarks, with weights that all controlled vehicles, edges or lights share, and the features that they weigh."""

from __future__ import annotations

import json
import pathlib
from typing import Any, NamedTuple

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from numpy.typing import ArrayLike, NDArray

from codrive_sim._traffic_env import TrafficEnv
from codrive_sim.benchmarks._bottleneck import FlowBottleneck
from codrive_sim.benchmarks._figure_eight import VEHICLES, FlowFigureEight
from codrive_sim.benchmarks._grid import FlowGrid
from codrive_sim.benchmarks._merge import FlowMerge
from codrive_sim.benchmarks._wulab import WuLabBottleneck, WuLabFigureEight, WuLabRamp

#: Folder of the shipped policies.
POLICIES = pathlib.Path(__file__).parent / "policies"


class SharedPolicy:
    """Policy of one benchmark: weights of its features, the same for each controlled vehicle, edge or light."""

    def __init__(self, env: TrafficEnv, weights: ArrayLike) -> None:
        """
        Raises:
            ValueError: The weights are not as many as the benchmark's features.
        """
        self._env = env
        self._weights = np.asarray(weights, np.float64)
        if self._weights.shape != (count(env),):
            raise ValueError(f"weights are {self._weights.shape}; allowed: {(count(env),)}, one for each feature of {type(env).__name__}")

    def action(self, observation: NDArray[Any]) -> Any:
        """Returns the action for an observation."""
        space = self._env.action_space
        features = _features(self._env, np.asarray(observation, np.float64))
        if isinstance(self._env, FlowBottleneck):
            wanted = np.repeat(features @ self._weights.reshape(_CONTROLLED_EDGES, -1).T, _lanes_of_edges(self._env))
        else:
            wanted = features @ self._weights
        if isinstance(self._env, FlowGrid):
            return (wanted > 0.0).astype(np.float32)
        if isinstance(space, Box):
            return (space.high * np.tanh(wanted)).astype(np.float32)
        levels = 1 + np.sign(np.trunc(2.0 * wanted)).astype(int)
        return int(levels[0]) if isinstance(space, gymnasium.spaces.Discrete) else levels


def read(file: pathlib.Path) -> list[float]:
    """Returns the weights in the file of a policy.

    Raises:
        ValueError: The file is no policy of a benchmark.
    """
    try:
        return [float(weight) for weight in json.loads(file.read_text())["weights"]]
    except (KeyError, TypeError, ValueError) as fault:
        raise ValueError(f"{file}: this is no policy of a benchmark: {fault!r}") from None


def count(env: TrafficEnv) -> int:
    """Returns the number of weights."""
    features = _features(env, np.zeros(env.observation_space.shape or ())).shape[-1]
    return features * _CONTROLLED_EDGES if isinstance(env, FlowBottleneck) else features


#: Edges of the bottleneck on which vehicles are controlled, each with weights of its own.
_CONTROLLED_EDGES = 3


def _features(env: TrafficEnv, seen: NDArray[np.float64]) -> NDArray[np.float64]:
    """Returns the features of each controlled vehicle or light, ``(n, k)``, or of the bottleneck as a whole, ``(k,)``; the last is 1."""
    if isinstance(env, FlowFigureEight):
        controlled = [place for place in range(VEHICLES) if place >= VEHICLES - 1 or env.action_space.shape == (VEHICLES,)]
        if env.action_space.shape == (VEHICLES // 2,):
            controlled = list(range(1, VEHICLES, 2))
        return _on_the_way(seen[:VEHICLES], seen[VEHICLES:], controlled)
    if isinstance(env, WuLabFigureEight):
        pairs = seen.reshape(-1, 2)
        return _on_the_way(pairs[:, 1], pairs[:, 0], [0])
    if isinstance(env, FlowMerge):
        return _with_one(seen.reshape(-1, 5))
    if isinstance(env, (WuLabBottleneck, WuLabRamp)):
        return _with_one(seen)
    if isinstance(env, FlowBottleneck):
        return _of_edges(env, seen)
    if isinstance(env, FlowGrid):
        return _of_lights(env, seen)
    raise TypeError(f"{type(env).__name__} is no benchmark")


def _with_one(features: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.concatenate([features, np.ones((*features.shape[:-1], 1))], -1)


def _on_the_way(speed: NDArray[np.float64], position: NDArray[np.float64], own: list[int]) -> NDArray[np.float64]:
    """Returns for vehicles on a closed way: own speed, speed and gap of the leader and the follower, mean speed, and the place on the way by
    two harmonics."""
    order = np.argsort(position, kind="stable")
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    ahead, behind = order[(place[own] + 1) % len(order)], order[(place[own] - 1) % len(order)]
    gaps = [(position[ahead] - position[own]) % 1.0, (position[own] - position[behind]) % 1.0]
    angles = 2.0 * np.pi * position[own]
    harmonics = [np.sin(angles), np.cos(angles), np.sin(2.0 * angles), np.cos(2.0 * angles)]
    mean = np.full(len(own), speed.mean())
    return _with_one(np.stack([speed[own], speed[ahead], speed[behind], *gaps, mean, *harmonics], 1))


def _lanes_of_edges(env: FlowBottleneck) -> list[int]:
    """Returns the number of actions on each controlled edge."""
    actions = (env.action_space.shape or (0,))[0]
    return [2 * actions // 5, 2 * actions // 5, actions // 5]


def _of_edges(env: FlowBottleneck, seen: NDArray[np.float64]) -> NDArray[np.float64]:
    """Returns number of vehicles and mean speed of humans on each edge, and the outflow."""
    scale = {141: 1, 281: 2}[len(seen)]
    ends = np.cumsum([4 * scale, 12 * scale, 12 * scale, 6 * scale, scale])
    blocks = seen[:-1].reshape(4, -1)
    numbers = [part.sum() / scale for part in np.split(blocks[0] + blocks[1], ends[:-1])]
    speeds = [part.mean() for part in np.split(blocks[2], ends[:-1])]
    return np.array([*numbers, *speeds, seen[-1], 1.0])


def _of_lights(env: FlowGrid, seen: NDArray[np.float64]) -> NDArray[np.float64]:
    """Returns for each light, of the approaches with green and then of those with red: vehicles, nearness, speed; the time of its change, and
    whether it is not yellow."""
    lights = (env.action_space.shape or (0,))[0]
    near = 8 * lights
    speed, distance = seen[:near].reshape(lights, 4, 2), seen[near : 2 * near].reshape(lights, 4, 2)
    is_there = seen[2 * near : 3 * near].reshape(lights, 4, 2) > 0.0
    states = seen[-3 * lights :].reshape(lights, 3)
    # Approaches are from the west, the south, the east and the north; direction 0 is green for north and south.
    sides = np.stack([is_there.sum(2), (is_there * (1.0 - distance)).sum(2), (is_there * speed).sum(2)], 1)
    north_south, east_west = sides[:, :, [1, 3]].sum(2), sides[:, :, [0, 2]].sum(2)
    is_first = states[:, 1:2] == 0.0
    green, red = np.where(is_first, north_south, east_west), np.where(is_first, east_west, north_south)
    return _with_one(np.concatenate([green, red, states[:, :1], states[:, 2:]], 1))
