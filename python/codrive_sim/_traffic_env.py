"""Traffic of a network without advised vehicles as an environment of Gymnasium, whose actions are orders: the base of the benchmarks."""

from __future__ import annotations

import copy
import math
import pathlib
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple
from xml.etree import ElementTree

import gymnasium
import numpy as np
from gymnasium.spaces import Space
from numpy.typing import NDArray

from codrive_sim._camera import POSSIBLE_MODES, Camera, picture_metadata
from codrive_sim._drive_series import DriveSeries, Setup
from codrive_sim._drives import Leaders, Order
from codrive_sim._open_drive import OpenDrive
from codrive_sim._spaces import Picklable
from codrive_sim._traffic import OwnFunctions, Vehicles, hold_info

#: Actions of the advised vehicles, of which there are none.
_NO_ACTIONS = np.empty(0, np.float32)
#: Speed mode of SUMO with all checks.
_ALL_CHECKS = 31
#: Time beyond the horizon for which the drive is prepared, s.
_SPARE_S = 10.0


class Timing(NamedTuple):
    """Times of an environment: length of a step of SUMO, s; steps for which an action stands; steps before the first action; actions up to the
    horizon."""

    step_s: float
    steps_per_action: int
    warm_up_steps: int
    horizon: int


class TrafficNow:
    """Traffic at the end of a step: ``vehicles``, all of them as columns, and ``leaders``, the vehicle ahead of each, which is looked up when
    it is first asked for. ``vehicles, leaders = now`` asks for both."""

    def __init__(self, vehicles: Vehicles, leaders: Leaders | None, look: Callable[[], Leaders]) -> None:
        self.vehicles = vehicles
        #: True if the leaders were asked for.
        self.is_asked = False
        self._leaders = leaders
        self._look = look

    @property
    def leaders(self) -> Leaders:
        """Returns the vehicle ahead of each vehicle."""
        self.is_asked = True
        if self._leaders is None:
            self._leaders = self._look()
        return self._leaders

    def __iter__(self) -> Iterator[Any]:
        return iter((self.vehicles, self.leaders))


