"""Tests with Stable-Baselines3: its checker and its vector environment. It needs PyTorch, several GB with its libraries. Where it is not
installed, the tests are recorded as not run (tests/not-run-here)."""

import importlib.util

import numpy as np
import pytest

import codrive_sim
from not_run import leave_out

SHORT = {"warm_up_s": 5.0, "horizon_s": 4.0}

if importlib.util.find_spec("stable_baselines3") is None:

    @pytest.fixture(autouse=True)
    def noted_as_not_run(request):
        leave_out(request, "stable-baselines3", "stable-baselines3 is not installed")


def test_its_checker_passes():
    from stable_baselines3.common.env_checker import check_env

    for settings in ({}, {"levels": 5}, {"advice": "speed", "driver": "people"}):
        check_env(codrive_sim.make(**SHORT, **settings))
    for traffic in ("native", "sumo"):
        env = codrive_sim.make(traffic=traffic, **SHORT)
        check_env(env)
        env.close()


@pytest.mark.parametrize("settings", [{"num_envs": 20}, {"num_envs": 3, "traffic": "native"}], ids=["rings", "drives"])
def test_its_vector_environment_is_ours(settings):
    import codrive_sim.sb3

    ours = codrive_sim.make_vec(**settings, **SHORT)
    theirs = codrive_sim.sb3.VecEnv(**settings, **SHORT)
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

    import codrive_sim.sb3

    envs = codrive_sim.sb3.VecEnv(num_envs=64, advice="speed", **SHORT)
    model = PPO("MlpPolicy", envs, n_steps=8, batch_size=256, n_epochs=1, seed=1, device="cpu")
    model.learn(512)
    # It was trained with advice of speed, and is judged so.
    table = codrive_sim.evaluate(model, over=2, **SHORT)
    assert set(table.policy) == {"PPO"} and np.isfinite(table.mean_speed_mps).all()
    given = codrive_sim.evaluate(model, over=2, advice="speed", **SHORT)
    assert list(given.mean_speed_mps) == list(table.mean_speed_mps)


def test_a_normaliser_of_observations_belongs_to_the_model(tmp_path):
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecNormalize

    import codrive_sim.sb3

    ring = {"warm_up_s": 5.0, "horizon_s": 20.0}
    envs = VecNormalize(codrive_sim.sb3.VecEnv(num_envs=16, advice="speed", **ring))
    model = PPO("MlpPolicy", envs, n_steps=8, batch_size=64, n_epochs=1, seed=1, device="cpu")
    model.learn(256)
    own = codrive_sim.evaluate(model, over=3, **ring)

    def by_hand(seen):
        return model.predict(envs.normalize_obs(seen), deterministic=True)[0]

    wanted = codrive_sim.evaluate(by_hand, over=3, advice="speed", **ring)
    assert list(own.mean_speed_mps) == list(wanted.mean_speed_mps)
    without = codrive_sim.evaluate(lambda seen: model.predict(seen, deterministic=True)[0], over=3, advice="speed", **ring)
    assert list(own.mean_speed_mps) != list(without.mean_speed_mps)
    # The first layer of the file takes it over.
    file = tmp_path / "normalised.toml"
    codrive_sim.save_policy(file, codrive_sim.sb3.layers(model), envs)
    saved = codrive_sim.evaluate(file, over=3, advice="speed", **ring)
    assert np.allclose(saved.mean_speed_mps, own.mean_speed_mps, rtol=0.0, atol=1e-4)


def test_its_networks_become_policies_of_ours(tmp_path):
    import codrive_sim.sb3
    from stable_baselines3 import A2C, PPO

    rings = codrive_sim.sb3.VecEnv(num_envs=16, hold=2.0, **SHORT)
    for model in (PPO("MlpPolicy", rings, n_steps=8, device="cpu"), A2C("MlpPolicy", rings, policy_kwargs={"net_arch": []}, device="cpu")):
        codrive_sim.save_policy(tmp_path / "policy.onnx", codrive_sim.sb3.layers(model), rings)
        ours = codrive_sim.evaluate(tmp_path / "policy.onnx", over=16, hold=2.0, **SHORT)
        # Before the first update, outputs are all near 0, so that small differences do not grow.
        assert np.allclose(ours.mean_speed_mps, codrive_sim.evaluate(model, over=16, hold=2.0, **SHORT).mean_speed_mps, atol=1e-3)
    with pytest.raises(ValueError, match="describe_policy"):
        import torch

        codrive_sim.sb3.layers(PPO("MlpPolicy", rings, n_steps=8, device="cpu", policy_kwargs={"activation_fn": torch.nn.ReLU}))


