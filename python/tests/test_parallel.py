"""Tests of several advised vehicles as agents of PettingZoo."""

import pathlib
import pickle
import re
import sys
import warnings

import gymnasium
import numpy as np
import pytest
from pettingzoo import ParallelEnv
from pettingzoo.test import parallel_api_test, parallel_seed_test

import codrive_sim

NETWORKS = pathlib.Path(__file__).parents[2] / "tests/data/networks"
SHORT = {"warm_up_s": 2.0, "horizon_s": 6.0}


def ring(**arguments):
    return codrive_sim.make_parallel("ring-250", **{"advised": 4, "traffic": "native", **SHORT, **arguments})


def still(env):
    return {agent: np.zeros(1, np.float32) for agent in env.agents}


@pytest.mark.parametrize("traffic", ["native", "sumo"])
def test_pettingzoos_own_tests_pass(traffic, capsys):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = ring(traffic=traffic)
        parallel_api_test(env, num_cycles=20)
        parallel_api_test(ring(traffic=traffic, levels=3), num_cycles=20)
        env.close()
    assert capsys.readouterr().out.count("Passed") == 2


def test_agents_environments_are_pickled_as_their_arguments():
    env = ring()
    seen, _ = env.reset(seed=3)
    other = pickle.loads(pickle.dumps(env))
    again, _ = other.reset(seed=3)
    assert list(again) == list(seen) and all(np.array_equal(again[agent], seen[agent]) for agent in seen)
    other.close()
    env.close()


def test_a_seed_makes_the_same_drive_for_pettingzoo_too():
    parallel_seed_test(ring)


def test_agents_of_a_ring_are_known_before():
    env = ring()
    assert isinstance(env, ParallelEnv) and env.agents == []
    # Every fifth or sixth of 22 vehicles: floor(22 k / 4).
    assert env.possible_agents == ["ego", "vehicle_5", "vehicle_11", "vehicle_16"]
    observations, infos = env.reset(seed=1)
    assert list(observations) == env.agents == env.possible_agents and infos == {agent: {} for agent in env.agents}
    for agent in env.agents:
        assert observations[agent] in env.observation_space(agent)
        assert env.action_space(agent) is env.action_space(agent)
    with pytest.raises(ValueError, match=r"no agent 'vehicle_111' \(did you mean vehicle_11\?\)"):
        env.action_space("vehicle_111")
    # A share refers to all vehicles: 9.1 % of 22 are 2.
    assert ring(advised="9.1%").possible_agents == ["ego", "vehicle_11"]
    assert ring(advised=0.091).possible_agents == ["ego", "vehicle_11"]


def test_an_agent_alone_is_the_environment_of_one():
    alone, one = ring(advised=1), codrive_sim.make("ring-250", traffic="native", **SHORT)
    assert np.array_equal(alone.reset(seed=4)[0]["ego"], one.reset(seed=4)[0])
    while alone.agents:
        observations, rewards, terminations, truncations, infos = alone.step({"ego": np.full(1, 0.5)})
        seen, reward, terminated, truncated, info = one.step(np.full(1, 0.5))
        assert np.array_equal(observations["ego"], seen) and infos["ego"] == info
        assert (rewards["ego"], terminations["ego"], truncations["ego"]) == (reward, terminated, truncated)
    assert truncated and alone.fingerprint() == one.fingerprint()
    assert np.array_equal(alone.reset()[0]["ego"], one.reset()[0])


@pytest.mark.parametrize(("slow", "fast"), [("ego", "vehicle_11"), ("vehicle_11", "ego")])
def test_each_agent_follows_its_own_action(slow, fast):
    # -1 is an advised speed of 0. From evenly spaced vehicles at rest, the agent with that advice stays and the other drives.
    env = ring(advised=2, advice="speed", start="even", warm_up_s=0.0, horizon_s=20.0)
    assert env.inputs[0] == ("speed", 0.0, 10.0)
    env.reset(seed=2)
    for _ in range(8):
        observations = env.step({slow: -np.ones(1), fast: np.ones(1)})[0]
    speeds_mps = {agent: 5.0 * (seen[0] + 1.0) for agent, seen in observations.items()}
    assert speeds_mps[slow] < 0.5 < 1.0 < speeds_mps[fast]


def test_all_end_at_the_horizon():
    env = ring()
    env.reset(seed=1)
    for hold in range(1, 7):
        _, rewards, terminations, truncations, _ = env.step(still(env))
        assert len(rewards) == 4 and not any(terminations.values())
        assert list(truncations.values()) == [hold == 6] * 4
    assert env.agents == []
    with pytest.raises(gymnasium.error.ResetNeeded, match="has ended"):
        env.step({})


def test_agents_come_and_go_on_a_network():
    env = codrive_sim.make_parallel("merge", advised="30%", participant=False, horizon_s=120.0)
    assert not hasattr(env, "possible_agents")
    observations, _ = env.reset(seed=1)
    gone, seen_once = set(), set(env.agents)
    assert set(observations) == seen_once
    while env.agents:
        before = set(env.agents)
        given = env.step(still(env))
        observations, rewards, terminations, truncations, infos = given
        came = set(env.agents) - before
        assert all(set(part) == before | came for part in given)
        assert set(env.agents) == {agent for agent in before if not (terminations[agent] or truncations[agent])} | came
        assert all(rewards[agent] == 0.0 and not terminations[agent] for agent in came)
        assert not came & (gone | seen_once), "nobody comes twice"
        gone |= before - set(env.agents)
        seen_once |= came
        for agent in env.agents:
            assert observations[agent] in env.observation_space(agent)
    assert len(seen_once) > 5 and any(truncations.values())


