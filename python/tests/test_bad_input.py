"""Tests that invalid calls raise Python's own exceptions, with the allowed values; nothing ends the interpreter."""

import gymnasium
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import codrive_sim
from codrive_sim._codrive import Configuration, Rings

SHORT = {"warm_up_s": 1.0, "horizon_s": 3.0}


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"name": "ring-25"}, ValueError, r"ring-25.*did you mean .*ring-250"),
        ({"name": 3}, TypeError, "name is 3"),
        ({"name": "ring-25", "traffic": "ring"}, ValueError, r"no ring \"ring-25\" \(did you mean ring-250\?\); allowed: ring-250, ring-641"),
        ({"name": "merge", "traffic": "ring"}, ValueError, r"no ring \"merge\"(?s:.*)remedy: traffic='sumo' drives other maps"),
        ({"name": "no-such-map"}, ValueError, r"remedy: name one of these(?s:.*)the program codrive has this command: scripts/drive of a checkout builds it"),
        ({"hodl": 1.0}, TypeError, "unknown key `hodl`; did you mean `hold`"),
        ({"num_env": 4}, TypeError, "unknown key `num_env`; did you mean `num_envs`"),
        ({"view": "birdseye"}, ValueError, "view is 'birdseye'; allowed: schematic; traffic='native' and"),
        ({"advised": 23}, ValueError, "advised is 23; allowed: 1 to 22, as many as there are vehicles"),
        ({"name": "no-such.toml"}, ValueError, "no-such.toml: cannot be read"),
        ({"driver": "slopy"}, ValueError, r"\"slopy\" \(did you mean sloppy\?\)"),
        ({"driver": "reaction=soon"}, ValueError, "reaction is \"soon\""),
        ({"driver": 1}, TypeError, "driver is 1"),
        ({"traffic": "rings"}, ValueError, r"traffic is 'rings' \(did you mean ring\?\)"),
        ({"hold": 0.25}, ValueError, "^hold is 0.25; allowed: a whole number"),
        ({"hold_s": 0.25}, ValueError, "^hold_s is 0.25; allowed: a whole number"),
        ({"hold": -1}, ValueError, "^hold is -1"),
        ({"hold": float("nan")}, ValueError, "^hold is not a finite number"),
        ({"hold": 1.0, "hold_s": 1.0}, TypeError, "hold and hold_s are the same setting"),
        ({"advice": "sped"}, ValueError, r'^advice is "sped" \(did you mean speed\?\); allowed: one of acceleration, speed'),
        ({"action": "sped"}, ValueError, r'^action is "sped" \(did you mean speed\?\); allowed: one of acceleration, speed'),
        ({"vehicles_max": 500}, ValueError, "vehicles_max is 500; allowed: a whole number from 2 to 200"),
        ({"vehicles_max": 22.5}, ValueError, "vehicles_max is 22.5"),
        ({"vehicles_max": "many"}, ValueError, "vehicles_max is \"many\""),
        ({"vehicles_max": [1]}, TypeError, r"vehicles_max is \[1\]"),
        ({"vehicle_max": 22}, TypeError, "unknown key `vehicle_max`; did you mean `vehicles_max`"),
        ({"idm": {"v1": 3}}, TypeError, "unknown key `idm.v1`"),
        ({"idm": 3}, TypeError, "unknown key `idm`"),
        ({"sees": "sped"}, ValueError, r"sees names `sped` \(did you mean speed\?\)"),
        ({"sees": ""}, ValueError, "sees"),
        ({"traffic": "sumoo"}, ValueError, r"traffic is 'sumoo' \(did you mean sumo\?\); allowed: ring, native, sumo"),
        ({"traffic": ["sumo"]}, ValueError, r"traffic is \['sumo'\]"),
        ({"render_mode": "ansi"}, ValueError, "render_mode is 'ansi'; allowed: None, 'rgb_array'"),
        ({"seed": -1}, ValueError, "seed is -1"),
    ],
)
def test_what_make_refuses(arguments, error, words):
    for make in (codrive_sim.make, codrive_sim.make_vec):
        with pytest.raises(error, match=words):
            make(**arguments)


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"name": "ring-25"}, ValueError, "ring-25.*did you mean .*ring-250"),
        ({"name": 3}, TypeError, "name is 3"),
        ({"name": "no/such/net.xml"}, ValueError, "no/such/net.xml"),
        ({"driver": "slopy"}, ValueError, r"\"slopy\" \(did you mean sloppy\?\)"),
        ({"hold": 0.25}, ValueError, "^hold is 0.25; allowed: a whole number"),
        ({"hodl": 1.0}, TypeError, "unknown key `hodl`; did you mean `hold`"),
        ({"hold": 1.0, "hold_s": 1.0}, TypeError, "hold and hold_s are the same setting"),
        ({"other_model": "krauss"}, ValueError, "allowed: idm with traffic='native'; only traffic='sumo' has other models"),
        ({"engine": "sumo"}, TypeError, "unknown key `engine`"),
        ({"advice": "sped"}, ValueError, "^advice is .*sped.*acceleration"),
        ({"vehicle": 22}, TypeError, "unknown key `vehicle`; did you mean `vehicles`"),
        ({"vehicles": 1}, ValueError, "vehicles is 1; allowed: a whole number from 2 to 1000"),
        ({"vehicles": [1]}, TypeError, r"vehicles is \[1\]"),
        ({"idm": {"v1": 3}}, TypeError, "idm.v1"),
        ({"policy": "pi"}, TypeError, "policy"),
        ({"duration_s": 10.0}, TypeError, "horizon_s"),
        ({"sees": "sped"}, ValueError, r"sees names `sped` \(did you mean speed\?\)"),
        ({"sees": "signal_distance"}, ValueError, "signal_distance"),
        ({"sees": "speed,reaction"}, ValueError, "`reaction`, which whole drives do not have: the kind of driver"),
        ({"residual_over": "pi"}, TypeError, "residual_over: the action is the whole advice"),
        ({"name": "merge"}, ValueError, "traffic is 'native'; allowed on a road network.*'sumo'(?s:.*)remedy: traffic='sumo'"),
        ({"name": "practice", "sees": "speed,circumference"}, ValueError, "circumference(?s:.*)remedy: set scaling"),
        ({"name": "practice", "sees": "speed,spacing"}, ValueError, "`spacing`, which is .* m here(?s:.*)remedy: set scaling.spacing_from_m"),
        ({"seed": -1}, ValueError, "seed is -1"),
        ({"seed": 2**53}, ValueError, "seed is 9007199254740992"),
        ({"seed": 1.5}, ValueError, "seed is 1.5"),
        ({"own_proces": False}, TypeError, "`own_proces`; did you mean `own_process`"),
        ({"participant": False, "advised_body": "full"}, ValueError, "participant is false; allowed on this road: with advised_body = light"),
        ({"name": "merge", "participant": False, "traffic": "sumo"}, ValueError, "advised is 1; allowed: at least one vehicle"),
        ({"render_mode": "ansi"}, ValueError, "render_mode is 'ansi'; allowed: None, 'rgb_array'"),
        ({"view": "bird"}, ValueError, r"view is 'bird' \(did you mean birdseye\?\)"),
        ({"size": (0, 10)}, ValueError, r"size is \(0, 10\)"),
        ({"size": 100}, ValueError, "size is 100"),
    ],
)
def test_what_makers_of_whole_drives_refuse(arguments, error, words):
    for make in (codrive_sim.make, codrive_sim.make_vec):
        with pytest.raises(error, match=words):
            make(**{"traffic": "native", **arguments})


