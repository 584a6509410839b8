"""Tests of what environments show of their traffic, of orders to it, of the user's own rewards and observations, and of states."""

import copy
import pathlib
import pickle

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box, MultiDiscrete

import codrive_sim
from codrive_sim._bench_drives import MergeTraffic
from codrive_sim._traffic_env import Timing

NETWORKS = pathlib.Path(__file__).parents[2] / "tests/data/networks"
GRID = str(NETWORKS / "grid-signals.net.xml")
#: Two flows that cross the grid of 3 by 3 streets with two lanes each.
FLOWS = {"flows": [{"from": "A1B1", "to": "B1C1", "per_hour": 900.0}, {"from": "B2B1", "to": "B1B0", "per_hour": 600.0}]}
SHORT = {"warm_up_s": 2.0, "horizon_s": 6.0}


def native(**arguments):
    return codrive_sim.make("ring-250", **{"traffic": "native", **SHORT, **arguments})


def grid(**arguments):
    settings = {"advised": "100%", "participant": False, "demand": FLOWS, "horizon_s": 60.0, "warm_up_s": 10.0}
    return codrive_sim.make_parallel(GRID, **{**settings, **arguments})


def still(env):
    return {agent: np.zeros(env.action_space(agent).shape, np.float32) for agent in env.agents}


def gaps_m(vehicles, length_m):
    """Returns the gaps of vehicles on a ring from bumper to bumper, the last axis in the order of the road."""
    s_m = np.sort(vehicles.s_m, axis=-1)
    ahead_m = np.concatenate([s_m[..., 1:], s_m[..., :1] + length_m], axis=-1)
    return ahead_m - s_m - vehicles.length_m


@pytest.mark.parametrize("kind", ["drive", "ring"])
def test_columns_have_all_vehicles_of_a_ring(kind):
    env = native(hold=0.1) if kind == "drive" else codrive_sim.make("ring-250", hold=0.1, **SHORT)
    env.reset(seed=3)
    for _ in range(30):
        info = env.step(np.ones(1, np.float32))[4]
    vehicles = env.vehicles
    assert sorted(vehicles.car) == list(range(22)) and list(vehicles.car[vehicles.is_advised]) == [0]
    # A hold of one step: the mean over it is that of the speeds at its end, in the single precision of the fast ring.
    assert vehicles.speed_mps.mean() == pytest.approx(info["mean_speed_mps"], abs=1e-5)
    # All vehicles and gaps together are the road.
    length_m = 250.0 if kind == "drive" else 2 * np.pi * np.hypot(vehicles.x_m, vehicles.y_m)[0]
    assert (gaps_m(vehicles, length_m) > 0).all()
    assert gaps_m(vehicles, length_m).sum() + vehicles.length_m.sum() == pytest.approx(length_m, abs=1e-3)
    # Neighbours are as far apart in the plane as along the road, but for the bend: within 10 % of a chord of up to 40 m.
    order = np.argsort(vehicles.s_m)
    plane_m = np.hypot(np.diff(vehicles.x_m[order]), np.diff(vehicles.y_m[order]))
    road_m = np.diff(vehicles.s_m[order])
    near = road_m < 40.0
    assert near.sum() > 15 and np.allclose(plane_m[near], road_m[near], rtol=0.1)
    env.close()


def test_columns_of_many_rings_are_those_of_each_ring():
    envs = codrive_sim.make_vec("ring-250", num_envs=17, vehicles_min=20, vehicles_max=22, **SHORT)
    envs.reset(seed=1)
    envs.step(np.zeros((17, 1), np.float32))
    vehicles = envs.vehicles
    assert vehicles.speed_mps.shape == (17, 22) and vehicles.is_advised.sum() == 17
    counts = (vehicles.lane >= 0).sum(axis=1)
    assert set(counts) == {20, 21, 22} and np.isnan(vehicles.s_m).sum() == (22 - counts).sum()


