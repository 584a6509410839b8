"""Trains a policy for the 250 m ring with RLlib's PPO, with rings in several processes, on one machine or on a Ray cluster.

    pip install './python[ray]' 'ray[rllib]' torch
    python python/examples/rllib_ppo.py --runners 2 --out mine.onnx

Each env runner is a process with its own rings; on a cluster Ray places them on free cores.

Training ends when the mean speed of all vehicles on 20 unseen rings reaches ``--goal`` (3.0 m/s without advice), or after ``--updates``.
With two runners of 512 rings, on two shared cores, all of three seeds reached 4.0 m/s after 63 to 78 s (150 s in a later run) and 1.6 million
holds, and at most 4.03 to 4.07 m/s in 125 s; one of them fell back to 3.07 m/s in between. None reached 4.1.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import codrive_sim
import gymnasium
import numpy as np
import ray
import torch
from gymnasium.vector import AutoresetMode
from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.algorithms.ppo.torch.default_ppo_torch_rl_module import DefaultPPOTorchRLModule
from ray.rllib.core.rl_module.default_model_config import DefaultModelConfig
from ray.rllib.core.rl_module.rl_module import RLModuleSpec
from ray.tune.registry import register_env

#: Settings of advice and driver, as in train_sb3.py, which gives the reasons.
RING: dict[str, Any] = {
    "advice": "speed",
    "hold": 1.0,
    "driver": "perfect",
    "sees": "speed,leader_speed,gap,mean_speed",
    "range_penalty": 0.6,
}
HIDDEN = [64, 64]
#: Holds of each ring in an update.
HOLDS = 64
#: Discount: after 100 holds a reward counts 1/e.
GAMMA = 0.99
#: Logarithm of the first advice's standard deviation, which is then 3 m/s; with RLlib's 0, half of the advice lies outside 0 to 10 m/s.
FIRST_LOG_SD = -0.5


class Network(DefaultPPOTorchRLModule):
    """RLlib's network, with a standard deviation that does not depend on the observation and starts at ``FIRST_LOG_SD``."""

    def setup(self) -> None:
        """Builds the layers."""
        super().setup()
        torch.nn.init.constant_(self.pi.log_std, FIRST_LOG_SD)


class NextStep(gymnasium.vector.VectorWrapper):
    """Rings as RLlib steps them: a ring that has ended returns its last observation, and the first of the next episode a step later.

    codrive's rings continue in the same step. The first hold of an episode is therefore driven under the action that RLlib gives for the
    reset, and is not used for learning.

    Rewards are divided by 1 / (1 - gamma), so that a return is a mean speed, some m/s. A value of hundreds would take long to learn, and
    its error would dominate the gradient of bounded length.
    """

    def __init__(self, env: gymnasium.vector.VectorEnv) -> None:
        super().__init__(env)
        self.metadata = {**env.metadata, "autoreset_mode": AutoresetMode.NEXT_STEP}
        self._is_due = np.zeros(env.num_envs, np.bool_)

    def reset(self, **arguments: Any) -> tuple[np.ndarray, dict[str, Any]]:
        """Begins an episode in each ring."""
        self._is_due[:] = False
        return self.env.reset(**arguments)

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Drives one hold of every ring; rings that had ended begin an episode."""
        observations, rewards, terminations, truncations, infos = self.env.step(actions)
        ended = terminations | truncations
        for ring in np.flatnonzero(ended):
            observations[ring] = infos["final_obs"][ring]
        rewards[self._is_due] = 0.0
        # An episode that ends in its first hold has not been shown; the next one begins a step later.
        terminations[self._is_due] = truncations[self._is_due] = False
        self._is_due = ended
        return observations, rewards * (1.0 - GAMMA), terminations, truncations, {}


def rings(config: dict[str, Any]) -> gymnasium.vector.VectorEnv:
    """Makes the rings of one env runner. RLlib seeds them with the number of the runner."""
    return NextStep(codrive_sim.make_vec("ring-250", config["num_envs"], **RING))


def layers(weights: dict[str, np.ndarray]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Returns the policy network, for ``codrive_sim.save_policy``, with the mean as its only output."""
    parts = [weights[name] for name in weights if name.startswith(("encoder.actor_encoder.net.", "pi.net."))]
    return [(weight.T, bias) for weight, bias in zip(parts[::2], parts[1::2], strict=True)]


def main() -> int:
    """Runs the command line. Returns the exit status: 0 if the goal is reached, else 1."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runners", type=int, default=2, help="processes with rings [default: 2]")
    parser.add_argument("--envs", type=int, default=512, help="rings of each [default: 512]")
    parser.add_argument("--goal", type=float, default=4.0, help="mean speed to be reached, m/s [default: 4.0]")
    parser.add_argument("--updates", type=int, default=200, help="training ends after so many [default: 200]")
    parser.add_argument("--every", type=int, default=5, help="updates between two evaluations [default: 5]")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--address", help="of a Ray cluster [default: one on this machine]")
    parser.add_argument("--out", default="mine.onnx", help="file of the policy, NAME.onnx or NAME.toml [default: mine.onnx]")
    given = parser.parse_args()
    ray.init(address=given.address, log_to_driver=False, logging_level="error", runtime_env={"env_vars": {"RAYON_NUM_THREADS": "1"}})
    register_env("codrive-ring-250", rings)
    one = codrive_sim.make("ring-250", **RING)
    batch = HOLDS * given.runners * given.envs
    model = DefaultModelConfig(fcnet_hiddens=HIDDEN, fcnet_activation="tanh", vf_share_layers=False, head_fcnet_hiddens=[], free_log_std=True)
    config = (
        PPOConfig()
        .environment("codrive-ring-250", observation_space=one.observation_space, action_space=one.action_space)
        .env_runners(
            num_env_runners=given.runners,
            num_envs_per_env_runner=given.envs,
            gym_env_vectorize_mode=gymnasium.VectorizeMode.VECTOR_ENTRY_POINT,
            rollout_fragment_length=HOLDS,
        )
        .training(
            gamma=GAMMA,
            lambda_=1.0,
            # Decreases up to 2.5 million holds: large later updates would destroy learned behaviour.
            lr=[[0, 1e-3], [2_500_000, 1e-4]],
            clip_param=0.2,
            kl_target=0.02,
            vf_loss_coeff=0.5,
            vf_clip_param=float("inf"),
            grad_clip=0.5,
            train_batch_size_per_learner=batch,
            minibatch_size=min(8192, batch),
            shuffle_batch_per_epoch=True,
            num_epochs=10,
        )
        .rl_module(rl_module_spec=RLModuleSpec(module_class=Network, model_config=model))
        .debugging(seed=given.seed)
    )
    algorithm = config.build_algo()
    start, speed_mps = time.perf_counter(), 0.0
    for update in range(1, given.updates + 1):
        algorithm.train()
        if update % given.every == 0 or update == given.updates:
            table = codrive_sim.evaluate(algorithm, over=20, **RING)
            speed_mps = float(table.mean_speed_mps.mean())
            elapsed_s, holds = time.perf_counter() - start, update * batch
            print(f"{elapsed_s:.0f} s: {holds:,} holds, {speed_mps:.2f} m/s, {int(table.crashed.sum())} crashes", flush=True)
            if speed_mps >= given.goal:
                break
    codrive_sim.save_policy(given.out, layers(algorithm.get_module().get_state(inference_only=True)), one)
    print(f"{given.out}: codrive drive --policy {given.out}")
    algorithm.stop()
    ray.shutdown()
    return 0 if speed_mps >= given.goal else 1


if __name__ == "__main__":
    raise SystemExit(main())
