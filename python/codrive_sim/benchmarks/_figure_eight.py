"""Flow's figure-eight: 14 vehicles on two circles that cross, of which 1, 7 or 14 are controlled."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from codrive_sim._drives import Order
from codrive_sim._traffic_env import Road, Timing, TrafficEnv, have_collided
from codrive_sim.benchmarks._flow import NETWORKS, TOP_SPEED_MPS, checked_version, demand, desired_speed, idm

#: Way around the figure-eight, from the start of the reward's positions on.
EDGES = ["bottom", "top", "upper_0", "upper_1", "upper_2", "right", "left", "lower_0", "lower_1", "lower_2"]
#: Ways that cross.
_CROSSING = (["bottom_0", ":center_2_0", "top_0"], ["right_0", ":center_1_0", "left_0"])
VEHICLES = 14
#: Standard deviation of the noise that Flow adds to the accelerations of human drivers at each step, m/s².
_NOISE_MPS2 = 0.2
_MOST_MPS2 = 3.0
_DESIRED_MPS = 20.0
_STEP_S = 0.1


class FlowFigureEight(TrafficEnv):
    """Figure-eight of Flow in the paper's setting.

    Observation, ``(28,)``: speeds of the 14 vehicles over 30 m/s, then their positions along the way over its length, in the order of the
    demand. Action, ``(controlled,)``: accelerations, m/s². Reward: nearness of all speeds to 20 m/s. Evaluation: mean speed of all, m/s.
    """

    #: Vehicles keep a safe distance and regard no right of way, as in Flow.
    speed_mode = 1

    def __init__(self, version: int = 0, *, controlled: bool = True, **pictures: Any) -> None:
        """Makes version 0, 1 or 2, with 1, 7 or 14 controlled vehicles; with ``controlled=False`` all are human, and actions do nothing."""
        count = {0: 1, 1: 7, 2: 14}[checked_version(version, 0, 1, 2)]
        kind = str(count if controlled else 0)
        super().__init__(NETWORKS / "flow-figure-eight.net.xml", demand(f"flow-figure-eight-{kind}"), Timing(_STEP_S, 1, 0, 1500), **pictures)
        self._starts_m, self._length_m = Road(NETWORKS / "flow-figure-eight.net.xml").starts_m(EDGES)
        self.action_space = Box(-_MOST_MPS2, _MOST_MPS2, (count,), np.float32)
        self.observation_space = Box(0.0, 1.0, (2 * VEHICLES,), np.float32)

    def begin(self, seed: int) -> None:
        """Puts all vehicles on the road, which takes a step."""
        self.memory["noise"] = np.random.default_rng(seed)
        self._step(None)

    @property
    def _place(self) -> NDArray[np.intp]:
        """Returns the place of each vehicle in the demand, where it is called "human.3" or "controlled.13"."""
        return np.array([int(self.called[int(car)].split(".")[1]) for car in self.now.vehicles.car])

    def orders(self, action: Any) -> list[Order]:
        """Returns the next speeds of all vehicles: of humans by Flow's model, of controlled ones by the action."""
        if action is None:
            return []
        vehicles, leaders = self.now
        ahead = vehicles.rows(np.maximum(leaders.car, 0))
        acceleration = idm(vehicles.speed_mps, leaders.gap_m, vehicles.speed_mps[ahead])
        acceleration += self.memory["noise"].normal(0.0, _NOISE_MPS2, VEHICLES)
        is_controlled = np.array([self.types[int(car)] == "controlled" for car in vehicles.car])
        place = self._place
        acceleration[is_controlled] = action[np.argsort(np.argsort(place[is_controlled]))]
        speeds = np.maximum(vehicles.speed_mps + acceleration * _STEP_S, 0.0)
        return [("set_speed", (int(car), float(speed), 0.0)) for car, speed in zip(vehicles.car, speeds)]

    def observe(self) -> NDArray[np.float32]:
        """Returns speeds and positions in the order of the demand."""
        seen = np.empty(2 * VEHICLES)
        place = self._place
        seen[place] = self.now.vehicles.speed_mps / TOP_SPEED_MPS
        seen[VEHICLES + place] = self.along_m(self._starts_m) / self._length_m
        return np.clip(seen, 0.0, 1.0).astype(np.float32)

    def reward(self, action: Any, has_failed: bool) -> float:
        """Returns the nearness of all speeds to 20 m/s; 0 after a collision."""
        return 0.0 if has_failed else desired_speed(self.now.vehicles.speed_mps, _DESIRED_MPS)

    def measure(self) -> float:
        """Returns the mean speed of all vehicles, m/s."""
        return float(self.now.vehicles.speed_mps.mean())

    def has_failed(self) -> bool:
        """Returns True if two vehicles have collided, also at the crossing."""
        return have_collided(self.now.vehicles, self.ways(*_CROSSING))