def test_the_ego_of_columns_is_that_of_the_observation():
    env = native()
    seen, _ = env.reset(seed=2)
    inputs = [name for name, *_ in env.inputs]
    _, low, high = env.inputs[inputs.index("speed")]
    speed_mps = low + (seen[inputs.index("speed")] + 1) / 2 * (high - low)
    vehicles = env.vehicles
    assert vehicles.speed_mps[0] == pytest.approx(speed_mps, abs=1e-5) and vehicles.rows([0, 5, 99]).tolist() == [0, 5, -1]
    assert env.time_s == 0.0 and env.signals == {} and [lane.width_m > 2 for lane in env.lanes] == [True] * len(env.lanes)


def test_infos_have_the_measures_of_the_hold():
    env = native(hold=0.1)
    env.reset(seed=5)
    before = env.vehicles.speed_mps
    info = env.step(np.zeros(1, np.float32))[4]
    now = env.vehicles.speed_mps
    assert info["mean_speed_mps"] == pytest.approx(now.mean(), abs=1e-9) and info["time_s"] == pytest.approx(0.1)
    assert info["speed_sd_over_vehicles_mps"] == pytest.approx(now.std(), abs=1e-6)
    # One step of each vehicle has no deviation over time, nobody comes or goes.
    assert (info["speed_sd_over_time_mps"], info["inflow_per_h"], info["outflow_per_h"], info["vehicles_present"]) == (0, 0, 0, 22)
    assert info["fuel_l_100km"] > 0 and not np.array_equal(before, now)


def test_rewards_by_weights_and_functions_replace_the_settings():
    plain, weighted = native(), native(reward={"mean_speed_mps": 2.0, "speed_sd_over_vehicles_mps": -1.0})
    by_name, by_function = native(reward="vehicles_present"), native(reward=lambda hold: hold.after.vehicles.speed_mps.min())
    envs = [plain, weighted, by_name, by_function]
    [env.reset(seed=1) for env in envs]
    for _ in range(3):
        _, reward, _, _, info = plain.step(np.ones(1, np.float32))
        assert reward == info["mean_speed_mps"]
        two = 2 * info["mean_speed_mps"] - info["speed_sd_over_vehicles_mps"]
        given = [env.step(np.ones(1, np.float32))[1] for env in envs[1:]]
        assert given == pytest.approx([two, 22.0, by_function.vehicles.speed_mps.min()])


def test_an_own_observation_is_seen_from_reset_to_the_last_hold():
    space = Box(0.0, np.inf, (2,), np.float32)

    def two(moment):
        assert moment.agents == ["ego"] and moment.observations.shape[0] == 1
        return [[moment.vehicles.speed_mps.mean(), moment.time_s]]

    env = native(observation=two, observation_space=space)
    assert env.observation_space is space
    seen, _ = env.reset(seed=1)
    assert seen.dtype == np.float32 and seen[1] == 0.0
    for hold in range(1, 7):
        seen, _, _, truncated, _ = env.step(np.zeros(1, np.float32))
        assert seen == pytest.approx([env.vehicles.speed_mps.mean(), hold], rel=1e-6)
    assert truncated


def test_many_rings_and_drives_take_the_same_functions():
    space = Box(0.0, np.inf, (1,), np.float32)

    def slowest(moment):
        return moment.vehicles.speed_mps.min(axis=-1).reshape(-1, 1)

    def spread(hold):
        return -hold.after.vehicles.speed_mps.std(axis=-1)

    own = {"reward": spread, "observation": slowest, "observation_space": space, **SHORT}
    for envs in (codrive_sim.make_vec("ring-250", num_envs=3, **own), codrive_sim.make_vec("ring-250", num_envs=3, traffic="native", **own)):
        seen, _ = envs.reset(seed=1)
        assert seen.shape == (3, 1)
        for _ in range(6):
            columns = envs.vehicles if isinstance(envs.vehicles, tuple) and not hasattr(envs.vehicles, "car") else None
            seen, rewards, _, truncations, infos = envs.step(np.zeros((3, 1), np.float32))
            now = envs.vehicles
            speeds = now.speed_mps if columns is None else np.array([one.speed_mps for one in now])
            assert seen[:, 0] == pytest.approx(speeds.min(axis=-1), rel=1e-6)
            if not truncations.any():
                assert rewards == pytest.approx(-speeds.std(axis=-1), rel=1e-6)
        # The last hold is of the old episode, the observation of the new one.
        assert truncations.all() and infos["final_obs"][0] != seen[0]
        envs.close()


