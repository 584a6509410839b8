"""Trains a policy for the 250 m ring with PPO of Stable-Baselines3 or TRPO of sb3-contrib, and writes a file for drives and studies.

    pip install './python[sb3]' sb3-contrib
    python python/examples/train_sb3.py --algorithm ppo --out mine.onnx
    codrive drive --policy mine.onnx

Training ends when the mean speed of all vehicles on 20 unseen rings reaches ``--goal``, over the whole 800 s of each, transients
included. The mean speed is 3.0 m/s without advice, and 4.36 m/s if all vehicles keep the same distance.

Learning on rings needs:

* Long rollouts, and advantages up to their end: a wave that is not fed dissolves after a minute, not after the next hold.
* A penalty on advice that the driver does not reach (``range_penalty``): above the leader's speed, all advice has the same effect, and a
  policy that begins there learns nothing.
* Rewards divided by the spread of returns: otherwise the error of the value, hundreds of m/s, dominates the gradient of bounded length.
* One thread for the network: layers of 64 are computed before a second thread starts, and waiting for it costs ten times as much. The
  rings use all cores themselves.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import codrive_sim
import codrive_sim.sb3
import torch
from sb3_contrib import TRPO
from stable_baselines3 import PPO
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

#: Settings of advice and driver: a speed for one second, and a driver who reaches it without delay if the vehicle ahead allows it.
RING: dict[str, Any] = {
    "advice": "speed",
    "hold": 1.0,
    "driver": "perfect",
    "sees": "speed,leader_speed,gap,mean_speed",
    "range_penalty": 0.6,
}
#: Discount: after 100 holds of 1 s a reward counts 1/e, as is usual (0.999 for each 0.1 s).
GAMMA = 0.99
#: Logarithm of the first advice's standard deviation, which is then 3 m/s; with SB3's 0, half of the advice lies outside 0 to 10 m/s.
FIRST_LOG_SD = -0.5


class UntilFastEnough(BaseCallback):
    """Evaluates the policy every few updates, and ends training at the goal or at the time limit."""

    def __init__(self, goal_mps: float, limit_s: float, every: int) -> None:
        super().__init__()
        self.goal_mps, self.limit_s, self.every = goal_mps, limit_s, every
        self.speed_mps = 0.0
        self._updates = 0
        self._start, self._start_cpu = time.perf_counter(), time.process_time()

    @property
    def elapsed(self) -> str:
        """Returns the time since training began, as text."""
        seconds, cpu = time.perf_counter() - self._start, time.process_time() - self._start_cpu
        return f"{seconds:.0f} s, {cpu:.0f} CPU-seconds"

    def _on_rollout_start(self) -> None:
        if self._updates and self._updates % self.every == 0:
            table = codrive_sim.evaluate(self.model, over=20, **RING)
            self.speed_mps = float(table.mean_speed_mps.mean())
            print(f"{self.elapsed}: {self.num_timesteps:,} steps, {self.speed_mps:.2f} m/s, {int(table.crashed.sum())} crashes", flush=True)
        self._updates += 1

    def _on_step(self) -> bool:
        return self.speed_mps < self.goal_mps and time.perf_counter() - self._start < self.limit_s


def learner(algorithm: str, envs: VecEnv, seed: int) -> BaseAlgorithm:
    """Returns PPO or TRPO with parameters for a thousand rings."""
    common = {
        "n_steps": 64,
        "batch_size": 8192,
        "gamma": GAMMA,
        "gae_lambda": 1.0,
        "policy_kwargs": {"log_std_init": FIRST_LOG_SD},
        "seed": seed,
        "device": "cpu",
    }
    if algorithm == "trpo":
        return TRPO("MlpPolicy", envs, learning_rate=2e-3, n_critic_updates=5, **common)
    return PPO("MlpPolicy", envs, learning_rate=5e-4, n_epochs=10, target_kl=0.02, **common)


def main() -> int:
    """Runs the command line. Returns the exit status: 0 if the goal is reached, else 1."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--algorithm", choices=["ppo", "trpo"], default="ppo")
    parser.add_argument("--envs", type=int, default=1024, help="rings side by side [default: 1024]")
    parser.add_argument("--goal", type=float, default=4.1, help="mean speed to be reached, m/s [default: 4.1]")
    parser.add_argument("--limit", type=float, default=900.0, help="training ends after so many seconds [default: 900]")
    parser.add_argument("--every", type=int, default=5, help="updates between two evaluations [default: 5]")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", default="mine.onnx", help="file of the policy, NAME.onnx or NAME.toml [default: mine.onnx]")
    given = parser.parse_args()
    torch.set_num_threads(1)
    rings = codrive_sim.sb3.VecEnv("ring-250", num_envs=given.envs, **RING)
    model = learner(given.algorithm, VecNormalize(rings, norm_obs=False, gamma=GAMMA), given.seed)
    judge = UntilFastEnough(given.goal, given.limit, given.every)
    # The callback ends training.
    model.learn(10**12, callback=judge)
    is_reached = judge.speed_mps >= given.goal
    print(f"{given.algorithm}, {given.envs} rings: {judge.speed_mps:.2f} m/s after {judge.elapsed}")
    codrive_sim.save_policy(given.out, codrive_sim.sb3.layers(model), rings)
    print(f"{given.out}: codrive drive --policy {given.out}")
    return 0 if is_reached else 1


if __name__ == "__main__":
    raise SystemExit(main())
