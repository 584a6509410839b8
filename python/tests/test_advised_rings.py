"""Tests of several advised vehicles of fast rings, which are rows of one vector environment."""

import copy
import pickle

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box

import codrive_sim

SHORT = {"warm_up_s": 5.0, "horizon_s": 6.0}
#: Numbers of four of 22 vehicles, spread evenly: 5.5 apart, rounded down.
FOUR = [0, 5, 11, 16]


def rings(advised, num_envs=3, **settings):
    return codrive_sim.make_vec("ring-250", num_envs, advised=advised, advice="speed", **{**SHORT, **settings})


def advice(envs, value=0.2):
    return np.full((envs.num_envs, 1), value, np.float32)


def test_agents_of_many_rings_are_rows_ring_after_ring():
    for advised in (4, "4", "20%", 0.2):
        envs = rings(advised, sees="speed,gap")
        assert envs.num_envs == 12 and envs.agents == ["ego", "vehicle_5", "vehicle_11", "vehicle_16"]
        seen, _ = envs.reset(seed=1)
        assert seen.shape == (12, 2)
        assert [list(np.flatnonzero(row)) for row in envs.vehicles.is_advised] == [FOUR] * 3
        # Speeds of 0 to 10 m/s and gaps of 0 to 30 m are -1 to 1. The leader of a vehicle has the number before.
        own_mps = envs.vehicles.speed_mps[:, FOUR]
        assert (seen[:, 0].reshape(3, 4) + 1.0) * 5.0 == pytest.approx(own_mps, abs=1e-5)
        ahead_m = np.roll(envs.vehicles.s_m, 1, axis=1)[:, FOUR] - envs.vehicles.s_m[:, FOUR]
        assert (seen[:, 1].reshape(3, 4) + 1.0) * 15.0 == pytest.approx(np.mod(ahead_m - 5.0, 250.0), abs=1e-3)
        _, rewards, terminations, truncations, infos = envs.step(advice(envs))
        assert all(part.shape == (12,) for part in (rewards, terminations, truncations, infos["mean_speed_mps"]))


def test_one_advised_vehicle_is_the_environment_without_the_setting():
    def driven(**settings):
        envs = codrive_sim.make_vec("ring-250", 20, driver="late", **settings, **SHORT)
        given = [envs.reset(seed=5)[0].tobytes()]
        for k in range(8):
            given += [part.tobytes() for part in envs.step(np.full((20, 1), 0.2 * k - 0.5, np.float32))[:4]]
        return given

    assert driven() == driven(advised=1) == driven(advised="3%")


def test_each_agent_is_moved_by_its_own_action():
    slow, fast = (rings(4, num_envs=1, driver="exact", horizon_s=60.0) for _ in range(2))
    first = [envs.reset(seed=2)[0] for envs in (slow, fast)]
    assert np.array_equal(*first)
    same = np.full((4, 1), -0.6, np.float32)
    other = same.copy()
    other[2] = -0.9
    slow.step(other)
    fast.step(same)
    changed = np.flatnonzero(slow.vehicles.speed_mps[0] < fast.vehicles.speed_mps[0] - 0.5)
    # The vehicle itself brakes at once, those behind it somewhat later.
    assert changed[0] == 11


def test_a_collision_ends_the_ring_for_all_its_agents():
    envs = rings(4, driver="exact", horizon_s=100.0, collision_penalty=50.0, reward="ego")
    envs.reset(seed=1)
    actions = advice(envs, -0.6)
    # vehicle_11 of the second ring: 10 m/s, without a guard.
    actions[4 + 2] = 1.0
    for _ in range(60):
        seen, rewards, terminations, truncations, infos = envs.step(actions)
        if terminations.any():
            break
    assert list(np.flatnonzero(terminations)) == [4, 5, 6, 7] and not truncations.any()
    assert list(np.flatnonzero(rewards < -20.0)) == [6]
    assert list(np.flatnonzero(infos["_final_obs"])) == [4, 5, 6, 7]
    assert all(not np.array_equal(infos["final_obs"][row], seen[row]) for row in (4, 5, 6, 7))


def test_a_mask_resets_the_rings_of_its_agents():
    envs = rings(4)
    envs.reset(seed=1)
    envs.step(advice(envs))
    before = envs.vehicles.speed_mps.copy()
    mask = np.zeros(12, np.bool_)
    mask[9] = True
    envs.reset(options={"reset_mask": mask})
    same = [np.array_equal(*pair) for pair in zip(before, envs.vehicles.speed_mps)]
    assert same == [True, True, False]
    with pytest.raises(ValueError, match=r"allowed: bool, \(12,\)"):
        envs.reset(options={"reset_mask": np.zeros(3, np.bool_)})