def test_its_tutorials_take_our_ids(tmp_path):
    from stable_baselines3 import PPO
    from stable_baselines3.common.env_util import make_vec_env
    from stable_baselines3.common.evaluation import evaluate_policy
    from stable_baselines3.common.vec_env import SubprocVecEnv

    model = PPO("MlpPolicy", "codrive/Ring250-v0", n_steps=32, batch_size=32, device="cpu").learn(64)
    model.save(tmp_path / "model")
    # A new process has not imported codrive; the id names the module.
    for name, kind in (("codrive/Ring250-v0", None), ("codrive_sim:codrive/Ring250-v0", SubprocVecEnv)):
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

    env = codrive_sim.make_parallel("ring-250", advised=4, participant=False, **SHORT)
    envs = supersuit.pettingzoo_env_to_vec_env_v1(env)
    envs = supersuit.concat_vec_envs_v1(envs, 2, num_cpus=1, base_class="stable_baselines3")
    assert envs.num_envs == 8
    PPO("MlpPolicy", envs, n_steps=16, batch_size=32, device="cpu").learn(128)


def test_a_recurrent_model_becomes_a_policy_of_ours(tmp_path):
    import codrive_sim.sb3
    import onnxruntime
    from sb3_contrib import RecurrentPPO
    from stable_baselines3.common.vec_env import VecNormalize

    # Without the circumference, which is the same in all holds, and without a limit, which a layer cannot have.
    sees = {"hold": 1.0, "advice": "speed", "sees": "speed,leader_speed,gap"}
    envs = VecNormalize(codrive_sim.sb3.VecEnv(num_envs=16, **sees, **SHORT), clip_obs=np.inf)
    model = RecurrentPPO(
        "MlpLstmPolicy", envs, n_steps=16, batch_size=64, n_epochs=1, seed=1, device="cpu",
        policy_kwargs={"lstm_hidden_size": 12, "n_lstm_layers": 2},
    )  # fmt: skip
    model.learn(512)
    file = tmp_path / "recurrent.onnx"
    codrive_sim.save_policy(file, codrive_sim.sb3.layers(model), envs)
    session = onnxruntime.InferenceSession(file)
    names = [one.name for one in session.get_inputs()]
    held = [np.zeros((1, 12), np.float32)] * (len(names) - 1)
    # An episode of 100 holds.
    env = codrive_sim.make(horizon_s=100.0, driver="perfect", **sees)
    seen, _ = env.reset(seed=3)
    state, given = None, []
    for _ in range(100):
        action, state = model.predict(envs.normalize_obs(seen[None]), state=state, deterministic=True)
        ours, *held = session.run(None, dict(zip(names, [seen[None], *held], strict=True)))
        # The normaliser in the first layer scales before it subtracts, so that sums of float32 differ by some units of the 24th digit.
        assert np.allclose(np.clip(ours, -1.0, 1.0), action, rtol=0.0, atol=1e-5)
        given.append(float(action[0, 0]))
        seen, *_ = env.step(action[0])
    assert len(set(given)) > 50
    asked = {"over": 4, "hold": 1.0, **SHORT}
    ours = codrive_sim.evaluate(file, **asked)
    theirs = codrive_sim.evaluate(model, **asked)
    assert np.allclose(ours.mean_speed_mps, theirs.mean_speed_mps, rtol=0.0, atol=1e-3)
    drives = {"traffic": "native", "advised": 2, "over": 1, "hold": 1.0, "warm_up_s": 5.0, "horizon_s": 20.0}
    ours, theirs = codrive_sim.evaluate(file, **drives), codrive_sim.evaluate(model, **drives)
    assert np.allclose(ours.mean_speed_mps, theirs.mean_speed_mps, rtol=0.0, atol=1e-3)


@pytest.mark.parametrize("kind", ["LSTM", "GRU"])
def test_a_module_of_pytorch_becomes_a_policy_of_ours(tmp_path, kind):
    import onnxruntime
    import torch

    envs = codrive_sim.make_vec(num_envs=1)
    torch.manual_seed(2)
    module = getattr(torch.nn, kind)(len(envs.inputs), 5, num_layers=2, bias=kind == "GRU")
    last = torch.nn.Linear(5, 1)
    file = tmp_path / "module.onnx"
    codrive_sim.save_policy(file, [module, (last.weight.detach().numpy().T, last.bias.detach().numpy())], envs)
    session = onnxruntime.InferenceSession(file)
    names = [one.name for one in session.get_inputs()]
    held = [np.zeros((1, 5), np.float32)] * (len(names) - 1)
    seen = np.random.default_rng(3).normal(size=(100, 1, len(envs.inputs))).astype(np.float32)
    with torch.no_grad():
        wanted = last(module(torch.as_tensor(seen))[0]).numpy()
    for hold in range(100):
        action, *held = session.run(None, dict(zip(names, [seen[hold], *held], strict=True)))
        # Sums of float32 in another order.
        assert np.allclose(action, wanted[hold], rtol=0.0, atol=1e-5)
    with pytest.raises(ValueError, match="in one direction"):
        codrive_sim.save_policy(file, [torch.nn.GRU(4, 5, bidirectional=True)], envs)
