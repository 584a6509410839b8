"""Ring of the fast engine in numpy, with a driver who follows the advice, as a reference for the benchmark. It uses the intelligent driver
model (Treiber, Hennecke, Helbing 2000) with Flow's noise, SI units."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from codrive_sim._settings import settings

#: Limits of the engine: hardest braking, m/s2, and the acceleration below which a stationary vehicle stays, m/s2.
_EMERGENCY_MPS2 = 9.0
_CREEP_MPS2 = 1e-4
_CAR_M = 5.0
#: Time in which a driver closes the difference to the advised speed, s, and time over which they estimate a leader's braking, s.
_RELAXATION_S = 1.5
_JUDGED_S = 0.2
#: Maximum difference of the advised speed from the present speed, m/s.
_LEAD_MPS = 1.0


class NumpyRing:
    """Rings side by side, each of evenly spaced vehicles that start from rest; row 0 is the advised vehicle, row k the k-th behind it."""

    def __init__(self, rings: int, seed: int, noise: float | None = None, driver: dict[str, Any] | None = None) -> None:
        """Creates the rings at rest. ``noise`` is the noise of the accelerations, m/s2 per root second; None: the ring's own. ``driver``
        has parameters of a driver by their names in ``codrive_sim.settings()``; None: the ego follows the advice exactly."""
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
        self._driver = None if driver is None else _Driver(rings, self.step_s, {**own, **driver}, self._rng)

    def step(self, accel_mps2: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Makes one step with these advised accelerations, ``(rings,)``. Returns speeds, leaders' speeds and gaps of the advised vehicles,
        ``(rings, 3)``, and the mean speeds of all vehicles, ``(rings,)``."""
        speed = self.speed_mps
        ahead = np.roll(speed, 1, axis=0)
        accel = self._model(speed, ahead, self.gap_m)
        wanted = speed + accel * self.step_s
        chosen = np.where(wanted < _CREEP_MPS2 * self.step_s, np.float32(0.0), wanted)
        noise = self._rng.standard_normal(speed.shape, dtype=np.float32) * self._noise_mps
        after = np.where(chosen > 0.0, np.maximum(chosen + noise, 0.0), np.float32(0.0))
        if self._driver is not None:
            gap_m, leader_mps = self._driver.sees(self.gap_m[0], ahead[0])
            accel_mps2 = np.minimum(self._driver.follows(accel_mps2, speed[0]), self._model(speed[0], leader_mps, gap_m))
        chosen[0] = after[0] = np.maximum(speed[0] + accel_mps2 * self.step_s, 0.0)
        if self._driver is not None:
            self._driver.way_m = self._driver.way_m + after[0] * self.step_s
        self.gap_m += (np.roll(chosen, 1, axis=0) - chosen) * self.step_s
        self.speed_mps = after
        return np.stack([after[0], after[-1], self.gap_m[0]], axis=1), after.mean(axis=0)

    def _model(
        self, speed: NDArray[np.float32], ahead: NDArray[np.float32], gap_m: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        desired = self._s0 + np.maximum(speed * self._t + speed * (speed - ahead) * self._approach, 0.0)
        free = speed / self._v0
        free *= free
        interaction = desired / np.maximum(gap_m, 1e-3)
        return np.maximum(self._a * (1.0 - free * free - interaction * interaction), -_EMERGENCY_MPS2)


class _Driver:
    """Drivers with a reaction time for advice and leader, a speed error that varies slowly, and a speed bias."""

    def __init__(self, rings: int, step_s: float, own: dict[str, Any], rng: np.random.Generator) -> None:
        self._step_s, self._rng, self._rings = step_s, rng, np.arange(rings)
        draws = rng.uniform(0.0, 1.0, (2, rings)) if own["random_driver"] else np.ones((2, rings))
        self._late = np.round(own["reaction_s"] * draws[0] / step_s).astype(int)
        self._sees_late = np.round(own["leader_reaction_s"] * draws[0] / step_s).astype(int)
        error_mps = own["error_mps"] * draws[1]
        self._habit_mps = np.full(rings, own["speed_bias_mps"], np.float32)
        self._deadband_mps = own["deadband_mps"]
        self._keep = np.float32(np.exp(-step_s / own["error_time_s"]))
        self._fresh_mps = (error_mps * np.sqrt(1.0 - self._keep**2)).astype(np.float32)
        self._error_mps = (error_mps * rng.standard_normal(rings)).astype(np.float32)
        self._accel_mps2, self._decel_mps2 = own["ego_accel_mps2"], own["ego_decel_mps2"]
        self._judged = max(round(_JUDGED_S / step_s), 1)
        # Ring buffers over time.
        longest = int(max(self._late.max(), self._sees_late.max())) + self._judged + 1
        self._shown_mps = np.full((longest, rings), -1.0, np.float32)
        self._seen = np.zeros((longest, 3, rings), np.float32)
        self._steps = 0
        self._advised_mps: NDArray[np.float32] | None = None
        self.way_m = np.zeros(rings, np.float32)

    def sees(self, gap_m: NDArray[np.float32], leader_mps: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Returns gaps and leaders' speeds of a reaction time ago, extrapolated to now (Treiber, Kesting, Helbing 2006)."""
        size = len(self._seen)
        newest = self._steps % size
        self._seen[newest] = gap_m, leader_mps, self.way_m
        late = np.minimum(self._sees_late, self._steps)
        gap_then_m, then_mps, way_then_m = self._seen[(newest - late) % size, :, self._rings].T
        before_mps = self._seen[(newest - late - self._judged) % size, 1, self._rings]
        braked = np.clip((before_mps - then_mps) / (self._judged * self._step_s), 0.0, _EMERGENCY_MPS2)
        brake_mps2 = np.where(self._steps >= late + self._judged, braked, np.float32(0.0))
        late_s = (late * self._step_s).astype(np.float32)
        standstill_wait_s = then_mps / np.maximum(brake_mps2, 1e-9)
        braked_s = np.where(brake_mps2 > 0.0, np.minimum(late_s, standstill_wait_s), late_s)
        now_mps = np.maximum(then_mps - brake_mps2 * braked_s, 0.0)
        return gap_then_m + (then_mps + now_mps) / 2.0 * braked_s - (self.way_m - way_then_m), now_mps

    def follows(self, accel_mps2: NDArray[np.float32], speed: NDArray[np.float32]) -> NDArray[np.float32]:
        """Returns the accelerations to the advice of a reaction time ago; infinite if there was none."""
        begun_from = speed if self._advised_mps is None else np.clip(self._advised_mps, speed - _LEAD_MPS, speed + _LEAD_MPS)
        self._advised_mps = np.maximum(begun_from + accel_mps2 * np.float32(self._step_s), 0.0)
        size = len(self._shown_mps)
        newest = self._steps % size
        self._shown_mps[newest] = self._advised_mps
        self._steps += 1
        self._error_mps = self._error_mps * self._keep + self._fresh_mps * self._rng.standard_normal(len(speed), dtype=np.float32)
        shown = self._shown_mps[(newest - self._late) % size, self._rings]
        off = np.maximum(shown + (self._habit_mps + self._error_mps) * np.minimum(shown, 1.0), 0.0) - speed
        felt = off - np.clip(off, -self._deadband_mps, self._deadband_mps)
        return np.where(shown < 0.0, np.float32(np.inf), np.clip(felt / _RELAXATION_S, -self._decel_mps2, self._accel_mps2))
