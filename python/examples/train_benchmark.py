"""Trains a policy for a benchmark by CMA-ES on its reward, and writes the weights for `python -m codrive.benchmarks --policies FOLDER`.

    pip install './python[sumo]' cma
    python python/examples/train_benchmark.py Flow-Merge-v1 --seed 1 --rollouts 100 --out trained

All controlled vehicles share the weights of some features of the observation (codrive/benchmarks/_policies.py), so that a hundred episodes
suffice. The training takes one core: train several seeds or benchmarks at once to use more. Ctrl-C ends it and writes what was found.
"""

from __future__ import annotations

import argparse
import json
import pathlib

import cma
import gymnasium
import numpy as np

import codrive  # noqa: F401  (registers the benchmarks)
from codrive.benchmarks import BENCHMARKS, SharedPolicy, weight_count


def episode(env: gymnasium.Env, policy: SharedPolicy, seed: int) -> tuple[float, float]:
    """Drives an episode. Returns its mean reward over the horizon, and its evaluation."""
    observation, _ = env.reset(seed=seed)
    total, is_over, info = 0.0, False, {"evaluation": 0.0}
    while not is_over:
        observation, reward, terminated, truncated, info = env.step(policy.action(observation))
        total += float(reward)
        is_over = terminated or truncated
    return total / env.unwrapped.timing.horizon, float(info["evaluation"])


def main() -> None:
    """Trains by the arguments of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    names = [benchmark.name for benchmark in BENCHMARKS]
    parser.add_argument("benchmark", choices=names, metavar="BENCHMARK", help=", ".join(names))
    parser.add_argument("--seed", type=int, default=1, help="seed of the training")
    parser.add_argument("--rollouts", type=int, default=100, help="episodes of the training")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("trained"), help="folder of the policies")
    arguments = parser.parse_args()

    env = gymnasium.make(f"codrive/{arguments.benchmark}", own_process=False)
    base = env.unwrapped
    search = cma.CMAEvolutionStrategy(np.zeros(weight_count(base)), 1.0, {"seed": arguments.seed, "popsize": 10, "verbose": -9})
    done = generation = 0
    try:
        while done < arguments.rollouts:
            candidates = search.ask()
            # All candidates of a generation drive in the same traffic. Seeds of trainings are below 100,000, those of evaluations above.
            seed = 1000 * arguments.seed + generation
            results = [episode(env, SharedPolicy(base, weights), seed) for weights in candidates]
            search.tell(candidates, [-reward for reward, _ in results])
            done, generation = done + len(candidates), generation + 1
            best = max(results)
            print(f"{arguments.benchmark}.{arguments.seed}: {done} episodes, best reward {best[0]:.4f}, evaluation {best[1]:.2f}", flush=True)
    except KeyboardInterrupt:
        print("ended by Ctrl-C")
    arguments.out.mkdir(parents=True, exist_ok=True)
    file = arguments.out / f"{arguments.benchmark}.{arguments.seed}.json"
    weights = [round(float(weight), 6) for weight in search.result.xfavorite]
    file.write_text(json.dumps({"benchmark": arguments.benchmark, "seed": arguments.seed, "episodes": done, "weights": weights}) + "\n")
    print(f"{file}: {done} episodes")


if __name__ == "__main__":
    main()