def test_a_last_reward_is_of_the_episode_that_has_ended():
    one, many = native(reward=lambda hold: hold.after.vehicles.speed_mps.max()), codrive_sim.make_vec(
        "ring-250", num_envs=2, traffic="native", reward=lambda hold: hold.after.vehicles.speed_mps.max(), **SHORT
    )
    one.reset(seed=1)
    many.reset(seed=1)
    for _ in range(6):
        reward, rewards = one.step(np.ones(1, np.float32))[1], many.step(np.ones((2, 1), np.float32))[1]
        assert reward == rewards[0]
    many.close()
    ring = codrive_sim.make_vec("ring-250", num_envs=2, reward=lambda hold: np.nanmax(hold.after.vehicles.speed_mps, axis=-1), **SHORT)
    ring.reset(seed=1)
    given = [ring.step(np.ones((2, 1), np.float32))[1].copy() for _ in range(6)]
    # A new ring after 2 s from a standstill is slower than one after 8 s.
    assert (given[5] > given[4] - 0.5).all() and np.nanmax(ring.vehicles.speed_mps) < given[5].min()


def test_wrong_functions_are_refused_by_name():
    with pytest.raises(ValueError, match=r"reward names 'mean_speed' \(did you mean mean_speed_mps\?\)"):
        native(reward="mean_speed")
    with pytest.raises(ValueError, match="weight of stops_per_km is nan"):
        native(reward={"stops_per_km": float("nan")})
    with pytest.raises(TypeError, match="reward is 3"):
        native(reward=3)
    with pytest.raises(TypeError, match="belong together"):
        native(observation=lambda moment: [])
    with pytest.raises(ValueError, match="allowed: all, ego, mean_speed_mps, or a function"):
        codrive_sim.make("ring-250", reward="fuel_l_100km")
    env = native(reward=lambda hold: [1.0, 2.0])
    env.reset(seed=1)
    with pytest.raises(ValueError, match=r"reward returned shape \(2,\); allowed: \(1,\)"):
        env.step(np.zeros(1, np.float32))
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step(np.zeros(1, np.float32))
    with pytest.raises(gymnasium.error.ResetNeeded):
        native().vehicles


def test_signals_show_what_they_are_ordered_to():
    env = grid()
    env.reset(seed=1)
    signal, letters = next((name, letters) for name, letters in env.signals.items() if len(letters) > 4)
    for shown in ("r", "G"):
        env.set_signal(signal, shown * len(letters))
        env.step(still(env))
        assert env.signals[signal] == shown * len(letters)
    env.set_signal(signal, 0)
    env.step(still(env))
    assert env.signals[signal] != "G" * len(letters)
    with pytest.raises(ValueError, match=f"a signal with {len(letters)} links takes as many letters"):
        env.set_signal(signal, "r")
    with pytest.raises(ValueError, match='no signal is called "Z9"'):
        env.set_signal("Z9", 0)
    # What was refused has changed nothing: the drive goes on.
    env.step(still(env))
    env.close()


def test_red_signals_stop_all_traffic():
    env = grid(advice="speed")
    env.reset(seed=1)
    for name, letters in env.signals.items():
        env.set_signal(name, "r" * len(letters))
    for _ in range(49):
        env.step({agent: np.ones(1, np.float32) for agent in env.agents})
    # Vehicles that had passed the line are gone; the first of those that came stand before it.
    lanes = [lane.id for lane in env.lanes]
    assert {lanes[lane][:4] for lane in env.vehicles.lane} == {"A1B1", "B2B1"} and (env.vehicles.speed_mps == 0).sum() > 1
    env.close()


