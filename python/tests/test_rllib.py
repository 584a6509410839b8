"""Tests of evaluations of RLlib modules. They need PyTorch, several GB with its libraries. Where it cannot be imported, they are recorded
as not run (tests/not-run-here)."""

from dataclasses import asdict

import numpy as np
import pytest

import codrive_sim
from not_run import leave_out

SHORT = {"warm_up_s": 5.0, "horizon_s": 20.0, "driver": "perfect"}

try:
    import ray.rllib  # noqa: F401
    import torch
except ImportError:

    @pytest.fixture(autouse=True)
    def noted_as_not_run(request):
        leave_out(request, "rllib", "RLlib or torch is not installed")


class Algorithm:
    """Parts of RLlib's interface that ``evaluate`` uses."""

    def __init__(self, module):
        self.module = module

    def get_module(self):
        return self.module


def test_a_recurrent_module_keeps_its_state():
    from ray.rllib.algorithms.ppo.ppo_catalog import PPOCatalog
    from ray.rllib.algorithms.ppo.torch.default_ppo_torch_rl_module import DefaultPPOTorchRLModule
    from ray.rllib.core.rl_module.default_model_config import DefaultModelConfig

    env = codrive_sim.make(advice="speed", hold=2.0, **SHORT)
    torch.manual_seed(1)
    module = DefaultPPOTorchRLModule(
        observation_space=env.observation_space,
        action_space=env.action_space,
        model_config=asdict(DefaultModelConfig(use_lstm=True, lstm_cell_size=8, max_seq_len=4)),
        catalog_class=PPOCatalog,
    )

    def by_hand(keeps):
        begin = {key: part.unsqueeze(0).repeat(3, 1, 1) if part.dim() == 2 else part.unsqueeze(0).repeat(3, 1)
                 for key, part in module.get_initial_state().items()}
        states = [begin]

        def ask(seen):
            with torch.no_grad():
                given = module.forward_inference({"obs": torch.as_tensor(seen)[:, None], "state_in": states[-1] if keeps else begin})
            states.append(given["state_out"])
            return given["action_dist_inputs"][:, 0, :1].numpy()

        return list(codrive_sim.evaluate(ask, over=3, advice="speed", hold=2.0, **SHORT).mean_speed_mps)

    own = codrive_sim.evaluate(module, over=3, **SHORT)
    assert set(own.hold_s) == {2.0} and list(own.mean_speed_mps) == by_hand(True) != by_hand(False)


@pytest.mark.parametrize("levels", [0, 5])
def test_a_module_advises_what_its_network_says_without_exploring(levels):
    from ray.rllib.algorithms.ppo.ppo_catalog import PPOCatalog
    from ray.rllib.algorithms.ppo.torch.default_ppo_torch_rl_module import DefaultPPOTorchRLModule
    from ray.rllib.core.rl_module.default_model_config import DefaultModelConfig

    env = codrive_sim.make(levels=levels, **SHORT)
    torch.manual_seed(1)
    module = DefaultPPOTorchRLModule(
        observation_space=env.observation_space,
        action_space=env.action_space,
        model_config=asdict(DefaultModelConfig(fcnet_hiddens=[8], fcnet_activation="tanh", head_fcnet_hiddens=[], vf_share_layers=False)),
        catalog_class=PPOCatalog,
    )
    state = module.get_state()
    weights = [state[name] for name in state if name.startswith(("encoder.actor_encoder.net.", "pi.net."))]

    def network(seen):
        means = np.tanh(seen @ weights[0].T + weights[1]) @ weights[2].T + weights[3]
        return means.argmax(axis=1) if levels else means[:, :1]

    wanted = codrive_sim.evaluate(network, over=4, levels=levels, **SHORT).drop(columns="policy")
    for policy, name in ((module, "DefaultPPOTorchRLModule"), (Algorithm(module), "Algorithm")):
        given = codrive_sim.evaluate(policy, over=4, levels=levels, **SHORT)
        assert (given.policy == name).all()
        for column in ("mean_speed_mps", "settled_speed_mps", "min_gap_to_neighbours_m"):
            assert np.allclose(given[column], wanted[column], rtol=0.0, atol=1e-4)


def test_its_configuration_takes_our_ids():
    import gymnasium
    from ray.rllib.algorithms.ppo import PPOConfig
    from ray.tune.registry import register_env

    # Ray's workers do not import what the driver has imported; the environment's maker does.
    register_env("codrive/Ring250-v0", lambda settings: gymnasium.make("codrive_sim:codrive/Ring250-v0", **settings))
    config = PPOConfig().environment("codrive/Ring250-v0", env_config=SHORT).env_runners(num_env_runners=0)
    algorithm = config.training(train_batch_size_per_learner=64, minibatch_size=32, num_epochs=1).build_algo()
    # An episode of 20 holds at 0 to 10 m/s.
    assert 0.0 < algorithm.train()["env_runners"]["episode_return_mean"] < 200.0
    algorithm.stop()
