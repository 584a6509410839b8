"""Whole drive as an environment of Gymnasium: vehicle physics, the driver, and traffic by SUMO or the native engine."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from codrive_sim._camera import POSSIBLE_MODES, Camera, picture_metadata
from codrive_sim._codrive import DriveConfiguration
from codrive_sim._drive_series import DriveSeries, Setup, check_one_advised
from codrive_sim._open_drive import OpenDrive
from codrive_sim._spaces import AdviceMeaning, Picklable, as_float32, check_actions, spaces
from codrive_sim._traffic import OwnFunctions, hold_info


class DriveEnv(OpenDrive, Picklable, AdviceMeaning, gymnasium.Env):
    """Whole drive: the participant's vehicle with its physics, a simulated driver who follows the advice, other traffic.

    Observations, actions, rewards and endings are as in ``codrive_sim.RingEnv``. **Terminated** is also true when the participant's vehicle
    reaches the end of its path. ``reset(seed=s)`` begins the drive of seed ``s``; ``reset()`` begins the next one of the series that the
    last seed started. After an episode has ended, call ``reset`` before the next ``step``.

    With SUMO the drive runs in a process of its own, which ``reset`` starts and which ends with ``close`` or with the environment. If the
    process is lost, ``step`` raises ``RuntimeError``, and ``reset`` starts another. With ``own_process=False`` it runs in this process.

    ``participant=False`` on a closed road gives the ego a light body (docs/python.md).
    """

    metadata = {"render_modes": POSSIBLE_MODES}

    def __init__(
        self,
        name: str = "ring-250",
        *,
        traffic: str | None = None,
        hold: float | None = None,
        advice: str | None = None,
        driver: str | None = None,
        own_process: bool = True,
        render_mode: str | None = None,
        view: str | None = None,
        size: tuple[int, int] = (1280, 720),
        **settings: Any,
    ) -> None:
        """See ``codrive_sim.make``."""
        camera = Camera(render_mode, view, size)
        check_one_advised(settings)
        own = OwnFunctions.taken_from(settings)
        setup = Setup(name, traffic, hold, advice, driver, settings, own_process)
        self.render_mode = render_mode
        self.settings: DriveConfiguration = setup.configuration
        self.observation_space, self.action_space = spaces(self.settings, own.space)
        self.metadata = picture_metadata(setup.hold_s)
        self._series = DriveSeries(setup, camera, own)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[Any], dict[str, Any]]:
        """Begins an episode. Returns the observation, float32, ``(k,)``, and an empty dict.

        Raises:
            ValueError: The settings or the seed allow no drive.
            RuntimeError: The drive has failed.
        """
        seed = self._series.first_seed(seed)
        super().reset(seed=seed)
        observed = self._series.begin(seed)
        if len(observed.agents) != 1:
            self._series.fail()
            raise RuntimeError(f"{len(observed.agents)} vehicles are advised; allowed: the participant's vehicle only")
        return observed.observations[0], {}

    def step(self, action: Any) -> tuple[NDArray[Any], float, bool, bool, dict[str, Any]]:
        """Drives one hold under this action, ``(1,)``, or the number of a level.

        Raises:
            ValueError: The action has another shape, is NaN or is out of range.
            ResetNeeded: No episode has begun, or it has ended.
            RuntimeError: The drive has failed.
        """
        self._series.check_step()
        levels = self.settings.levels
        actions = as_float32(action, levels, () if levels else (1,))
        check_actions(actions, levels, lambda _: "")
        result = self._series.hold(actions)
        terminated = bool(result.terminations[0])
        truncated = result.is_truncated and not terminated
        if terminated or truncated:
            self._series.end()
        info = hold_info(result)
        return result.final_observations[0], float(result.rewards[0]), terminated, truncated, info

    def set_state(self, state: dict[str, Any]) -> NDArray[Any]:
        """Drives again to a state that ``get_state`` of an environment with the same settings has returned. Returns the observation there.

        The bits are those of the first drive; it takes as long as that drive has taken.

        Raises:
            ValueError: This is no state, or that of other settings.
        """
        return self._series.set_state(state).observations[0]