def test_a_vehicle_takes_the_route_it_is_ordered_to():
    env = grid(advice="speed")
    env.reset(seed=1)
    lanes = [lane.id for lane in env.lanes]
    while not (env.agents and any(lanes[lane].startswith("A1B1") for lane in env.vehicles.lane)):
        env.step(still(env))
    row = next(row for row, lane in enumerate(env.vehicles.lane) if lanes[lane].startswith("A1B1"))
    car = int(env.vehicles.car[row])
    with pytest.raises(ValueError):
        env.set_route(car, ["A1B1", "C1C2"])
    env.set_route(f"vehicle_{car}", ["A1B1", "B1B2"])
    seen = set()
    while f"vehicle_{car}" in env.agents:
        seen.add(lanes[env.vehicles.lane[env.vehicles.rows([car])[0]]].rsplit("_", 1)[0])
        env.step({agent: np.ones(1, np.float32) for agent in env.agents})
    assert "B1B2" in seen and "B1C1" not in seen
    with pytest.raises(ValueError, match="vehicle_x"):
        env.set_route("vehicle_x", ["A1B1"])
    env.close()


def test_vehicles_of_the_traffic_take_orders_for_their_speeds():
    env = grid(advised="1%", warm_up_s=0.0)
    env.reset(seed=3)
    while True:
        advised = env.vehicles.is_advised
        free = env.vehicles.car[~advised & (env.vehicles.speed_mps > 6.0) & ~(env.leaders(60.0).gap_m < 60.0)]
        if len(free) >= 2:
            break
        env.step(still(env))
    slowed, limited = (int(car) for car in free[:2])
    speed = env.vehicles.speed_mps[env.vehicles.rows([slowed, limited])]
    # A hold is one second. The driver of the traffic brakes by 1.5 m/s2 at most.
    env.set_speed(slowed, float(speed[0]) - 1.0, within_s=1.0)
    env.set_max_speed(limited, float(speed[1]) - 1.0)
    env.step(still(env))
    after = env.vehicles.speed_mps[env.vehicles.rows([slowed, limited])]
    assert after == pytest.approx(speed - [1.0, 1.0], abs=0.05)
    (name, kind), *_ = env.names([slowed])
    assert name.startswith("flow") and kind == "codrive.car"
    for wrong, message in (
        (lambda: env.set_speed(slowed, -1.0), "speed_mps is -1.0; allowed: 0 or more"),
        (lambda: env.set_speed_mode(slowed, 64), "mode is 64; allowed: a whole number from 0 to 63"),
        (lambda: env.set_speed(int(env.vehicles.car[advised][0]) if advised.any() else 10**6, 1.0), "is advised|no longer there"),
        (lambda: env.leaders(0.0), "reach_m is 0.0; allowed: above 0"),
    ):
        with pytest.raises(ValueError, match=message):
            wrong()
    env.close()


def test_leaders_are_the_next_vehicles_of_a_lane():
    flows = [{**flow, "per_hour": 2400.0} for flow in FLOWS["flows"]]
    env = grid(advice="speed", demand={"flows": flows})
    env.reset(seed=1)
    for name, letters in env.signals.items():
        env.set_signal(name, "r" * len(letters))
    for _ in range(40):
        env.step({agent: np.ones(1, np.float32) for agent in env.agents})
    vehicles, leaders = env.vehicles, env.leaders()
    order = np.lexsort((vehicles.lane_s_m, vehicles.lane))
    pairs = [(one, other) for one, other in zip(order, order[1:]) if vehicles.lane[one] == vehicles.lane[other]]
    assert len(pairs) >= 2
    for behind, ahead in pairs:
        gap_m = vehicles.lane_s_m[ahead] - vehicles.length_m[ahead] - vehicles.lane_s_m[behind]
        assert leaders.car[behind] == vehicles.car[ahead] and leaders.gap_m[behind] == pytest.approx(gap_m, abs=1e-6)
    env.close()


