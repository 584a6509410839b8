"""Networks of the Wu lab: a figure-eight, a bottleneck and a ramp, on which controlled vehicles share one policy of three actions.

Definitions: Yan et al., "Unified automatic control of vehicular systems with reinforcement learning", T-ASE 2022, and its source,
github.com/mit-wu-lab/automatic_vehicular_control at 8c27b1fd.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box, Discrete, MultiDiscrete
from numpy.typing import NDArray

from codrive_sim._drives import Order
from codrive_sim._traffic_env import Road, Timing, TrafficEnv, have_collided
from codrive_sim.benchmarks._flow import NETWORKS, TOP_SPEED_MPS, demand

#: Action that neither brakes nor accelerates.
COAST = 1
_REACH_M = 100.0


class WuLabFigureEight(TrafficEnv):
    """Figure-eight of the Wu lab with one controlled vehicle among 14.

    Observation, ``(28,)``: position along the way over its length, and speed over 30 m/s, of each vehicle in their order on the way, the
    controlled one first. Action: brake, coast or accelerate, 0.5 m/s². Reward and evaluation: mean speed of all, m/s; -10 for a
    collision.
    """

    #: Vehicles keep a safe distance and regard no right of way.
    speed_mode = 1
    _EDGES = ["e_left_bottom", "e_bottom_center", "e_center_top", "e_top_right", "e_right_center", "e_center_left"]
    _CROSSING = (["e_bottom_center_0", ":center_1_0", "e_center_top_0"], ["e_right_center_0", ":center_0_0", "e_center_left_0"])
    _VEHICLES = 14

    def __init__(self, radius: int = 30, *, controlled: bool = True, **pictures: Any) -> None:
        """Makes the figure-eight of this radius, 25, 30 or 35 m; with ``controlled=False`` actions do nothing."""
        if radius not in (25, 30, 35):
            raise ValueError(f"radius is {radius!r}; allowed: 25, 30, 35")
        name = f"wulab-figure-eight-{radius}"
        super().__init__(NETWORKS / f"{name}.net.xml", demand(name), Timing(0.1, 1, 100, 3000), **pictures)
        self._starts_m, self._length_m = Road(NETWORKS / f"{name}.net.xml").starts_m(self._EDGES)
        self._is_controlled = controlled
        self.action_space = Discrete(3)
        self.observation_space = Box(-1.0, 1.0, (2 * self._VEHICLES,), np.float32)

    def begin(self, seed: int) -> None:
        """Puts all vehicles on the road, which takes a step."""
        self._step(None)

    def orders(self, action: Any) -> list[Order]:
        """Returns the next speed of the controlled vehicle."""
        if action is None or not self._is_controlled:
            return []
        return _speed_orders(self, self._controlled(), [int(action)], (0.5, 0.5))

    def observe(self) -> NDArray[np.float32]:
        """Returns positions and speeds, beginning with the controlled vehicle."""
        position = self.along_m(self._starts_m) / self._length_m
        order = np.argsort(position, kind="stable")
        own = int(np.flatnonzero(order == self._controlled()[0])[0])
        order = np.roll(order, -own)
        position = position[order] - (0.5 if position[order[0]] >= 0.5 else 0.0)
        return np.stack([position, self.now.vehicles.speed_mps[order] / TOP_SPEED_MPS], 1).ravel().astype(np.float32)

    def reward(self, action: Any, has_failed: bool) -> float:
        """Returns the mean speed of all vehicles, m/s; -10 for a collision."""
        return -10.0 if has_failed else self.measure()

    def measure(self) -> float:
        """Returns the mean speed of all vehicles, m/s."""
        return float(self.now.vehicles.speed_mps.mean())

    def has_failed(self) -> bool:
        """Returns True if two vehicles have collided, also at the crossing."""
        return have_collided(self.now.vehicles, self.ways(*self._CROSSING))

    def _controlled(self) -> NDArray[np.intp]:
        return _rows_of(self)


class _Merging(TrafficEnv):
    """Road on which lanes end, with as many places for controlled vehicles as are ever there; one without a vehicle observes -1."""

    #: Places for controlled vehicles, and numbers that each observes.
    _PLACES, _INPUTS = 0, 0
    #: Most acceleration and braking, m/s².
    _MOST_MPS2 = (0.0, 0.0)

    def __init__(self, name: str, warm_up_steps: int, controlled: bool, pictures: dict[str, Any]) -> None:
        super().__init__(NETWORKS / f"{name}.net.xml", demand(name), Timing(0.5, 1, warm_up_steps, 2000), **pictures)
        self._length_m = Road(NETWORKS / f"{name}.net.xml").length_m
        self._is_controlled = controlled
        self.action_space = MultiDiscrete([3] * self._PLACES)
        self.observation_space = Box(-1.0, 1.0, (self._PLACES, self._INPUTS), np.float32)

    def begin(self, seed: int) -> None:
        """Begins to count the vehicles that leave."""
        self.memory.update(left=0.0)

    def orders(self, action: Any) -> list[Order]:
        """Returns the next speeds of the controlled vehicles, which have their places by their numbers."""
        if action is None or not self._is_controlled:
            return []
        return _speed_orders(self, _rows_of(self)[: self._PLACES], action.tolist(), self._MOST_MPS2)

    def after_step(self, measures: dict[str, Any]) -> None:
        """Notes how many vehicles have left in the step."""
        self.memory["left"] = measures["outflow_per_h"] * self.timing.step_s / 3600.0

    def observe(self) -> NDArray[np.float32]:
        """Returns what each controlled vehicle sees, -1 to 1."""
        seen = np.full((self._PLACES, self._INPUTS), -1.0, np.float32)
        for place, row in enumerate(_rows_of(self)[: self._PLACES]):
            seen[place] = 2.0 * np.clip(self._sees(int(row)), 0.0, 1.0) - 1.0
        return seen

    def reward(self, action: Any, has_failed: bool) -> float:
        """Returns the number of vehicles that have left in the step."""
        return float(self.memory["left"])

    def measure(self) -> float:
        """Returns the outflow of the step, vehicles an hour."""
        return float(self.memory["left"]) * 3600.0 / self.timing.step_s

    def _sees(self, row: int) -> NDArray[np.float64]:
        """Returns what the vehicle of this row sees, 0 to 1."""
        raise NotImplementedError

    def _behind(self, row: int, lane: str) -> NDArray[np.intp]:
        """Returns the vehicles on a lane that are not ahead of this one, the nearest first."""
        vehicles = self.now.vehicles
        there = np.flatnonzero(vehicles.lane == self.lane_ids.index(lane)) if lane in self.lane_ids else np.empty(0, np.intp)
        there = there[vehicles.lane_s_m[there] <= vehicles.lane_s_m[row]]
        return there[np.argsort(-vehicles.lane_s_m[there], kind="stable")]

    def _is_controlled_row(self, row: int) -> bool:
        return self.types[int(self.now.vehicles.car[row])] == "controlled"


class WuLabBottleneck(_Merging):
    """Bottleneck of the Wu lab from 4 lanes to 2 to 1; a fifth of the vehicles is controlled.

    Observation, ``(48, 6)``: for each controlled vehicle the distance to the end of its lane, its speed, and distance and speed of the nearest
    human and of the nearest controlled vehicle behind its place on the lane that merges with its own; over 100 m and 30 m/s, mapped to -1 to 1.
    Action, ``(48,)``: brake (4.5 m/s²), coast, accelerate (2.6 m/s²). Reward: vehicles that leave. Evaluation: outflow, vehicles an hour.
    """

    _PLACES, _INPUTS = 48, 6
    _MOST_MPS2 = (2.6, 4.5)

    def __init__(self, *, controlled: bool = True, **pictures: Any) -> None:
        """Makes the bottleneck; with ``controlled=False`` actions do nothing."""
        super().__init__("wulab-bottleneck", 1000, controlled, pictures)

    def yield_below(self, distance_m: float) -> NDArray[np.int64]:
        """Returns the actions of the controller that the lab derived from its policies: accelerate, but brake nearer to the end of the lane than
        this if the vehicle behind on the lane that merges is human and nearer than 30 m to its end."""
        actions = np.full(self._PLACES, COAST + 1)
        for place, row in enumerate(_rows_of(self)[: self._PLACES]):
            to_end_m, sister = self._sister(int(row))
            if sister is None or to_end_m >= distance_m:
                continue
            behind = self._behind(int(row), sister)
            if len(behind) and not self._is_controlled_row(behind[0]):
                its_m = self._length_m[sister] - self.now.vehicles.lane_s_m[behind[0]]
                actions[place] = 0 if its_m < 30.0 else COAST + 1
        return actions

    def _sister(self, row: int) -> tuple[float, str | None]:
        """Returns the distance to the end of the lane, m, and the lane that merges with it; 100 m and none after the last merge."""
        lane = self.lane_ids[self.now.vehicles.lane[row]]
        if lane.startswith(":") or lane.startswith("e_2"):
            return _REACH_M, None
        edge, index = lane.rsplit("_", 1)
        sister = int(index) - 1 if int(index) % 2 else int(index) + 1
        return self._length_m[lane] - float(self.now.vehicles.lane_s_m[row]), f"{edge}_{sister}"

    def _sees(self, row: int) -> NDArray[np.float64]:
        vehicles = self.now.vehicles
        to_end_m, sister = self._sister(row)
        human, controlled = (_REACH_M, 0.0), (_REACH_M, 0.0)
        is_human_seen = False
        for other in [] if sister is None else self._behind(row, sister):
            place = (self._length_m[str(sister)] - float(vehicles.lane_s_m[other]), float(vehicles.speed_mps[other]))
            if self._is_controlled_row(other):
                # A human behind it is hidden.
                controlled, human = place, human if is_human_seen else (0.0, TOP_SPEED_MPS)
                break
            if not is_human_seen:
                human, is_human_seen = place, True
        scale = np.array([_REACH_M, TOP_SPEED_MPS])
        return np.concatenate([(to_end_m, vehicles.speed_mps[row]) / scale, human / scale, controlled / scale])


class WuLabRamp(_Merging):
    """Ramp of the Wu lab: a road of one lane that a ramp joins; a tenth of those on the road is controlled.

    Observation, ``(16, 7)``: for each controlled vehicle its speed; gap and speed of its leader, of its follower, and of the nearest vehicle
    behind its place on the ramp's lane; over 100 m and 30 m/s, mapped to -1 to 1. Action, ``(16,)``: brake (1.5 m/s²), coast, accelerate (1 m/s²).
    Reward: vehicles that leave. Evaluation: outflow, vehicles an hour.
    """

    _PLACES, _INPUTS = 16, 7
    _MOST_MPS2 = (1.0, 1.5)

    def __init__(self, *, controlled: bool = True, **pictures: Any) -> None:
        """Makes the ramp; with ``controlled=False`` actions do nothing."""
        super().__init__("wulab-ramp", 100, controlled, pictures)

    def _sees(self, row: int) -> NDArray[np.float64]:
        vehicles, leaders = self.now
        none = (_REACH_M, 0.0)
        leader = follower = beside = none
        if leaders.car[row] >= 0:
            leader = (float(leaders.gap_m[row]), float(vehicles.speed_mps[vehicles.rows(leaders.car[row])]))
        behind = np.flatnonzero(leaders.car == vehicles.car[row])
        if len(behind):
            follower = (float(leaders.gap_m[behind[0]]), float(vehicles.speed_mps[behind[0]]))
        on_ramp = self._behind(row, "merge_0")
        if len(on_ramp) and self.lane_ids[vehicles.lane[row]] == "merge_1":
            gap_m = vehicles.lane_s_m[row] - vehicles.length_m[row] - vehicles.lane_s_m[on_ramp[0]]
            beside = (float(gap_m), float(vehicles.speed_mps[on_ramp[0]]))
        scale = np.array([_REACH_M, TOP_SPEED_MPS])
        return np.concatenate([[vehicles.speed_mps[row] / TOP_SPEED_MPS], leader / scale, follower / scale, beside / scale])


def _rows_of(env: TrafficEnv) -> NDArray[np.intp]:
    """Returns the rows of the controlled vehicles, by ascending number."""
    return np.flatnonzero([env.types[car] == "controlled" for car in env.now.vehicles.car.tolist()])


def _speed_orders(env: TrafficEnv, rows: NDArray[np.intp], actions: list[int], most_mps2: tuple[float, float]) -> list[Order]:
    """Returns the next speeds under these actions: brake, coast, accelerate."""
    acceleration = (-most_mps2[1], 0.0, most_mps2[0])
    vehicles = env.now.vehicles
    return [
        ("set_speed", (int(vehicles.car[row]), max(float(vehicles.speed_mps[row]) + acceleration[act] * env.timing.step_s, 0.0), 0.0))
        for row, act in zip(rows, actions)
    ]