class TrafficEnv(OpenDrive, Picklable, gymnasium.Env):
    """Traffic of a network in SUMO, in which nobody sits and nobody is advised. An action becomes orders, given before each step of SUMO.

    A subclass sets ``action_space`` and ``observation_space`` and defines ``begin``, ``orders``, ``after_step``, ``observe``, ``reward``,
    ``measure`` and ``has_failed``. What it keeps from step to step it keeps in ``memory``, so that states, copies and pickles of the
    environment have it.
    """

    metadata = {"render_modes": POSSIBLE_MODES}
    #: Distance within which vehicles ahead are looked for, m.
    reach_m = 2000.0
    #: Checks that all vehicles obey, as ``set_speed_mode`` takes them; 31 is all of them.
    speed_mode = 31

    def __init__(
        self,
        network: pathlib.Path,
        demand: dict[str, Any],
        timing: Timing,
        *,
        own_process: bool = True,
        render_mode: str | None = None,
        view: str | None = None,
        size: tuple[int, int] = (1280, 720),
    ) -> None:
        """Stores the road, ``net.xml``, and who enters it: a demand as ``codrive_sim.make`` takes it."""
        seconds = timing.step_s * (timing.warm_up_steps + timing.steps_per_action * timing.horizon) + _SPARE_S
        horizon_s = math.ceil(seconds / timing.step_s) * timing.step_s
        settings = {"step_s": timing.step_s, "advised": "0", "participant": False, "warm_up_s": 0.0, "demand": demand, "horizon_s": horizon_s}
        camera = Camera(render_mode, "schematic" if view is None else view, size)
        setup = Setup(str(network), "sumo", timing.step_s, None, None, settings, own_process, takes_orders_only=True)
        self.render_mode = render_mode
        self.metadata = picture_metadata(timing.step_s * timing.steps_per_action)
        self.timing = timing
        #: What the subclass keeps from step to step.
        self.memory: dict[str, Any] = {}
        self._series = DriveSeries(setup, camera, OwnFunctions(None, None, None))
        #: Type in the demand, and name there, of each vehicle so far, by its number.
        self.types: dict[int, str] = {}
        self.called: dict[int, str] = {}
        self._now: TrafficNow | None = None
        self._actions, self._total = 0, 0.0
        self._ids_of_lanes: list[str] | None = None
        self._ways: dict[tuple[tuple[str, ...], ...], NDArray[np.intp]] = {}

    @property
    def now(self) -> TrafficNow:
        """Returns the traffic at the end of the last step."""
        if self._now is None:
            self._now = TrafficNow(self.vehicles, None, self._look)
        return self._now

    def begin(self, seed: int) -> None:
        """Prepares ``memory`` at the beginning of an episode. ``seed`` is that of the traffic."""

    def orders(self, action: Any) -> list[Order]:
        """Returns the orders before the next step; ``action`` is None in the warm-up."""
        raise NotImplementedError

    def after_step(self, measures: dict[str, Any]) -> None:
        """Takes what a step of SUMO has measured."""

    def observe(self) -> NDArray[Any]:
        """Returns the observation."""
        raise NotImplementedError

    def reward(self, action: Any, has_failed: bool) -> float:
        """Returns the reward for an action, after its last step."""
        raise NotImplementedError

    def measure(self) -> float:
        """Returns the measure by which the environment is evaluated, after an action."""
        raise NotImplementedError

    def evaluation(self, total: float, actions: int) -> float:
        """Returns the evaluation of the episode so far, given the sum of ``measure`` over its actions: its mean."""
        return total / actions

    def has_failed(self) -> bool:
        """Returns True if vehicles have collided, which ends the episode."""
        return False

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[NDArray[Any], dict[str, Any]]:
        """Begins an episode and drives its warm-up. Returns the observation, and an empty dict.

        Raises:
            ValueError: The seed is not allowed.
            RuntimeError: The drive has failed.
        """
        seed = self._series.first_seed(seed)
        super().reset(seed=seed)
        self._series.begin(seed)
        self._now, self._actions, self._total = None, 0, 0.0
        self.memory, self.types, self.called = {}, {}, {}
        self.begin(self._series.seed)
        for _ in range(self.timing.warm_up_steps):
            self._step(None)
        return self.observe(), {}

    def step(self, action: Any) -> tuple[NDArray[Any], float, bool, bool, dict[str, Any]]:
        """Drives the steps of one action. ``info`` has ``evaluation``, that of the episode so far; ``time_s``; and the measures over the last
        step of SUMO.

        Raises:
            ValueError: The action is not in the action space.
            ResetNeeded: No episode has begun, or it has ended.
            RuntimeError: The drive has failed.
        """
        self._series.check_step()
        action = _checked(action, self.action_space)
        has_failed, info = False, {}
        for _ in range(self.timing.steps_per_action):
            info = self._step(action)
            has_failed = self.has_failed()
            if has_failed:
                break
        self._actions += 1
        truncated = not has_failed and self._actions >= self.timing.horizon
        if has_failed or truncated:
            self._series.end()
        self._total += self.measure()
        info["evaluation"] = self.evaluation(self._total, self._actions)
        return self.observe(), float(self.reward(action, has_failed)), has_failed, truncated, info

    @property
    def lane_ids(self) -> list[str]:
        """Returns the ids of all lanes by their index in ``lanes``."""
        if self._ids_of_lanes is None:
            self._ids_of_lanes = [lane.id for lane in self.lanes]
        return self._ids_of_lanes

    def ways(self, *ways: list[str]) -> NDArray[np.intp]:
        """Returns the number of the way of each lane, as ``have_collided`` takes them; each way is a list of lanes."""
        key = tuple(map(tuple, ways))
        if key not in self._ways:
            number = {lane: way for way, lanes in enumerate(ways) for lane in lanes}
            self._ways[key] = np.array([number.get(lane, -1) for lane in self.lane_ids], np.intp)
        return self._ways[key]

    def along_m(self, starts_m: dict[str, float]) -> NDArray[np.float64]:
        """Returns where each vehicle is, m, given where each lane begins; NaN on other lanes."""
        vehicles, ids = self.now.vehicles, self.lane_ids
        return np.array([starts_m.get(ids[lane], np.nan) for lane in vehicles.lane.tolist()]) + vehicles.lane_s_m

    def get_state(self) -> dict[str, Any]:
        """Returns the state: the drive's, and what the environment keeps beside it. It can be pickled."""
        known = {"types": dict(self.types), "called": dict(self.called), "actions": self._actions, "total": self._total}
        return {**super().get_state(), "memory": copy.deepcopy(self.memory), **known}

    def set_state(self, state: dict[str, Any]) -> NDArray[Any]:
        """Drives again to a state that ``get_state`` of an environment with the same settings has returned. Returns the observation there.

        The bits are those of the first drive; it takes as long as that drive has taken.

        Raises:
            ValueError: This is no state, or that of other settings.
        """
        if not isinstance(state, dict) or not {"memory", "types", "called", "actions", "total"} <= state.keys():
            raise ValueError("this is no state of this environment; allowed: what get_state of such an environment returns")
        self._series.set_state(state)
        self._now, self._actions, self._total = None, state["actions"], state["total"]
        self.memory, self.types, self.called = copy.deepcopy(state["memory"]), dict(state["types"]), dict(state["called"])
        return self.observe()

    def _look(self) -> Leaders:
        return self.leaders(self.reach_m)

    def _step(self, action: Any) -> dict[str, Any]:
        """Drives one step of SUMO. Returns its measures."""
        orders = self.orders(action)
        # Who asked for the leaders after the last step gets them with this one, as each call of another process takes a message.
        is_asked = self._now is not None and self._now.is_asked
        result, seen, leaders = self._series.traffic_step(_NO_ACTIONS, orders, self.reach_m if is_asked else None)
        self._now = TrafficNow(Vehicles.of(seen.columns), leaders, self._look)
        new = [car for car in self._now.vehicles.car.tolist() if car not in self.types]
        if new:
            for car, (name, kind) in zip(new, self.names(new)):
                self.called[car], self.types[car] = name, kind
                if self.speed_mode != _ALL_CHECKS:
                    self.set_speed_mode(car, self.speed_mode)
        info = hold_info(result)
        self.after_step(info)
        return info


