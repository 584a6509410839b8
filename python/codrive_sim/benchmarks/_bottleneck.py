"""Flow's bottleneck: lanes drop from 4 to 2 to 1, or from 8 to 4 to 2; a tenth of the vehicles is controlled."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from codrive_sim._drives import Order
from codrive_sim._traffic_env import Road, Timing, TrafficEnv
from codrive_sim.benchmarks._flow import NETWORKS, checked_version, demand

#: Parts into which each edge is cut where it is seen, and where it is controlled.
_SEEN_PARTS = {"1": 1, "2": 3, "3": 3, "4": 3, "5": 1}
_CONTROLLED_PARTS = {"2": 2, "3": 2, "4": 2}
#: Highest speed of a controlled vehicle, by the action and at the beginning, m/s.
_TOP_MPS, _TYPE_TOP_MPS = 23.0, 30.0
_LEAST_MPS = 0.01
_MOST_CHANGE_MPS = 1.5
#: Steps over which the outflow is observed, rewarded and evaluated: 10, 5 and 500 s.
_SEEN_STEPS, _REWARD_STEPS, _EVALUATED_STEPS = 20, 10, 1000
_SCALE_PER_H = 2000.0


class FlowBottleneck(TrafficEnv):
    """Bottleneck of Flow in its last state (docs/benchmarks.md says why).

    Observation, ``(141,)`` or ``(281,)``: for each lane of each part of an edge the number of humans over 20, of controlled vehicles over 20, and
    their mean speeds over 50 m/s; last, the outflow of 10 s over 2000 an hour. Action, ``(20,)`` or ``(40,)``: change of the highest speed of
    the controlled vehicles in each lane of each part, m/s. Reward: outflow of 5 s over 2000 an hour and lane. Evaluation: outflow of
    the last 500 s, vehicles an hour.
    """

    #: Vehicles keep a safe distance and the right of way; nothing bounds their braking, as in Flow.
    speed_mode = 9
    reach_m = 1.0

    def __init__(self, version: int = 0, *, controlled: bool = True, **pictures: Any) -> None:
        """Makes version 0, or 2 with twice as many lanes; with ``controlled=False`` actions do nothing."""
        self._scale = {0: 1, 2: 2}[checked_version(version, 0, 2)]
        name = "flow-bottleneck" if self._scale == 1 else f"flow-bottleneck-{self._scale}"
        super().__init__(NETWORKS / f"{name}.net.xml", demand(name), Timing(0.5, 1, 40, 1500), **pictures)
        length_m = Road(NETWORKS / f"{name}.net.xml").length_m
        lanes = {edge: sum(lane.startswith(f"{edge}_") for lane in length_m) for edge in _SEEN_PARTS}
        self._seen_cells = _Cells(_SEEN_PARTS, lanes, length_m)
        self._controlled_cells = _Cells(_CONTROLLED_PARTS, lanes, length_m)
        self._is_controlled = controlled
        self.action_space = Box(-_MOST_CHANGE_MPS, _MOST_CHANGE_MPS, (self._controlled_cells.count,), np.float32)
        self.observation_space = Box(0.0, np.inf, (4 * self._seen_cells.count + 1,), np.float32)

    def begin(self, seed: int) -> None:
        """Prepares the highest speeds of controlled vehicles, m/s, and the outflow of each step, vehicles an hour; drives the first step."""
        self.memory.update(top_mps={}, outflow_per_h=[])
        self._step(None)

    def orders(self, action: Any) -> list[Order]:
        """Returns the highest speeds of the controlled vehicles."""
        if action is None or not self._is_controlled:
            return []
        vehicles = self.now.vehicles
        rows = np.flatnonzero(self._controlled())
        cells = self._controlled_cells.of(self._lane_ids(rows), vehicles.lane_s_m[rows])
        orders: list[Order] = []
        tops: dict[int, float] = self.memory["top_mps"]
        for car, cell in zip(vehicles.car[rows].tolist(), cells):
            before = tops.get(car, _TYPE_TOP_MPS)
            tops[car] = _TOP_MPS if cell < 0 else float(np.clip(before + action[cell], _LEAST_MPS, _TOP_MPS))
            if tops[car] != before:
                orders.append(("set_max_speed", (car, tops[car])))
        return orders

    def after_step(self, measures: dict[str, Any]) -> None:
        """Keeps the outflow of the step."""
        outflow = self.memory["outflow_per_h"]
        outflow.append(measures["outflow_per_h"])
        del outflow[:-_EVALUATED_STEPS]

    def observe(self) -> NDArray[np.float32]:
        """Returns numbers and mean speeds in each lane of each part, and the outflow."""
        vehicles, count = self.now.vehicles, self._seen_cells.count
        cells = self._seen_cells.of(self._lane_ids(np.arange(len(vehicles.car))), vehicles.lane_s_m)
        is_controlled = self._controlled()
        numbers, speeds = [], []
        for kind in (~is_controlled, is_controlled):
            own = cells[kind & (cells >= 0)]
            number = np.bincount(own, minlength=count)
            total = np.bincount(own, vehicles.speed_mps[kind & (cells >= 0)], minlength=count)
            numbers.append(number / 20.0)
            speeds.append(total / np.maximum(number, 1) / 50.0)
        return np.concatenate([*numbers, *speeds, [self._outflow_per_h(_SEEN_STEPS) / _SCALE_PER_H]]).astype(np.float32)

    def reward(self, action: Any, has_failed: bool) -> float:
        """Returns the outflow of 5 s over 2000 an hour and outgoing lane."""
        return self._outflow_per_h(_REWARD_STEPS) / (_SCALE_PER_H * self._scale)

    def measure(self) -> float:
        """Returns the outflow of the last 500 s, vehicles an hour."""
        return self._outflow_per_h(_EVALUATED_STEPS)

    def evaluation(self, total: float, actions: int) -> float:
        """Returns the outflow of the last 500 s, vehicles an hour."""
        return self.measure()

    def _outflow_per_h(self, steps: int) -> float:
        outflow = self.memory["outflow_per_h"][-steps:]
        return float(np.mean(outflow)) if outflow else 0.0

    def _controlled(self) -> NDArray[np.bool_]:
        return np.array([self.types[car] == "controlled" for car in self.now.vehicles.car.tolist()], bool)

    def _lane_ids(self, rows: NDArray[np.intp]) -> list[str]:
        lanes = self.lane_ids
        return [lanes[lane] for lane in self.now.vehicles.lane[rows]]


class _Cells:
    """Lanes of the parts of edges, counted edge by edge, part by part, from the right lane on."""

    def __init__(self, parts: dict[str, int], lanes: dict[str, int], length_m: dict[str, float]) -> None:
        self._first: dict[str, tuple[int, int, int, float]] = {}
        self.count = 0
        for edge, number in parts.items():
            for lane in range(lanes[edge]):
                name = f"{edge}_{lane}"
                self._first[name] = (self.count + lane, lanes[edge], number, length_m[name] / number)
            self.count += number * lanes[edge]

    def of(self, lanes: list[str], along_m: NDArray[np.float64]) -> NDArray[np.intp]:
        """Returns the cell of each place; -1 elsewhere."""
        return np.array([self._cell(lane, at_m) for lane, at_m in zip(lanes, along_m)], np.intp)

    def _cell(self, lane: str, at_m: float) -> int:
        if lane not in self._first:
            return -1
        first, lanes, parts, part_m = self._first[lane]
        return first + lanes * min(int(at_m / part_m), parts - 1)