def test_a_single_environment_has_one_advised_vehicle():
    with pytest.raises(ValueError, match="advised is 3; allowed: 1.*make_parallel"):
        codrive_sim.make(traffic="native", advised=3)


@pytest.mark.parametrize("count", [0, -1, 65_537, 2**70, 1.5, "4", None, True])
def test_numbers_of_environments_that_cannot_be(count):
    for traffic in ("ring", "native"):
        with pytest.raises(ValueError, match="num_envs"):
            codrive_sim.make_vec(num_envs=count, traffic=traffic)


BAD_ACTIONS = [
    (np.zeros((3, 1), np.float32), ValueError, r"shape \(3, 1\); allowed: \(4, 1\)"),
    (np.zeros(4, np.float32), ValueError, r"shape \(4,\); allowed: \(4, 1\)"),
    (0.5, ValueError, r"shape \(\); allowed"),
    (np.array([[0.0], [0.0], [np.nan], [0.0]]), ValueError, "action of environment 2 is NaN"),
    (np.full((4, 1), np.inf), ValueError, "action of environment 0 is inf"),
    (np.full((4, 1), 1e300), ValueError, "action of environment 0 is inf"),
    (np.full((4, 1), "fast"), TypeError, "dtype <U4; allowed: numbers"),
    (np.full((4, 1), None), TypeError, "dtype object"),
    (np.zeros((4, 1), complex), TypeError, "dtype complex128"),
    (np.zeros((4, 1), bool), TypeError, "dtype bool"),
    ([[0.0], [0.0, 1.0], [0.0], [0.0]], ValueError, "actions are not an array"),
    (None, TypeError, "dtype object"),
]