@pytest.mark.parametrize("how", ["set_state", "pickle", "deepcopy"])
def test_a_state_goes_on_to_the_same_bits(how):
    envs = rings(5, driver="people")
    envs.reset(seed=4)
    for _ in range(3):
        envs.step(advice(envs))
    if how == "set_state":
        other = rings(5, driver="people")
        other.set_state(envs.get_state())
    else:
        other = pickle.loads(pickle.dumps(envs)) if how == "pickle" else copy.deepcopy(envs)
    for _ in range(5):
        one, two = envs.step(advice(envs)), other.step(advice(other))
        assert all(np.array_equal(*pair) for pair in zip(one[:4], two[:4]))
    with pytest.raises(ValueError, match="another advised"):
        rings(4, driver="people").set_state(envs.get_state())


def test_own_rewards_and_observations_are_of_agents():
    def own_speeds(moment):
        assert moment.agents == ["ego", "vehicle_11"] and list(moment.cars) == [0, 11]
        return moment.vehicles.speed_mps[:, moment.cars].reshape(-1, 1)

    def gained(hold):
        return (own_speeds(hold.after) - own_speeds(hold.before))[:, 0]

    settings = {"driver": "exact", "horizon_s": 60.0}
    envs = rings(2, observation=own_speeds, observation_space=Box(0.0, np.inf, (1,), np.float32), reward=gained, **settings)
    # The same rings with observations of the settings: speeds of 0 to 10 m/s are -1 to 1.
    plain = rings(2, sees="speed", **settings)
    before, _ = envs.reset(seed=1)
    assert before.shape == (6, 1) and before == pytest.approx((plain.reset(seed=1)[0] + 1.0) * 5.0, abs=1e-5)
    # The second vehicle of the second ring runs into its leader, the others hardly move.
    actions = advice(envs, -0.8)
    actions[3] = 1.0
    for _ in range(60):
        seen, rewards, terminations, _, infos = envs.step(actions)
        expected, _, _, _, plain_infos = plain.step(actions)
        last = (expected + 1.0) * 5.0
        assert seen == pytest.approx(last, abs=1e-5)
        if terminations.any():
            ended = np.flatnonzero(terminations)
            last[ended] = (np.stack(list(plain_infos["final_obs"][ended])) + 1.0) * 5.0
            assert np.stack(list(infos["final_obs"][ended])) == pytest.approx(last[ended], abs=1e-5)
        assert rewards == pytest.approx((last - before)[:, 0], abs=1e-4)
        if terminations.any():
            break
        before = seen
    assert list(ended) == [2, 3]


@pytest.mark.parametrize(
    ("settings", "error", "words"),
    [
        ({"advised": 0}, ValueError, "advised is 0; allowed: 1 to 22"),
        ({"advised": 23}, ValueError, "advised is 23; allowed: 1 to 22, as many as there are vehicles, or a share such as 20%"),
        ({"advised": "half"}, ValueError, 'advised is "half"; allowed: a share'),
        ({"advised": True}, TypeError, "advised is True; allowed: a number of vehicles, or a share"),
        ({"advised": 4, "vehicles_min": 18}, ValueError, "advised is 4; allowed: 1, as rings have 18 to 22 vehicles"),
    ],
)
def test_wrong_numbers_of_advised_vehicles_are_refused(settings, error, words):
    with pytest.raises(error, match=words):
        codrive_sim.make_vec("ring-250", 2, **settings)


def test_a_single_environment_has_one_agent():
    with pytest.raises(ValueError, match="advised is '4'; allowed: 1, the ego; codrive_sim.make_vec has several"):
        codrive_sim.make("ring-250", advised=4)
    assert codrive_sim.make("ring-250", advised=1, **SHORT).reset(seed=1)[0].shape == (4,)


def test_an_evaluation_asks_for_every_agent():
    asked = {"over": 3, "hold": 1.0, "warm_up_s": 5.0, "horizon_s": 20.0, "advice": "speed", "driver": "exact"}

    def four(seen):
        assert seen.shape == (12, 4)
        return np.full(12, -0.5, np.float32)

    own = codrive_sim.evaluate(four, advised=4, **asked)
    named = codrive_sim.evaluate("constant", policy_speed=2.5, advised=4, **asked)
    assert list(own.mean_speed_mps) == list(named.mean_speed_mps)
    assert list(own.advised_vehicles) == [4] * 3 and own.advised_share[0] == pytest.approx(4 / 22)
    one = codrive_sim.evaluate("constant", policy_speed=2.5, **asked)
    assert list(one.advised_vehicles) == [1] * 3 and list(one.mean_speed_mps) != list(own.mean_speed_mps)


def test_gymnasium_takes_the_setting_by_id():
    envs = gymnasium.make_vec("codrive/Ring250-v0", num_envs=2, vectorization_mode="vector_entry_point", advised="100%", **SHORT)
    assert envs.reset(seed=1)[0].shape == (44, 4)
    envs.close()