def test_pettingzoos_own_test_passes_on_a_network():
    flows = [{"from": start, "to": end, "per_hour": 400.0} for start, end in (("A0B0", "B2C2"), ("C2C1", "A1A0"), ("A2A1", "C0B0"))]
    env = codrive_sim.make_parallel(str(NETWORKS / "grid-signals.net.xml"), advised="30%", demand={"flows": flows}, horizon_s=60.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # The test expects a list of all agents; without one, it reports the end of each episode.
        warnings.filterwarnings("ignore", message="This environment does not have possible_agents")
        warnings.filterwarnings("ignore", message="No agents present")
        parallel_api_test(env, num_cycles=100)


@pytest.mark.parametrize(
    ("actions", "error", "words"),
    [
        ([0.0, 0.0], TypeError, "actions are list; allowed: a dict"),
        (None, TypeError, "actions are NoneType"),
        ({"ego": np.zeros(1)}, ValueError, "no entry for 'vehicle_11'"),
        ({"ego": 0, "vehicle_11": 0, "vehicle_12": 0}, ValueError, r"'vehicle_12' \(did you mean vehicle_11\?\), which is not among"),
        ({"ego": np.zeros(1), "vehicle_11": np.zeros(2)}, ValueError, r"of 'vehicle_11' have shape \(2,\); allowed: \(1,\)"),
        ({"ego": np.zeros(1), "vehicle_11": np.array([np.nan])}, ValueError, "action of 'vehicle_11' is NaN"),
        ({"ego": np.array([np.inf]), "vehicle_11": np.zeros(1)}, ValueError, "action of 'ego' is inf"),
        ({"ego": "fast", "vehicle_11": np.zeros(1)}, TypeError, "dtype <U4"),
    ],
)
def test_actions_that_cannot_be(actions, error, words):
    env, again = ring(advised=2), ring(advised=2)
    for one in (env, again):
        one.reset(seed=1)
    with pytest.raises(error, match=words):
        env.step(actions)
    # It goes on as if nothing had been asked.
    env.step(still(env)), again.step(still(again))
    assert env.fingerprint() == again.fingerprint()


@pytest.mark.parametrize(
    ("advised", "error"),
    [(None, TypeError), (True, TypeError), ([2], TypeError), ("many", ValueError), (0, ValueError), (-1, ValueError), (np.nan, ValueError)],
)
def test_shares_that_cannot_be(advised, error):
    with pytest.raises(error, match=f"advised is .*{re.escape(str(advised))}"):
        ring(advised=advised)


def test_the_fast_ring_advises_one_and_says_which_engine_advises_several():
    with pytest.raises(ValueError, match="traffic is 'ring'; allowed: native, sumo.*codrive_sim.make_vec"):
        ring(traffic="ring")


def test_a_step_comes_after_a_reset_and_nothing_after_the_end():
    env = ring()
    with pytest.raises(gymnasium.error.ResetNeeded, match="reset"):
        env.step({})
    env.close()
    env.close()
    for call in (env.reset, lambda: env.step({})):
        with pytest.raises(gymnasium.error.ClosedEnvironmentError, match="make another"):
            call()


def test_without_pettingzoo_it_is_said_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pettingzoo", None)
    monkeypatch.delitem(sys.modules, "codrive_sim._parallel", raising=False)
    with pytest.raises(ImportError, match="pip install pettingzoo"):
        ring()


@pytest.mark.parametrize("participant", [True, False])
def test_agents_of_many_drives_are_rows_of_one_vector(participant):
    settings = {"advised": 3, "traffic": "native", "participant": participant, **SHORT}
    envs = codrive_sim.make_vec("ring-250", num_envs=2, **settings)
    singles = [codrive_sim.make_parallel("ring-250", **settings) for _ in range(2)]
    assert envs.num_envs == 6 and envs.agents == singles[0].possible_agents
    seen, _ = envs.reset(seed=4)
    own = [single.reset(seed=4 + number)[0] for number, single in enumerate(singles)]
    assert np.array_equal(seen, [row[agent] for row in own for agent in envs.agents])
    for hold in range(6):
        actions = np.linspace(-1.0, 1.0, 6, dtype=np.float32).reshape(6, 1)
        seen, rewards, terminations, truncations, infos = envs.step(actions)
        for number, single in enumerate(singles):
            rows = slice(3 * number, 3 * number + 3)
            one = single.step(dict(zip(envs.agents, actions[rows])))
            seen_at_end = infos["final_obs"] if truncations.all() else seen
            assert np.array_equal(np.stack(list(seen_at_end[rows])), [one[0][agent] for agent in envs.agents])
            assert np.array_equal(rewards[rows], list(one[1].values())) and np.array_equal(truncations[rows], list(one[3].values()))
            assert (infos["mean_speed_mps"][rows] == one[4][envs.agents[0]]["mean_speed_mps"]).all()
        assert not terminations.any() and truncations.all() == (hold == 5)
    envs.close()


def test_agents_of_a_network_are_no_rows():
    with pytest.raises(ValueError, match="advised is '20%'; allowed: 1 on a network(?s:.*)make_parallel"):
        codrive_sim.make_vec("merge", num_envs=2, advised="20%")