@pytest.mark.parametrize("traffic", ["ring", "native"])
def test_actions_that_cannot_be(traffic):
    envs, again = (codrive_sim.make_vec(num_envs=4, traffic=traffic, **SHORT) for _ in range(2))
    for one in (envs, again):
        one.reset(seed=1)
    for actions, error, words in BAD_ACTIONS:
        with pytest.raises(error, match=words):
            envs.step(actions)
    # The environment continues as if the call had not been made.
    good = np.zeros((4, 1), np.float32)
    assert np.array_equal(envs.step(good)[0], again.step(good)[0])


def test_the_native_part_takes_no_arrays_of_another_length():
    rings = Rings(Configuration("ring-250", None, {"warm_up_s": 1.0}), 4)
    with pytest.raises(RuntimeError, match="reset first"):
        rings.step(np.zeros(4, np.float32))
    rings.reset(1)
    for length in (0, 3, 5):
        with pytest.raises(ValueError, match=f"actions has {length} entries; allowed: 4"):
            rings.step(np.zeros(length, np.float32))
        with pytest.raises(ValueError, match=f"mask has {length} entries; allowed: 4"):
            rings.begin(np.zeros(length, bool))


@pytest.mark.parametrize(
    ("action", "error", "words"),
    [(3, ValueError, "is 3; allowed: 0 to 2"), (-1, ValueError, "is -1"), (1.0, TypeError, "whole numbers"), ([1], ValueError, "shape")],
)
def test_levels_that_are_not_there(action, error, words):
    for traffic in ("ring", "native"):
        env = codrive_sim.make(levels=3, traffic=traffic, **SHORT)
        env.reset(seed=1)
        with pytest.raises(error, match=words):
            env.step(action)


def test_a_step_comes_after_a_reset_and_nothing_after_the_end():
    one, many = codrive_sim.make(**SHORT), codrive_sim.make_vec(num_envs=2, **SHORT)
    drive, drives = codrive_sim.make(traffic="native", **SHORT), codrive_sim.make_vec(num_envs=2, traffic="native", **SHORT)
    for env, action in ((one, np.zeros(1)), (many, np.zeros((2, 1))), (drive, np.zeros(1)), (drives, np.zeros((2, 1)))):
        with pytest.raises(gymnasium.error.ResetNeeded, match="reset"):
            env.step(action)
        env.reset(seed=1)
        env.close()
        env.close()
        with pytest.raises(gymnasium.error.ClosedEnvironmentError, match="make another"):
            env.step(action)
        with pytest.raises(gymnasium.error.ClosedEnvironmentError):
            env.reset()


