"""Trains a policy for the 250 m ring by PPO of Stable-Baselines3 or TRPO of sb3-contrib, and writes it as a file that drives and studies take.

    pip install './python[sb3]' sb3-contrib
    python python/examples/train_sb3.py --algorithm ppo --out mine.onnx
    codrive drive --policy mine.onnx

It ends when all cars of 20 rings that training has not seen go as fast as ``--goal`` on average, over the whole 800 s of each, transients
included. Without advice it is 3.0 m/s, and 4.36 where all keep the same distance.

What it takes to learn here:

* Long rollouts and advantages that look to their end: a wave that is not fed is gone after a minute, not after the next hold.
* A penalty on advice that the driver does not reach (``range_penalty``): above his leader's speed all advice is the same to him, and a
  policy that begins there learns nothing.
* Rewards divided by the spread of returns: else the error of the value, hundreds of m/s, takes all of the gradient's bounded length.
* One thread for the network: its layers of 64 are done before a second one has begun, and waiting for it costs ten times as much. The rings
  take all cores for themselves.
"""

from __future__ import annotations

import argparse
import time

import codrive
import codrive.sb3
import torch
from sb3_contrib import TRPO
from stable_baselines3 import PPO
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

#: What is advised, and who follows: a speed for a second; a driver who reaches it without delay where the car ahead lets him.
RING = {
    "advice": "speed",
    "hold": 1.0,
    "driver": "perfect",
    "sees": "speed,leader_speed,gap,mean_speed",
    "range_penalty": 0.6,
}
#: Time after which a reward counts 1/e is 100 holds of 1 s, as the field has it (0.999 for each 0.1 s).
GAMMA = 0.99
#: Of the first advice, 3 m/s: with SB3's 0 half of it lies beyond 0 and 10 m/s.
FIRST_LOG_SD = -0.5


class UntilFastEnough(BaseCallback):
    """Judges the policy every few updates, and ends training at the goal or at the limit of time."""

    def __init__(self, goal_mps: float, limit_s: float, every: int) -> None:
        super().__init__()
        self.goal_mps, self.limit_s, self.every = goal_mps, limit_s, every
        self.speed_mps = 0.0
        self._updates = 0
        self._start, self._start_cpu = time.perf_counter(), time.process_time()

    @property
    def elapsed(self) -> str:
        """Time since training began."""
        seconds, cpu = time.perf_counter() - self._start, time.process_time() - self._start_cpu
        return f"{seconds:.0f} s, {cpu:.0f} CPU-seconds"

    def _on_rollout_start(self) -> None:
        if self._updates and self._updates % self.every == 0:
            table = codrive.evaluate(self.model, over=20, **RING)
            self.speed_mps = float(table.mean_speed_mps.mean())
            print(f"{self.elapsed}: {self.num_timesteps:,} steps, {self.speed_mps:.2f} m/s, {int(table.crashed.sum())} crashes", flush=True)
        self._updates += 1

    def _on_step(self) -> bool:
        return self.speed_mps < self.goal_mps and time.perf_counter() - self._start < self.limit_s


def learner(algorithm: str, envs: VecEnv, seed: int) -> BaseAlgorithm:
    """PPO or TRPO with what suits a thousand rings."""
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
    """The command. Gives its exit status: 0 the goal is reached, 1 it is not."""
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
    rings = codrive.sb3.VecEnv("ring-250", num_envs=given.envs, **RING)
    model = learner(given.algorithm, VecNormalize(rings, norm_obs=False, gamma=GAMMA), given.seed)
    judge = UntilFastEnough(given.goal, given.limit, given.every)
    # As long as the judge lets it.
    model.learn(10**12, callback=judge)
    is_reached = judge.speed_mps >= given.goal
    print(f"{given.algorithm}, {given.envs} rings: {judge.speed_mps:.2f} m/s after {judge.elapsed}")
    codrive.save_policy(given.out, codrive.sb3.layers(model), rings)
    print(f"{given.out}: codrive drive --policy {given.out}")
    return 0 if is_reached else 1


if __name__ == "__main__":
    raise SystemExit(main())