def test_agents_change_lanes_by_their_actions():
    env = grid(advice="speed", lane_changes=True, warm_up_s=0.0)
    assert env.action_space("any") == Box(-1.0, 1.0, (2,), np.float32)
    for side, index in ((1.0, "1"), (-1.0, "0")):
        env.reset(seed=1)
        while not env.agents:
            env.step({})
        agent = env.agents[0]
        for _ in range(8):
            env.step({one: np.array([0.0, side if one == agent else 0.0], np.float32) for one in env.agents})
        lanes = [lane.id for lane in env.lanes]
        assert lanes[env.vehicles.lane[env.vehicles.rows([int(agent.removeprefix("vehicle_"))])[0]]].endswith(index)
    env.close()
    assert grid(levels=5, lane_changes=True).action_space("any") == MultiDiscrete([5, 3])
    with pytest.raises(ValueError, match="participant=False"):
        grid(lane_changes=True, participant=True)
    with pytest.raises(ValueError, match="a closed route is one lane"):
        codrive_sim.make_parallel("ring-250", advised=2, lane_changes=True)
    with pytest.raises(ValueError, match="advised_body='light'"):
        grid(lane_changes=True, advised_body="full")


def test_orders_without_traffic_that_takes_them_are_refused():
    env = native()
    env.reset(seed=1)
    with pytest.raises(ValueError, match="the native engine takes no orders"):
        env.change_lane(5, 1)
    with pytest.raises(ValueError, match="full body"):
        env.change_lane("ego", 1)
    env.step(np.zeros(1, np.float32))


@pytest.mark.parametrize("how", ["set_state", "pickle", "deepcopy"])
@pytest.mark.parametrize("kind", ["ring", "rings", "native", "natives", "agents"])
def test_a_state_goes_on_to_the_same_bits(kind, how):
    make = {
        "ring": lambda: codrive_sim.make("ring-250", driver="late", **SHORT),
        "rings": lambda: codrive_sim.make_vec("ring-250", num_envs=3, driver="late", **SHORT),
        "native": lambda: native(driver="late"),
        "natives": lambda: codrive_sim.make_vec("ring-250", num_envs=2, traffic="native", driver="late", **SHORT),
        "agents": lambda: grid(horizon_s=30.0, lane_changes=True),
    }[kind]

    def actions(env):
        if kind == "agents":
            return {agent: np.array([0.3, 1.0], np.float32) for agent in env.agents}
        return np.full(env.action_space.shape, 0.3, np.float32)

    env = make()
    env.reset(seed=4)
    for _ in range(3):
        env.step(actions(env))
    if kind == "agents":
        env.set_signal(next(iter(env.signals)), 0)
    # SUMO runs once in a process; each environment has its own.
    if how == "set_state":
        other = make()
        other.set_state(env.get_state())
    else:
        other = pickle.loads(pickle.dumps(env)) if how == "pickle" else copy.deepcopy(env)
    for _ in range(5):
        one, two = env.step(actions(env)), other.step(actions(other))
        assert str(one) == str(two)
        if kind in ("ring", "native") and (one[2] or one[3]):
            assert str(env.reset()) == str(other.reset())
    env.close()
    other.close()


def test_a_state_of_other_settings_is_refused():
    env, other = native(), native(horizon_s=7.0)
    env.reset(seed=1)
    with pytest.raises(ValueError, match="another horizon_s"):
        other.set_state(env.get_state())
    with pytest.raises(ValueError, match="no state of a drive"):
        other.set_state({})
    with pytest.raises(gymnasium.error.ResetNeeded):
        other.get_state()


def test_vehicles_ahead_are_looked_up_only_when_they_are_asked_for():
    env = MergeTraffic(Timing(0.5, 1, 60, 20))
    env.reset(seed=1)
    told, call = [], env._series._drive.call

    def noting(name, *arguments):
        # The names of new vehicles are asked for as they come.
        if name != "names":
            told.append((name, *[one for one in arguments if isinstance(one, float)]))
        return call(name, *arguments)

    env._series._drive.call = noting
    for _ in range(5):
        env.step(0)
    assert told == [("traffic_step",)] * 5
    told.clear()
    vehicles, leaders = env.now
    assert told == [("leaders", env.reach_m)] and len(leaders.car) == len(vehicles.car) > 10
    told.clear()
    env.step(0)
    gap_m = env.now.leaders.gap_m
    # After they were asked for, they come with the next step, in one message.
    assert told == [("traffic_step", env.reach_m)]
    assert gap_m.tobytes() == env.leaders(env.reach_m).gap_m.tobytes()
    env.close()
