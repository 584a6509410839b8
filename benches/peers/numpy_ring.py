"""256 rings of 22 IDM vehicles side by side in numpy, noise included: the peer of the fast ring.

Prints environment steps and vehicle updates a second, the median of seven blocks.
"""

import statistics
import time

import numpy as np

RINGS, CARS, LENGTH_M, STEP_S = 256, 22, 250.0, 0.1
V0, T, A, B, S0, NOISE = 30.0, 1.0, 1.0, 1.5, 2.0, 0.2
CAR_M = 5.0


def step(place, speed, rng, approach=1.0 / (2.0 * np.sqrt(A * B))):
    """Computes all accelerations from one state, then speeds, then positions (Flow's order)."""
    gap = (np.roll(place, -1, axis=1) - place) % LENGTH_M - CAR_M
    lead = np.roll(speed, -1, axis=1)
    desired = S0 + np.maximum(0.0, speed * T + speed * (speed - lead) * approach)
    accel = A * (1.0 - (speed / V0) ** 4 - (desired / gap) ** 2)
    accel += np.sqrt(STEP_S) * NOISE * rng.standard_normal(speed.shape)
    speed = np.maximum(speed + accel * STEP_S, 0.0)
    return (place + speed * STEP_S) % LENGTH_M, speed


def main(steps=2000, blocks=7):
    rng = np.random.default_rng(1)
    place = np.tile(np.arange(CARS) * LENGTH_M / CARS, (RINGS, 1))
    speed = np.zeros_like(place)
    rates = []
    for _ in range(blocks):
        begin = time.perf_counter()
        for _ in range(steps):
            place, speed = step(place, speed, rng)
        rates.append(steps * RINGS / (time.perf_counter() - begin))
    rate = statistics.median(rates)
    print(f"numpy {np.__version__}: {rate / 1e6:.2f} million env steps/s, {rate * CARS / 1e6:.1f} million vehicle updates/s")


if __name__ == "__main__":
    main()