@pytest.mark.parametrize("seed", [[1, 2], "1", 1.5])
def test_seeds_that_cannot_be(seed):
    for traffic in ("ring", "native"):
        with pytest.raises(TypeError, match="seed"):
            codrive_sim.make_vec(num_envs=2, traffic=traffic, **SHORT).reset(seed=seed)


@pytest.mark.parametrize("mask", [np.ones(3, bool), np.ones(2), "yes", np.ones((2, 1), bool)])
def test_masks_that_cannot_be(mask):
    for traffic in ("ring", "native"):
        with pytest.raises(ValueError, match="reset_mask"):
            codrive_sim.make_vec(num_envs=2, traffic=traffic, **SHORT).reset(options={"reset_mask": mask})


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"policy": "fastest"}, ValueError, "policy `fastest` is unknown"),
        ({"policy": "follower-stoper"}, ValueError, "did you mean follower-stopper"),
        ({"policy": "no-such.onnx"}, ValueError, "no-such.onnx"),
        ({"policy": 3}, TypeError, "policy is 3; allowed"),
        ({"policy": "pi", "name": None}, TypeError, "name is None; allowed: a text"),
        ({"policy": "pi", "name": "practice", "traffic": "ring"}, ValueError, r"no ring \"practice\"(?s:.*)remedy: traffic='sumo'"),
        ({"policy": "pi", "num_envs": 4}, TypeError, "num_envs: .*codrive_sim.evaluate has over, the number of rings"),
        ({"policy": "pi", "hold": -1}, ValueError, "^hold is -1"),
        ({"policy": "pi", "policy_speed": "fast"}, TypeError, "policy_speed is 'fast'; allowed: a number"),
        ({"policy": "none", "over": 0}, ValueError, "over is 0"),
        ({"policy": "none", "as_": "arrow"}, ValueError, "as_ is 'arrow'"),
        ({"policy": "none", "policy_speed": float("nan")}, ValueError, "policy_speed is nan"),
        ({"policy": lambda seen: np.zeros(3), "over": 2}, ValueError, r"shape \(3,\); allowed"),
        ({"policy": lambda seen: np.full(len(seen), np.nan), "over": 2}, ValueError, "observation 0 is nan"),
        ({"policy": lambda seen: "fast", "over": 2}, ValueError, "the policy gave <U4"),
        ({"policy": lambda seen: 1 / 0, "over": 2}, ZeroDivisionError, "division"),
    ],
)
def test_what_evaluate_refuses(arguments, error, words):
    with pytest.raises(error, match=words):
        codrive_sim.evaluate(**{"over": 2, "driver": "exact", **SHORT, **arguments})


def test_a_table_that_holds_itself_is_refused():
    endless = {}
    endless["v0"] = endless
    for traffic in ("ring", "native"):
        with pytest.raises(TypeError, match="v0 is nested too deeply"):
            codrive_sim.make(traffic=traffic, idm=endless)
    with pytest.raises(ValueError, match="demand"):
        codrive_sim.make("merge", demand={"flows": [{"from": "a", "to": ["b"], "per_hour": 1.0}]})


_numbers = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(2**70), 2**70),
    st.floats(),
    st.text(max_size=8),
    st.lists(st.floats(), max_size=4),
    st.dictionaries(st.text(max_size=4), st.floats(), max_size=2),
    st.binary(max_size=3),
)
_names = st.one_of(st.sampled_from([*codrive_sim.settings(), "hold", "advice", "name", "traffic"]), st.text(max_size=12))
#: All failures raise one of these.
ALLOWED = (TypeError, ValueError, OverflowError, gymnasium.error.Error, gymnasium.error.ClosedEnvironmentError)


