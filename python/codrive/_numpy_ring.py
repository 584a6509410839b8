"""The ring of the fast engine in numpy: what the benchmark compares with. The intelligent driver model (Treiber, Hennecke, Helbing 2000)
with Flow's noise, SI units."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from codrive._settings import settings

#: Bounds of the engine: hardest braking, m/s2, and the acceleration below which a standing car stays, m/s2.
_EMERGENCY_MPS2 = 9.0
_CREEP_MPS2 = 1e-4
_CAR_M = 5.0


class NumpyRing:
    """Rings side by side, each of evenly spaced cars that begin at a standstill; row 0 is the advised car, row k the k-th behind it."""

    def __init__(self, rings: int, seed: int, noise: float | None = None) -> None:
        """``noise`` is that of the accelerations, m/s2 per root second; None: the ring's own."""
        own = settings("ring-250")
        idm, cars = own["idm"], own["vehicles_min"]
        self.step_s = own["step_s"]
        self._v0, self._t, self._a, self._s0 = (idm[key] for key in ("v0", "T", "a", "s0"))
        self._approach = 0.5 / np.sqrt(idm["a"] * idm["b"])
        noise = idm["noise"] if noise is None else noise
        self._noise_mps = np.float32(noise * np.sqrt(self.step_s) * self.step_s)
        self._rng = np.random.default_rng(seed)
        self.gap_m = np.full((cars, rings), own["circumference_min_m"] / cars - _CAR_M, np.float32)
        self.speed_mps = np.zeros((cars, rings), np.float32)

    def step(self, accel_mps2: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """One step in which the advised cars keep these accelerations, ``(rings,)``. Speeds, leaders' speeds and gaps of the advised
        cars, ``(rings, 3)``, and the mean speeds of all cars, ``(rings,)``."""
        speed = self.speed_mps
        ahead = np.roll(speed, 1, axis=0)
        desired = self._s0 + np.maximum(speed * self._t + speed * (speed - ahead) * self._approach, 0.0)
        free = speed / self._v0
        free *= free
        interaction = desired / np.maximum(self.gap_m, 1e-3)
        accel = np.maximum(self._a * (1.0 - free * free - interaction * interaction), -_EMERGENCY_MPS2)
        wanted = speed + accel * self.step_s
        chosen = np.where(wanted < _CREEP_MPS2 * self.step_s, np.float32(0.0), wanted)
        noise = self._rng.standard_normal(speed.shape, dtype=np.float32) * self._noise_mps
        after = np.where(chosen > 0.0, np.maximum(chosen + noise, 0.0), np.float32(0.0))
        chosen[0] = after[0] = np.maximum(speed[0] + accel_mps2 * self.step_s, 0.0)
        self.gap_m += (np.roll(chosen, 1, axis=0) - chosen) * self.step_s
        self.speed_mps = after
        return np.stack([after[0], after[-1], self.gap_m[0]], axis=1), after.mean(axis=0)
