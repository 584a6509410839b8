"""Tests of rings as environments of Gymnasium."""

import copy
import multiprocessing
import pickle
import signal
import threading
import time
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import codrive_sim

#: Settings of episodes that take seconds.
SHORT = {"warm_up_s": 5.0, "horizon_s": 4.0}


def random_drive(envs, holds, seed):
    """Returns all outputs of a vector environment under random actions from a seed."""
    rng = np.random.default_rng(seed)
    given = [envs.reset(seed=seed)[0]]
    for _ in range(holds):
        seen, rewards, terminations, truncations, _ = envs.step(rng.uniform(-1, 1, (envs.num_envs, 1)).astype(np.float32))
        given += [seen, rewards, terminations, truncations]
    return b"".join(part.tobytes() for part in given)


@pytest.mark.parametrize("name", ["codrive/Ring250-v0", "codrive/Ring641-v0"])
def test_gymnasiums_checker_passes(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # The checker always warns of infinite bounds, such as those of a gap.
        warnings.filterwarnings("ignore", message=".*infinity.*")
        check_env(gymnasium.make(name, **SHORT).unwrapped)


def test_gymnasiums_checker_passes_for_levels_too():
    check_env(gymnasium.make("codrive/Ring250-v0", levels=5, **SHORT).unwrapped)


def test_the_ids_make_one_and_many():
    assert isinstance(gymnasium.make("codrive/Ring250-v0", hold=2.0).unwrapped, codrive_sim.RingEnv)
    envs = gymnasium.make_vec(
        "codrive/Ring641-v0", num_envs=3, vectorization_mode="vector_entry_point", advice="speed", **SHORT
    )
    assert isinstance(envs.unwrapped, codrive_sim.RingVectorEnv)
    assert envs.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    assert envs.reset(seed=1)[0].shape == (3, 4)


def test_an_id_draws_the_pictures_that_libraries_ask_for():
    for name in ("codrive/Ring250-v0", "codrive/Drive-v0"):
        arguments = {"size": (320, 200), "view": "schematic", **SHORT, **({} if "Ring" in name else {"traffic": "native"})}
        env = gymnasium.make(name, render_mode="rgb_array", **arguments).unwrapped
        with pytest.raises(gymnasium.error.ResetNeeded):
            env.render()
        env.reset(seed=1)
        pictures = [env.render()]
        for _ in range(4):
            env.step(np.ones(1, np.float32))
            pictures.append(env.render())
        assert all(picture.shape == (200, 320, 3) and picture.dtype == np.uint8 for picture in pictures)
        # Vehicles move, and the lines of the diagram grow.
        assert all(not np.array_equal(first, second) for first, second in zip(pictures, pictures[1:]))
        env.close()


@pytest.mark.parametrize("vectorised", ["sync", "async", "vector_entry_point"])
def test_gymnasiums_own_vectors_take_the_ids(vectorised):
    envs = gymnasium.make_vec("codrive/Ring250-v0", num_envs=2, vectorization_mode=vectorised, **SHORT)
    envs.reset(seed=1)
    ends = [envs.step(np.zeros((2, 1), np.float32))[3].all() for _ in range(4)]
    assert ends == [False, False, False, True]
    envs.close()


def test_wrappers_of_training_loops_take_the_ids():
    # As the single-file implementations of PPO wrap an environment.
    env = gymnasium.make("codrive/Ring250-v0", **SHORT)
    env = gymnasium.wrappers.RecordEpisodeStatistics(gymnasium.wrappers.FlattenObservation(env))
    env = gymnasium.wrappers.NormalizeReward(gymnasium.wrappers.NormalizeObservation(gymnasium.wrappers.ClipAction(env)), gamma=0.99)
    env.reset(seed=1)
    infos = [env.step(np.full(1, 2.0, np.float32))[4] for _ in range(4)]
    assert infos[3]["episode"]["l"] == 4 and "episode" not in infos[2]
    assert infos[3]["episode"]["r"] == pytest.approx(sum(info["mean_speed_mps"] for info in infos), abs=1e-4)


def test_rings_are_drawn_side_by_side_up_to_sixty_four():
    envs = codrive_sim.make_vec("ring-250", num_envs=2, render_mode="rgb_array", size=(320, 200), **SHORT)
    envs.reset(seed=1)
    first, second = envs.render()
    assert first.shape == (200, 320, 3) and not np.array_equal(first, second)
    assert codrive_sim.make_vec("ring-250", num_envs=2, **SHORT).render() is None
    with pytest.raises(ValueError, match="num_envs is 65; allowed with a render_mode: 1 to 64"):
        codrive_sim.make_vec("ring-250", num_envs=65, render_mode="rgb_array")
    with pytest.raises(ValueError, match="render_mode is 'human'; allowed: None, 'rgb_array'"):
        codrive_sim.make_vec("ring-250", num_envs=2, render_mode="human")
    with pytest.raises(ValueError, match="view is 'chase'; allowed: schematic"):
        codrive_sim.make("ring-250", render_mode="rgb_array", view="chase")


def test_a_window_without_a_display_is_refused_with_the_remedy(monkeypatch):
    for variable in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(variable, raising=False)
    # Libraries that ask for a window take a TypeError as "without".
    for kind in (gymnasium.error.DependencyNotInstalled, TypeError):
        with pytest.raises(kind, match="remedy: render_mode='rgb_array'"):
            codrive_sim.make("ring-250", render_mode="human")


@pytest.mark.parametrize(
    "make",
    [
        lambda: codrive_sim.make("ring-641", hold=2.0, **SHORT),
        lambda: codrive_sim.make_vec(num_envs=20, driver="people", **SHORT),
        lambda: codrive_sim.make(traffic="native", **SHORT),
        lambda: codrive_sim.make_vec(num_envs=2, traffic="native", **SHORT),
    ],
    ids=["ring", "rings", "drive", "drives"],
)
def test_environments_are_pickled_and_copied_as_their_arguments(make):
    env = make()
    new = pickle.loads(pickle.dumps(env))
    with pytest.raises(gymnasium.error.ResetNeeded):
        new.step(np.zeros(new.action_space.shape, np.float32))
    new.close()
    own = env.reset(seed=3)[0]
    for other in (copy.deepcopy(env), pickle.loads(pickle.dumps(env))):
        assert type(other) is type(env)
        other.step(np.zeros(other.action_space.shape, np.float32))
        assert np.array_equal(other.reset(seed=3)[0], own)
        other.close()
    # The first one is still open.
    env.step(np.zeros(env.action_space.shape, np.float32))
    env.close()


def test_seeds_too_large_are_refused_because_they_would_coincide():
    for env in (codrive_sim.make(**SHORT), codrive_sim.make(traffic="native", **SHORT)):
        env.reset(seed=2**53 - 1)
        with pytest.raises(ValueError, match="seed is 9007199254740992; allowed: a whole number from 0 to 9007199254740991"):
            env.reset(seed=2**53)
        env.close()


@pytest.mark.parametrize("waits", ["reset", "step"])
def test_ctrl_c_ends_the_beginning_of_many_episodes_within_a_second(waits):
    # In a reset the warm-ups take many minutes. In a step they take seconds: a hold ends each episode and begins the next one. Ctrl-C after half
    # a second must find the first step at work, on a fast machine, too.
    envs = codrive_sim.make_vec(num_envs=16384, warm_up_s=3600.0 if waits == "reset" else 120.0, horizon_s=1.0)
    still = np.zeros((envs.num_envs, 1), np.float32)
    if waits == "step":
        envs.reset(seed=1)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    main = threading.main_thread().ident
    interrupt = threading.Timer(0.5, lambda: signal.pthread_kill(main, signal.SIGINT))
    interrupt.start()
    begun = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        while True:
            envs.reset(seed=2) if waits == "reset" else envs.step(still)
    took_s = time.monotonic() - begun
    interrupt.cancel()
    assert took_s < 1.5
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.step(still)


def test_one_environment_is_the_first_of_a_vector_of_one():
    env, envs = codrive_sim.make(**SHORT), codrive_sim.make_vec(num_envs=1, **SHORT)
    one, many = env.reset(seed=5)[0], envs.reset(seed=5)[0]
    assert np.array_equal(one, many[0])
    for hold in range(10):
        action = np.array([np.sin(hold)], np.float32)
        seen, reward, terminated, truncated, _ = env.step(action)
        all_seen, rewards, terminations, truncations, infos = envs.step(action[None])
        assert (reward, terminated, truncated) == (rewards[0], terminations[0], truncations[0])
        last = infos["final_obs"][0] if terminated or truncated else all_seen[0]
        assert np.array_equal(seen, last)
        if terminated or truncated:
            assert np.array_equal(env.reset()[0], all_seen[0])


def test_a_seed_makes_the_same_episodes_again_and_another_seed_others():
    envs = codrive_sim.make_vec(num_envs=37, **SHORT)
    first = random_drive(envs, 9, seed=3)
    assert random_drive(envs, 9, seed=3) == first
    assert random_drive(codrive_sim.make_vec(num_envs=37, **SHORT), 9, seed=3) == first
    assert random_drive(envs, 9, seed=4) != first


def test_the_setting_seed_is_that_of_the_first_reset():
    own = codrive_sim.make(seed=12, **SHORT).reset()[0]
    assert np.array_equal(own, codrive_sim.make(**SHORT).reset(seed=12)[0])
    assert not np.array_equal(own, codrive_sim.make(seed=13, **SHORT).reset()[0])


def test_an_episode_ends_at_its_horizon_in_the_same_step():
    # Four holds of 1 s in 4 s; the model itself prevents collisions.
    envs = codrive_sim.make_vec(num_envs=5, driver="guarded", **SHORT)
    envs.reset(seed=1)
    still = np.zeros((5, 1), np.float32)
    for hold in range(1, 9):
        seen, _, terminations, truncations, infos = envs.step(still)
        assert not terminations.any()
        assert truncations.all() == (hold % 4 == 0) and truncations.any() == truncations.all()
        assert ("final_obs" in infos) == truncations.any()
    assert infos["_final_obs"].all() and infos["_final_info"].all()
    final = np.stack(infos["final_obs"])
    assert final.dtype == np.float32 and final.shape == seen.shape and not np.array_equal(final, seen)
    assert np.array_equal(infos["final_info"]["mean_speed_mps"], infos["mean_speed_mps"])


def test_the_last_observation_is_what_would_have_been_seen_without_the_horizon():
    ended, going = (codrive_sim.make_vec(num_envs=20, warm_up_s=5.0, horizon_s=horizon_s) for horizon_s in (3.0, 4.0))
    for envs in (ended, going):
        envs.reset(seed=6)
    for hold in range(3):
        actions = np.full((20, 1), 0.1 * hold, np.float32)
        _, _, _, truncations, infos = ended.step(actions)
        seen = going.step(actions)[0]
    assert truncations.all()
    assert np.array_equal(np.stack(infos["final_obs"]), seen)


def test_a_crash_terminates_and_costs_the_penalty():
    # The advice is followed exactly at full acceleration: 0.5 m/s2 closes any gap of 250 m in a minute.
    env = codrive_sim.make(driver="exact", collision_penalty=100.0, horizon_s=100.0, warm_up_s=5.0)
    env.reset(seed=1)
    for _ in range(100):
        _, reward, terminated, truncated, info = env.step(np.ones(1, np.float32))
        if terminated:
            break
    assert terminated and not truncated
    assert reward == pytest.approx(info["mean_speed_mps"] - 100.0, abs=1e-4)
    with pytest.raises(gymnasium.error.ResetNeeded, match="has ended"):
        env.step(np.ones(1, np.float32))


def test_an_action_is_a_share_of_its_limits():
    # One hold of 1 s, followed exactly: the speed changes by the acceleration, 0.5 m/s2 at 1 and none at 0. Scaled speed 1 is 10 m/s.
    for action, change_mps in ((1.0, 0.5), (0.0, 0.0), (-0.4, -0.2), (7.0, 0.5)):
        env = codrive_sim.make(warm_up_s=60.0)
        assert env.action_limits == (-0.5, 0.5) and env.inputs[0] == ("speed", 0.0, 10.0)
        before = env.reset(seed=2)[0][0]
        after = env.step(np.array([action], np.float32))[0][0]
        assert (after - before) * 5.0 == pytest.approx(change_mps, abs=1e-4)


def test_levels_lie_evenly_between_the_limits():
    for level, change_mps in ((0, -0.5), (1, 0.0), (2, 0.5)):
        env = codrive_sim.make(levels=3, warm_up_s=60.0)
        before = env.reset(seed=2)[0][0]
        assert (env.step(level)[0][0] - before) * 5.0 == pytest.approx(change_mps, abs=1e-4)
    assert codrive_sim.make_vec(num_envs=2, levels=3).action_space == gymnasium.spaces.MultiDiscrete([3, 3])


def test_arrays_are_the_callers_own_unless_copy_is_false():
    for copy in (True, False):
        envs = codrive_sim.make_vec(num_envs=4, copy=copy, **SHORT)
        envs.reset(seed=1)
        first = envs.step(np.zeros((4, 1), np.float32))
        kept = [part.copy() for part in first[:4]]
        second = envs.step(np.ones((4, 1), np.float32))
        for part, as_it_was, later in zip(first[:2], kept, second):
            assert np.array_equal(part, as_it_was) == copy
            assert np.shares_memory(part, later) != copy


def test_a_mask_resets_those_alone():
    envs = codrive_sim.make_vec(num_envs=20, **SHORT)
    before = envs.reset(seed=1)[0]
    mask = np.arange(20) % 7 == 3
    after = envs.reset(options={"reset_mask": mask})[0]
    changed = (after != before).any(axis=1)
    assert np.array_equal(changed, mask)


def test_the_settings_are_those_that_were_asked_for():
    settings = codrive_sim.settings("ring-250", hold=2.0, advice="speed", idm={"v0": 20.0}, vehicles_max=24)
    assert (settings["hold_s"], settings["action"], settings["idm"]["v0"]) == (2.0, "speed", 20.0)
    assert (settings["vehicles_min"], settings["vehicles_max"], settings["circumference_min_m"]) == (22, 24, 250.0)
    assert codrive_sim.settings(driver="late")["follow"] == "driver"
    assert codrive_sim.settings(driver="reaction=2,error=0.1")["reaction_s"] == 2.0
    assert codrive_sim.settings(driver="people")["population"] == "people"
    # Numbers of numpy are accepted.
    assert codrive_sim.settings(vehicles_max=np.int64(23), horizon_s=np.float32(50.0))["horizon_s"] == 50.0


def test_python_goes_on_while_rings_are_warmed_up():
    ticks, stop = 0, threading.Event()

    def count():
        nonlocal ticks
        while not stop.wait(0.001):
            ticks += 1

    thread = threading.Thread(target=count)
    thread.start()
    codrive_sim.make_vec(num_envs=512, warm_up_s=400.0).reset(seed=1)
    stop.set()
    thread.join()
    # If the lock were held for the whole warm-up, no other thread would run.
    assert ticks >= 5


def _child(queue):
    queue.put(random_drive(codrive_sim.make_vec(num_envs=40, **SHORT), 3, seed=1))


@pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="this system forks no processes")
def test_a_forked_process_has_threads_of_its_own():
    here = random_drive(codrive_sim.make_vec(num_envs=40, **SHORT), 3, seed=1)
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        child = context.Process(target=_child, args=(queue,), daemon=True)
        child.start()
    assert queue.get(timeout=60) == here
    child.join(timeout=60)