@settings(max_examples=150, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(st.dictionaries(_names, _numbers, max_size=3))
def test_any_settings_make_an_environment_or_an_error(arguments):
    # Expensive settings have upper bounds.
    if isinstance(arguments.get("warm_up_s"), float) and arguments["warm_up_s"] > 100.0:
        arguments["warm_up_s"] = 100.0
    try:
        env = codrive_sim.make(**arguments)
        env.reset(seed=1)
        env.step(env.action_space.sample())
    except ALLOWED as error:
        assert str(error)


_calls = st.lists(
    st.one_of(
        st.tuples(st.just("reset"), st.one_of(st.none(), st.integers(-3, 2**70), st.text(max_size=3))),
        st.tuples(st.just("step"), st.one_of(st.floats(), st.lists(st.floats(width=32), min_size=3, max_size=3), st.none())),
        st.tuples(st.just("good"), st.floats(-1, 1)),
        st.tuples(st.just("mask"), st.lists(st.booleans(), min_size=2, max_size=4)),
        st.tuples(st.just("close"), st.none()),
    ),
    max_size=8,
)


@settings(max_examples=150, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(_calls)
def test_any_order_of_calls_gives_numbers_or_an_error(calls):
    envs = codrive_sim.make_vec(num_envs=3, **SHORT)
    for call, value in calls:
        try:
            if call == "reset":
                envs.reset(seed=value)
            elif call == "mask":
                envs.reset(options={"reset_mask": np.array(value)})
            elif call == "close":
                envs.close()
            else:
                actions = np.full((3, 1), value) if call == "good" else np.reshape(value, (-1, 1))
                seen, rewards, *_ = envs.step(actions)
                assert np.isfinite(seen).all() and np.isfinite(rewards).all()
        except ALLOWED as error:
            assert str(error)


_drive_names = st.one_of(
    st.sampled_from([*codrive_sim.settings(traffic="native"), "hold", "advice", "name", "traffic", "advised", "view", "size"]), st.text(max_size=12)
)
#: Upper bounds of settings that would take long.
DEAR = {"warm_up_s": 20.0, "vehicles": 40, "wave_wait_s": 20.0, "horizon_s": 100.0, "trees": 100}


@settings(max_examples=150, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(st.dictionaries(_drive_names, _numbers, max_size=3))
def test_any_settings_make_a_drive_or_an_error(arguments):
    arguments = {"warm_up_s": 1.0, "traffic": "native", **arguments}
    for key, most in DEAR.items():
        if isinstance(arguments.get(key), (int, float)):
            arguments[key] = min(arguments[key], most)
    try:
        env = codrive_sim.make(**arguments)
        env.reset(seed=1)
        env.step(env.action_space.sample())
    # A drive with such settings may fail with a message.
    except (*ALLOWED, RuntimeError) as error:
        assert str(error)


@settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(_calls)
def test_any_order_of_calls_of_a_drive_gives_numbers_or_an_error(calls):
    env = codrive_sim.make(traffic="native", **SHORT)
    several = codrive_sim.make_parallel(traffic="native", advised=3, **SHORT)
    for call, value in calls:
        try:
            if call == "reset":
                env.reset(seed=value)
            elif call == "mask":
                env.reset(options={"reset_mask": value})
            elif call == "close":
                env.close()
            else:
                seen, reward, *_ = env.step(np.full(1, value) if call == "good" else value)
                assert np.isfinite(seen).all() and np.isfinite(reward)
        except ALLOWED as error:
            assert str(error)
        try:
            if call in ("reset", "mask"):
                several.reset(seed=value if call == "reset" else None)
            elif call == "close":
                several.close()
            else:
                given = value if call == "good" or isinstance(value, (list, type(None))) else [value] * 3
                actions = given if given is None else dict(zip(several.agents, np.broadcast_to(given, (3,))[:, None]))
                seen, rewards, *_ = several.step(actions)
                assert all(np.isfinite(row).all() for row in seen.values()) and np.isfinite(list(rewards.values())).all()
        except ALLOWED as error:
            assert str(error)
