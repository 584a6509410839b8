"""Flow's grid of traffic lights, 3 x 3 or 5 x 5 crossings: an action switches lights."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from codrive_sim._drives import Order
from codrive_sim._traffic_env import Road, Timing, TrafficEnv
from codrive_sim.benchmarks._flow import NETWORKS, checked_version, demand, desired_speed, mean

_LIMIT_MPS = 35.0
_INNER_M = 300.0
_LENGTH_M = 5.0
_DESIRED_MPS = 50.0
#: Vehicles that are seen on each approach.
_SEEN = 2
#: Time for which a light is yellow, s.
_YELLOW_S = 2.0
#: Letters of a light by its direction (north and south, or east and west), green and yellow.
_GREEN, _YELLOW = ("GrGr", "rGrG"), ("yryr", "ryry")


class FlowGrid(TrafficEnv):
    """Grid of traffic lights of Flow: the paper's lights, vehicles and rewards on the network without turns.

    Observation, ``(339,)`` or ``(915,)``: of the two vehicles nearest to each crossing on each of its approaches the speeds, the distances, the
    edges; of each edge the density and the mean speed; of each light the time of its change, its direction, and whether it is not yellow. Action,
    ``(crossings,)``: above 0.5 the light changes. Reward: nearness of all speeds to 50 m/s. Evaluation: sum over time of the mean share of the
    speed limit that vehicles lack, s.
    """

    #: Vehicles keep a safe distance, the right of way and red lights; nothing bounds their braking, as in Flow.
    speed_mode = 25
    reach_m = 1.0

    def __init__(self, version: int = 0, *, controlled: bool = True, **pictures: Any) -> None:
        """Makes version 0 or 1, of 9 or 25 crossings; with ``controlled=False`` the lights are actuated, and actions do nothing."""
        self._size = {0: 3, 1: 5}[checked_version(version, 0, 1)]
        name = f"flow-grid-{self._size}"
        additional = () if controlled else (f"{name}-actuated",)
        super().__init__(NETWORKS / f"{name}.net.xml", demand(name, *additional), Timing(1.0, 1, 0, 400), **pictures)
        self._is_controlled = controlled
        road = Road(NETWORKS / f"{name}.net.xml")
        self._edges = [lane.rsplit("_", 1)[0] for lane in road.length_m if not lane.startswith(":")]
        self._edge_of = {edge: index for index, edge in enumerate(self._edges)}
        self._edge_m = np.array([road.length_m[f"{edge}_0"] for edge in self._edges])
        size = self._size
        crossings = [(row, column) for row in range(size) for column in range(size)]
        self._approaches = [approach for row, column in crossings for approach in _approaches(row, column)]
        # Flow numbers edges and crossings from 1 on.
        self._number = np.array([_number(edge, size) for edge in self._approaches]) / (4 * size * (size + 1) + size**2 - 1)
        self.action_space = Box(0.0, 1.0, (size**2,), np.float32)
        seen = 3 * len(self._approaches) * _SEEN + 2 * len(self._edges) + 3 * size**2
        self.observation_space = Box(0.0, np.inf, (seen,), np.float32)

    def begin(self, seed: int) -> None:
        """Sets all lights to green for north and south, and drives the first step."""
        lights = self._size**2
        self.memory.update(direction=np.zeros(lights, int), is_yellow=np.zeros(lights, bool), since_s=np.zeros(lights))
        self._step(None)

    def orders(self, action: Any) -> list[Order]:
        """Returns the letters of all lights, after their clocks have gone on by a step."""
        if not self._is_controlled:
            return []
        memory = self.memory
        direction, is_yellow, since_s = memory["direction"], memory["is_yellow"], memory["since_s"]
        if action is not None:
            since_s[is_yellow] += self.timing.step_s
            begins = ~is_yellow & (action > 0.5)
            is_yellow[is_yellow & (since_s >= _YELLOW_S)] = False
            is_yellow[begins], since_s[begins] = True, 0.0
            direction[begins] = 1 - direction[begins]
        # A yellow light is that of the direction before.
        letters = [_YELLOW[1 - to] if yellow else _GREEN[to] for to, yellow in zip(direction, is_yellow)]
        return [("set_letters", (f"center{light}", shown)) for light, shown in enumerate(letters)]

    def observe(self) -> NDArray[np.float32]:
        """Returns the vehicles near to crossings, the edges and the lights."""
        vehicles, count = self.now.vehicles, len(self._edges)
        lanes = [self.lane_ids[lane] for lane in vehicles.lane]
        edge = np.array([self._edge_of.get(lane.rsplit("_", 1)[0], -1) for lane in lanes], np.intp)
        speeds, distances, numbers = (np.zeros((len(self._approaches), _SEEN)) for _ in range(3))
        for row, approach in enumerate(self._approaches):
            there = np.flatnonzero(edge == self._edge_of[approach])
            to_go_m = self._edge_m[self._edge_of[approach]] - vehicles.lane_s_m[there]
            nearest = np.argsort(to_go_m, kind="stable")[:_SEEN]
            found = len(nearest)
            speeds[row, :found] = vehicles.speed_mps[there[nearest]] / _LIMIT_MPS
            distances[row, :found] = to_go_m[nearest] / _INNER_M
            numbers[row, :found] = self._number[row]
        on_edge = edge >= 0
        number = np.bincount(edge[on_edge], minlength=count)
        total = np.bincount(edge[on_edge], vehicles.speed_mps[on_edge], minlength=count)
        memory = self.memory
        lights = np.stack([memory["since_s"], memory["direction"], ~memory["is_yellow"]], 1)
        parts = [speeds, distances, numbers, _LENGTH_M * number / self._edge_m, total / np.maximum(number, 1) / _LIMIT_MPS, lights]
        return np.concatenate([part.ravel() for part in parts]).astype(np.float32)

    def reward(self, action: Any, has_failed: bool) -> float:
        """Returns the nearness of all speeds to 50 m/s."""
        return desired_speed(self.now.vehicles.speed_mps, _DESIRED_MPS)

    def measure(self) -> float:
        """Returns the mean share of the speed limit that vehicles lack over the step, s."""
        return mean((_LIMIT_MPS - self.now.vehicles.speed_mps) / _LIMIT_MPS) * self.timing.step_s

    def evaluation(self, total: float, actions: int) -> float:
        """Returns the sum over the episode so far, s."""
        return total


def _approaches(row: int, column: int) -> list[str]:
    """Returns the edges that lead to a crossing: eastwards, northwards, westwards, southwards."""
    return [f"bot{row}_{column}", f"right{row}_{column}", f"top{row}_{column + 1}", f"left{row + 1}_{column}"]


def _number(edge: str, size: int) -> int:
    """Returns Flow's number of an edge."""
    side = edge.rstrip("_0123456789")
    row, column = map(int, edge[len(side) :].split("_"))
    if side in ("bot", "top"):
        return 2 * (size + 1) * row + 2 * size * (row + 1) + 2 * column + 1 + (side == "top")
    return 2 * (size + 1) * row + 2 * size * row + 2 * column + 1 + (side == "right")
