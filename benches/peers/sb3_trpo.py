"""sb3-contrib's TRPO on 16 numpy rings, batch 16,000, nets 64-64: the peer of `codrive train`.

Prints the time of an iteration and of the update in it, medians over the iterations after the first.
"""

import statistics
import time

import gymnasium as gym
import numpy as np
from numpy_ring import CAR_M, CARS, LENGTH_M, STEP_S, A, B, NOISE, S0, T, V0
from sb3_contrib import TRPO
from stable_baselines3.common.vec_env import VecEnv

RINGS, HOLD, HORIZON = 16, 10, 800


class Rings(VecEnv):
    """Rings in which vehicle 0 takes the action, an acceleration of at most 0.5 m/s2 for one second."""

    def __init__(self):
        box = gym.spaces.Box
        super().__init__(RINGS, box(-1, 1, (4,), np.float32), box(-1, 1, (1,), np.float32))
        self.rng = np.random.default_rng(1)
        self.reset()

    def reset(self):
        self.place = np.tile(np.arange(CARS) * LENGTH_M / CARS, (RINGS, 1))
        self.speed = np.zeros((RINGS, CARS))
        self.count = 0
        return self.see()

    def gaps(self):
        return (np.roll(self.place, -1, axis=1) - self.place) % LENGTH_M - CAR_M

    def see(self):
        columns = [self.speed[:, 0] / 5 - 1, self.speed[:, 1] / 5 - 1, self.gaps()[:, 0] / 15 - 1, np.zeros(RINGS)]
        return np.stack(columns, axis=1).astype(np.float32)

    def step_async(self, actions):
        self.actions = actions

    def step_wait(self):
        reward = np.zeros(RINGS)
        for _ in range(HOLD):
            lead = np.roll(self.speed, -1, axis=1)
            closing = self.speed * (self.speed - lead) / (2 * np.sqrt(A * B))
            desired = S0 + np.maximum(0, self.speed * T + closing)
            accel = A * (1 - (self.speed / V0) ** 4 - (desired / np.maximum(self.gaps(), 0.1)) ** 2)
            accel += np.sqrt(STEP_S) * NOISE * self.rng.standard_normal(self.speed.shape)
            accel[:, 0] = np.where(self.gaps()[:, 0] > 1, 0.5 * self.actions[:, 0], -4.5)
            self.speed = np.maximum(self.speed + accel * STEP_S, 0)
            self.place = (self.place + self.speed * STEP_S) % LENGTH_M
            reward += self.speed.mean(axis=1) / HOLD
        self.count += 1
        done = np.full(RINGS, self.count % HORIZON == 0)
        seen = self.see()
        infos = [{"terminal_observation": seen[i]} if done[i] else {} for i in range(RINGS)]
        return (self.reset() if done.any() else seen), reward.astype(np.float32), done, infos

    def close(self):
        pass

    def get_attr(self, name, indices=None):
        return [getattr(self, name, None)] * RINGS

    def set_attr(self, name, value, indices=None):
        pass

    def env_method(self, name, *arguments, indices=None, **named):
        return [None] * RINGS

    def env_is_wrapped(self, wrapper, indices=None):
        return [False] * RINGS


def main(iterations=8):
    model = TRPO("MlpPolicy", Rings(), n_steps=1000, gamma=0.99, gae_lambda=1.0, target_kl=0.01,
                 policy_kwargs={"net_arch": {"pi": [64, 64], "vf": [64, 64]}}, batch_size=1000, n_critic_updates=5)
    updates, train = [], model.train

    def timed():
        begin = time.perf_counter()
        train()
        updates.append(time.perf_counter() - begin)

    model.train = timed
    begin = time.perf_counter()
    model.learn(16_000 * iterations)
    each = (time.perf_counter() - begin) / iterations
    print(f"sb3-contrib TRPO: {each:.2f} s an iteration, of which {statistics.median(updates[1:]):.2f} s the update")


if __name__ == "__main__":
    main()
