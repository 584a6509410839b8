"""Flow's merge: a road of one lane that a ramp joins; 10, 25 or 33.3 % of those on the road are controlled."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from codrive_sim._drives import Order
from codrive_sim._traffic_env import Road, Timing, TrafficEnv, have_collided
from codrive_sim.benchmarks._flow import NETWORKS, TOP_SPEED_MPS, checked_version, demand, desired_speed, mean

#: Order in which positions are counted on from edge to edge.
EDGES = ["inflow_highway", "left", "center", "inflow_merge", "bottom"]
#: Ways that join.
_JOINING = (["left_0", ":center_1_0", "center_0"], ["bottom_0", ":center_0_0"])
#: Most vehicles that are controlled at once, and the demand, by version.
_VERSIONS = {0: (5, "10"), 1: (13, "25"), 2: (17, "33")}
_MOST_MPS2 = 1.5
_DESIRED_MPS = 20.0
_STEP_S = 0.5
#: Weight of short time gaps, and the time gap below which they count, s.
_GAP_WEIGHT, _TIME_GAP_S = 0.1, 1.0
_LENGTH_M = 5.0


class FlowMerge(TrafficEnv):
    """Merge of Flow: the paper's network and rewards, and the vehicles of Flow's last state (docs/benchmarks.md says why).

    Observation, ``(5 n,)``: for each place in the list of controlled vehicles its speed, the leader's less its own, the gap ahead, its speed
    less the follower's, the gap behind; speeds over 30 m/s, gaps over the length of the network; zeros without a vehicle. Action, ``(n,)``:
    accelerations, m/s², for 1 s. Reward: nearness of all speeds to 20 m/s, less short time gaps of controlled vehicles. Evaluation: mean speed
    of all, m/s.
    """

    #: Vehicles keep a safe distance and the right of way; nothing bounds their braking, as in Flow.
    speed_mode = 9

    def __init__(self, version: int = 0, *, controlled: bool = True, **pictures: Any) -> None:
        """Makes version 0, 1 or 2; with ``controlled=False`` actions do nothing."""
        most, kind = _VERSIONS[checked_version(version, *_VERSIONS)]
        network = NETWORKS / "flow-merge.net.xml"
        super().__init__(network, demand(f"flow-merge-{kind}"), Timing(_STEP_S, 2, 0, 750), **pictures)
        self._starts_m, self._length_m = _positions(Road(network))
        self._is_controlled, self._most = controlled, most
        self.action_space = Box(-_MOST_MPS2, _MOST_MPS2, (most,), np.float32)
        self.observation_space = Box(-np.inf, np.inf, (5 * most,), np.float32)

    def begin(self, seed: int) -> None:
        """Puts the first vehicles on the road, which takes a step."""
        # Numbers of the controlled vehicles, of those that wait for a place among them, and of all that have ever waited.
        self.memory.update(listed=[], queue=[], taken=set())
        self._step(None)

    def orders(self, action: Any) -> list[Order]:
        """Returns the next speeds of the controlled vehicles, after their list is brought up to date."""
        vehicles = self.now.vehicles
        self._update_list()
        if action is None or not self._is_controlled:
            return []
        listed = self.memory["listed"]
        speeds = vehicles.speed_mps[vehicles.rows(listed)] + action[: len(listed)] * _STEP_S
        return [("set_speed", (car, max(float(speed), 0.0), 0.0)) for car, speed in zip(listed, speeds)]

    def observe(self) -> NDArray[np.float32]:
        """Returns five numbers for each place of the list."""
        vehicles, leaders = self.now
        seen = np.zeros((self._most, 5), np.float32)
        listed = np.array(self.memory["listed"], np.int64)
        if not len(listed):
            return seen.ravel()
        row = vehicles.rows(listed)
        is_there = row >= 0
        row = row[is_there]
        position_m, speed, length_m = self.along_m(self._starts_m), vehicles.speed_mps, self._length_m
        ahead, has_leader = vehicles.rows(np.maximum(leaders.car[row], 0)), leaders.car[row] >= 0
        leader_mps = np.where(has_leader, speed[ahead], TOP_SPEED_MPS)
        gap_m = np.where(has_leader, position_m[ahead] - position_m[row] - _LENGTH_M, length_m)
        # The follower is the vehicle whose leader this one is.
        is_follower = leaders.car[None, :] == listed[is_there, None]
        behind, has_follower = is_follower.argmax(1), is_follower.any(1)
        follower_mps = np.where(has_follower, speed[behind], 0.0)
        behind_m = np.where(has_follower, leaders.gap_m[behind], length_m)
        speeds = np.stack([speed[row], leader_mps - speed[row], speed[row] - follower_mps]) / TOP_SPEED_MPS
        gaps = np.stack([gap_m, behind_m]) / length_m
        seen[np.flatnonzero(is_there)] = np.stack([speeds[0], speeds[1], gaps[0], speeds[2], gaps[1]], 1)
        return seen.ravel()

    def reward(self, action: Any, has_failed: bool) -> float:
        """Returns the nearness of all speeds to 20 m/s less short time gaps, at least 0; 0 after a collision."""
        if has_failed:
            return 0.0
        vehicles, leaders = self.now
        rows = vehicles.rows(np.array(self.memory["listed"], np.int64))
        rows = rows[rows >= 0]
        rows = rows[(leaders.car[rows] >= 0) & (vehicles.speed_mps[rows] > 0.0)]
        time_gaps_s = np.maximum(leaders.gap_m[rows], 0.0) / vehicles.speed_mps[rows]
        short = np.minimum((time_gaps_s - _TIME_GAP_S) / _TIME_GAP_S, 0.0).sum()
        return max(desired_speed(vehicles.speed_mps, _DESIRED_MPS) + _GAP_WEIGHT * float(short), 0.0)

    def measure(self) -> float:
        """Returns the mean speed of all vehicles on the network, m/s."""
        return mean(self.now.vehicles.speed_mps)

    def has_failed(self) -> bool:
        """Returns True if two vehicles have collided, also where the ramp joins."""
        return have_collided(self.now.vehicles, self.ways(*_JOINING))

    def _update_list(self) -> None:
        """Takes those that have left out of the list and the queue, and fills free places at the list's end from the queue's front."""
        memory, present = self.memory, set(self.now.vehicles.car.tolist())
        new = [car for car in present - memory["taken"] if self.types[car] == "controlled"]
        memory["taken"].update(new)
        memory["listed"] = [car for car in memory["listed"] if car in present]
        # As in Flow, those that enter in one step wait in the order of their names.
        memory["queue"] = [car for car in memory["queue"] if car in present] + sorted(new, key=self.called.__getitem__)
        free = self._most - len(memory["listed"])
        memory["listed"] += memory["queue"][:free]
        memory["queue"] = memory["queue"][free:]


def _positions(road: Road) -> tuple[dict[str, float], float]:
    """Returns where each lane begins in the order of ``EDGES``, those of junctions at the end of the edge before; and the length of all, m."""
    starts: dict[str, float] = {}
    at_m = 0.0
    for way in (EDGES[:3], EDGES[3:]):
        for edge, following in zip(way, [*way[1:], "center"]):
            starts[f"{edge}_0"] = at_m
            at_m += road.length_m[f"{edge}_0"]
            if edge == "center":
                continue
            for lane in road.via(edge, following):
                starts[lane] = at_m
                at_m += road.length_m[lane]
    return starts, at_m
