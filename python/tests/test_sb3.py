"""Tests with Stable-Baselines3: its checker and its vector environment. It needs PyTorch, several GB with its libraries. Where it is not
installed, the tests are recorded as not run (tests/not-run-here)."""

import importlib.util

import numpy as np
import pytest

import codrive
from not_run import leave_out

SHORT = {"warm_up_s": 5.0, "horizon_s": 4.0}

if importlib.util.find_spec("stable_baselines3") is None:

    @pytest.fixture(autouse=True)
    def noted_as_not_run(request):
        leave_out(request, "stable-baselines3", "stable-baselines3 is not installed")


def test_its_checker_passes():
    from stable_baselines3.common.env_checker import check_env

    for settings in ({}, {"levels": 5}, {"advice": "speed", "driver": "people"}):
        check_env(codrive.make(**SHORT, **settings))
    for traffic in ("native", "sumo"):
        env = codrive.make(traffic=traffic, **SHORT)
        check_env(env)
        env.close()


@pytest.mark.parametrize("settings", [{"num_envs": 20}, {"num_envs": 3, "traffic": "native"}], ids=["rings", "drives"])
def test_its_vector_environment_is_ours(settings):
    import codrive.sb3

    ours = codrive.make_vec(**settings, **SHORT)
    theirs = codrive.sb3.VecEnv(**settings, **SHORT)
    theirs.seed(3)
    assert np.array_equal(theirs.reset(), ours.reset(seed=3)[0])
    for hold in range(1, 9):
        actions = np.full((settings["num_envs"], 1), 0.1 * hold, np.float32)
        seen, rewards, ended, told = theirs.step(actions)
        own, own_rewards, terminations, truncations, infos = ours.step(actions)
        assert np.array_equal(seen, own) and np.array_equal(rewards, own_rewards.astype(np.float32))
        assert np.array_equal(ended, terminations | truncations) and ended.all() == (hold % 4 == 0)
        for ring in np.flatnonzero(ended):
            assert np.array_equal(told[ring]["terminal_observation"], infos["final_obs"][ring])
            assert told[ring]["TimeLimit.truncated"] == truncations[ring]


def test_it_learns_on_many_rings_and_its_model_is_evaluated():
    from stable_baselines3 import PPO

    import codrive.sb3

    envs = codrive.sb3.VecEnv(num_envs=64, advice="speed", **SHORT)
    model = PPO("MlpPolicy", envs, n_steps=8, batch_size=256, n_epochs=1, seed=1, device="cpu")
    model.learn(512)
    # It was trained with advice of speed, and is judged so.
    table = codrive.evaluate(model, over=2, **SHORT)
    assert set(table.policy) == {"PPO"} and np.isfinite(table.mean_speed_mps).all()
    given = codrive.evaluate(model, over=2, advice="speed", **SHORT)
    assert list(given.mean_speed_mps) == list(table.mean_speed_mps)


def test_a_normaliser_of_observations_belongs_to_the_model(tmp_path):
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecNormalize

    import codrive.sb3

    ring = {"warm_up_s": 5.0, "horizon_s": 20.0}
    envs = VecNormalize(codrive.sb3.VecEnv(num_envs=16, advice="speed", **ring))
    model = PPO("MlpPolicy", envs, n_steps=8, batch_size=64, n_epochs=1, seed=1, device="cpu")
    model.learn(256)
    own = codrive.evaluate(model, over=3, **ring)

    def by_hand(seen):
        return model.predict(envs.normalize_obs(seen), deterministic=True)[0]

    wanted = codrive.evaluate(by_hand, over=3, advice="speed", **ring)
    assert list(own.mean_speed_mps) == list(wanted.mean_speed_mps)
    without = codrive.evaluate(lambda seen: model.predict(seen, deterministic=True)[0], over=3, advice="speed", **ring)
    assert list(own.mean_speed_mps) != list(without.mean_speed_mps)
    # The first layer of the file takes it over.
    file = tmp_path / "normalised.toml"
    codrive.save_policy(file, codrive.sb3.layers(model), envs)
    saved = codrive.evaluate(file, over=3, advice="speed", **ring)
    assert np.allclose(saved.mean_speed_mps, own.mean_speed_mps, rtol=0.0, atol=1e-4)


def test_its_networks_become_policies_of_ours(tmp_path):
    import codrive.sb3
    from stable_baselines3 import A2C, PPO

    rings = codrive.sb3.VecEnv(num_envs=16, hold=2.0, **SHORT)
    for model in (PPO("MlpPolicy", rings, n_steps=8, device="cpu"), A2C("MlpPolicy", rings, policy_kwargs={"net_arch": []}, device="cpu")):
        codrive.save_policy(tmp_path / "policy.onnx", codrive.sb3.layers(model), rings)
        ours = codrive.evaluate(tmp_path / "policy.onnx", over=16, hold=2.0, **SHORT)
        # Before the first update, outputs are all near 0, so that small differences do not grow.
        assert np.allclose(ours.mean_speed_mps, codrive.evaluate(model, over=16, hold=2.0, **SHORT).mean_speed_mps, atol=1e-3)
    with pytest.raises(ValueError, match="describe_policy"):
        import torch

        codrive.sb3.layers(PPO("MlpPolicy", rings, n_steps=8, device="cpu", policy_kwargs={"activation_fn": torch.nn.ReLU}))


def test_its_tutorials_take_our_ids(tmp_path):
    from stable_baselines3 import PPO
    from stable_baselines3.common.env_util import make_vec_env
    from stable_baselines3.common.evaluation import evaluate_policy
    from stable_baselines3.common.vec_env import SubprocVecEnv

    model = PPO("MlpPolicy", "codrive/Ring250-v0", n_steps=32, batch_size=32, device="cpu").learn(64)
    model.save(tmp_path / "model")
    # A new process has not imported codrive; the id names the module.
    for name, kind in (("codrive/Ring250-v0", None), ("codrive:codrive/Ring250-v0", SubprocVecEnv)):
        envs = make_vec_env(name, n_envs=2, env_kwargs=SHORT, vec_env_cls=kind)
        model = PPO("MlpPolicy", envs, n_steps=16, batch_size=32, device="cpu").learn(64)
        # Both environments are drawn, one above the other.
        assert envs.render(mode="rgb_array").shape == (1440, 1280, 3)
        envs.close()
    mean, _ = evaluate_policy(model, make_vec_env("codrive/Ring250-v0", env_kwargs=SHORT), n_eval_episodes=2)
    # An episode of 4 holds at 0 to 10 m/s.
    assert 0.0 < mean < 40.0


def test_agents_of_one_drive_train_one_policy_by_supersuit():
    import supersuit
    from stable_baselines3 import PPO

    env = codrive.make_parallel("ring-250", advised=4, participant=False, **SHORT)
    envs = supersuit.pettingzoo_env_to_vec_env_v1(env)
    envs = supersuit.concat_vec_envs_v1(envs, 2, num_cpus=1, base_class="stable_baselines3")
    assert envs.num_envs == 8
    PPO("MlpPolicy", envs, n_steps=16, batch_size=32, device="cpu").learn(128)