def _checked(action: Any, space: Space[Any]) -> NDArray[Any]:
    """Returns the action as an array of the space, numbers beyond its limits clipped.

    Raises:
        ValueError: The action has another shape, or is not finite.
    """
    made = np.asarray(action)
    if made.shape != space.shape:
        raise ValueError(f"the action has shape {made.shape}; allowed: {space.shape}")
    if not np.isfinite(made).all():
        raise ValueError(f"the action is {action}; allowed: finite numbers")
    if isinstance(space, gymnasium.spaces.Box):
        return np.clip(made, space.low, space.high)
    if not space.contains(made.astype(space.dtype)):
        raise ValueError(f"the action is {action}; allowed: {space}")
    return made


class Road:
    """Lengths of the lanes of a network, and distances along the ways through it."""

    def __init__(self, net_file: pathlib.Path) -> None:
        root = ElementTree.parse(net_file).getroot()
        #: Length of each lane, m, by SUMO's id.
        self.length_m = {lane.attrib["id"]: float(lane.attrib["length"]) for lane in root.iter("lane")}
        self._links = [link.attrib for link in root.iter("connection")]

    def starts_m(self, edges: list[str]) -> tuple[dict[str, float], float]:
        """Returns where each lane of one-lane edges and of the junctions between them begins along the way over these edges, m, and the length
        of the way. A way that ends where it began goes on through that junction."""
        starts: dict[str, float] = {}
        at_m = 0.0
        for edge, following in zip(edges, [*edges[1:], edges[0]]):
            for lane in [f"{edge}_0", *self.via(edge, following)]:
                starts[lane] = at_m
                at_m += self.length_m[lane]
        return starts, at_m

    def via(self, edge: str, following: str) -> list[str]:
        """Returns the lanes inside the junction from one edge to another, in their order; none where the edges do not meet."""
        lanes: list[str] = []
        link = self._link(edge, following)
        while link is not None and "via" in link:
            lanes.append(link["via"])
            link = self._link(lanes[-1].rsplit("_", 1)[0], following)
        return lanes

    def _link(self, edge: str, following: str) -> dict[str, str] | None:
        return next((link for link in self._links if link["from"] == edge and link["to"] == following), None)


def have_collided(vehicles: Vehicles, ways: NDArray[np.intp]) -> bool:
    """Returns True if two vehicles have collided. ``ways`` is, by lane, the number of a way that crosses others or joins them, -1 on other lanes.

    Vehicles of one lane collide if one's front is past the other's rear. Those of different ways collide if their bodies, rectangles,
    overlap; lengths of lanes are declared, and need not be those of the picture.
    """
    order = np.lexsort((vehicles.lane_s_m, vehicles.lane))
    behind, ahead = order[:-1], order[1:]
    gap_m = vehicles.lane_s_m[ahead] - vehicles.length_m[ahead] - vehicles.lane_s_m[behind]
    if ((vehicles.lane[ahead] == vehicles.lane[behind]) & (gap_m < 0.0)).any():
        return True
    way = ways[vehicles.lane]
    first, second = np.nonzero((way[:, None] < way[None, :]) & (way[:, None] >= 0))
    return len(first) > 0 and bool(_overlap(vehicles, first, second).any())


def _overlap(vehicles: Vehicles, first: NDArray[np.intp], second: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Returns for pairs of vehicles whether their rectangles overlap: along no axis of either are they apart."""
    centres = np.stack([vehicles.x_m, vehicles.y_m], 1)
    halves = np.stack([vehicles.length_m, vehicles.width_m], 1) / 2.0
    reach_m = np.linalg.norm(halves, axis=1)
    apart = centres[second] - centres[first]
    near = (apart**2).sum(1) < (reach_m[first] + reach_m[second]) ** 2
    if not near.any():
        return near
    first, second, apart = first[near], second[near], apart[near]
    east, north = np.cos(vehicles.yaw_rad), np.sin(vehicles.yaw_rad)
    axes = np.stack([np.stack([east, north], 1), np.stack([-north, east], 1)], 1)
    is_apart = np.zeros(len(first), bool)
    for owner in (first, second):
        for axis in range(2):
            along = axes[owner, axis]
            shadows = [(np.abs(np.einsum("pi,pki->pk", along, axes[one])) * halves[one]).sum(1) for one in (first, second)]
            is_apart |= np.abs((apart * along).sum(1)) > shadows[0] + shadows[1]
    near[near] = ~is_apart
    return near
