"""Training of a benchmark's policy by CMA-ES on its reward. All controlled vehicles, edges or lights share the weights of some features of the
observation (``_policies.py``), so that a hundred episodes suffice.

A training goes on from its checkpoint with the same bits. The checkpoint has the results of all episodes so far, and CMA-ES comes to the same
state when it is told them again, as its random numbers depend on the seed alone.
"""

from __future__ import annotations

import hashlib
import json
import types
from typing import Any

import numpy as np

from codrive_sim._run_store import Checkpoint
from codrive_sim._traffic_env import TrafficEnv
from codrive_sim.benchmarks import SharedPolicy, named, weight_count

#: Episodes of a generation.
POPULATION = 10
#: Standard deviation of the first generation's weights around 0.
_FIRST_SD = 1.0
#: Seeds of episodes for each seed of a training. Those of trainings are below 100,000, those of evaluations above.
_SEEDS_EACH = 1000

#: Mean reward over the horizon and evaluation of each episode, by generation.
History = list[list[tuple[float, float]]]


def library() -> types.ModuleType:
    """Returns the library of CMA-ES.

    Raises:
        ImportError: It is not installed.
    """
    try:
        import cma
    except ImportError:
        raise ImportError("trainings of the benchmarks need the package cma: pip install './python[benchmarks]'") from None
    return cma


def train(benchmark: str, seed: int = 1, episodes: int = 100, actions: int = 0, checkpoint: Checkpoint | None = None) -> dict[str, Any]:
    """Trains a policy in this process, on one core.

    Args:
        benchmark: Name of the benchmark, such as ``"Flow-Merge-v1"``.
        seed: Seed of the training, 1 to 99.
        episodes: Number of episodes; it is rounded up to whole generations of 10.
        actions: Actions of an episode, for a trial; 0: up to its horizon.
        checkpoint: Checkpoint that is kept after each generation, and from which the training goes on.

    Returns:
        ``benchmark``, ``seed``, ``episodes`` and ``weights``, as files of policies have them; and ``curve`` with the reward and the evaluation of
        each generation's best episode.

    Raises:
        ValueError: There is no such benchmark.
        ImportError: The package cma is not installed.
    """
    env = named(benchmark).make(own_process=False)
    try:
        # The stream of numpy's global functions after this seed, but for this search alone.
        random = np.random.RandomState(seed)
        options = {"randn": random.randn, "seed": np.nan, "popsize": POPULATION, "verbose": -9}
        search = library().CMAEvolutionStrategy(np.zeros(weight_count(env)), _FIRST_SD, options)
        generations = -(-episodes // POPULATION)
        history = _continued(checkpoint, generations)
        for generation in range(generations):
            candidates = search.ask()
            if generation == len(history):
                # All candidates of a generation drive in the same traffic.
                history.append([_episode(env, weights, _SEEDS_EACH * seed + generation, actions) for weights in candidates])
                _save(checkpoint, history)
            search.tell(candidates, [-reward for reward, _ in history[generation]])
    finally:
        env.close()
    return {
        "benchmark": benchmark,
        "seed": seed,
        "episodes": POPULATION * generations,
        "weights": [round(float(weight), 6) for weight in search.result.xfavorite],
        "curve": [max(results) for results in history],
    }


def _episode(env: TrafficEnv, weights: Any, seed: int, most: int) -> tuple[float, float]:
    """Drives an episode of at most ``most`` actions; 0 is no bound. Returns its mean reward over the horizon, and its evaluation."""
    policy = SharedPolicy(env, weights)
    observation, _ = env.reset(seed=seed)
    total, is_over, actions, info = 0.0, False, 0, {"evaluation": 0.0}
    while not is_over and (most == 0 or actions < most):
        observation, reward, terminated, truncated, info = env.step(policy.action(observation))
        total += float(reward)
        is_over, actions = terminated or truncated, actions + 1
    return total / env.timing.horizon, float(info["evaluation"])


def _save(checkpoint: Checkpoint | None, history: History) -> None:
    """Keeps the history with its SHA-256. A checkpoint that cannot be written costs time only."""
    if checkpoint is None:
        return
    state = json.dumps(history).encode()
    try:
        checkpoint.save(hashlib.sha256(state).hexdigest().encode() + b"\n" + state)
    except (OSError, RuntimeError) as why:
        checkpoint.report(f"warning: no checkpoint is kept: {why}")


def _continued(checkpoint: Checkpoint | None, generations: int) -> History:
    """Returns the history of the checkpoint; an empty one if there is none or it cannot be used, which is reported."""
    if checkpoint is None:
        return []
    try:
        kept = checkpoint.load()
        if kept is None:
            return []
        digest, _, state = kept.partition(b"\n")
        if digest != hashlib.sha256(state).hexdigest().encode():
            raise ValueError("damaged")
        history: History = [[(reward, evaluation) for reward, evaluation in results] for results in json.loads(state)]
        if len(history) > generations or any(len(results) != POPULATION for results in history):
            raise ValueError("not a checkpoint of this version")
    except (OSError, ValueError, TypeError, RuntimeError) as why:
        checkpoint.report(f"warning: the checkpoint is ignored and the training starts anew: {why}")
        return []
    checkpoint.report(f"continues from its checkpoint after generation {len(history)} of {generations}")
    return history
