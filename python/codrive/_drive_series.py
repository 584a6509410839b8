"""Settings and pictures of whole drives, and series of drives."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from codrive._codrive import HAS_DESKTOP
from codrive._drives import HoldResult, LocalDrive, Observed
from codrive._settings import drive_configuration, sumo_variables, traffic_of
from codrive._spaces import ENDED, NEVER, SEEDS, RendererMissing, RenderModeError, check_open, checked_seed
from codrive._words import did_you_mean
from codrive._workers import WorkerDrive

#: Engines of whole drives.
DRIVE_TRAFFIC = ("native", "sumo")
#: Views of pictures, and their largest side, pixels.
VIEWS = ("driver", "mirror", "birdseye", "chase")
_MOST_PIXELS = 8192

_FAILED = "the drive has failed, or was stopped; call reset() first"
_NO_RENDERER = (
    "render_mode='rgb_array' needs codrive built with its renderer: "
    "pip install ./python --config-settings=build-args='--features desktop'"
)


class Setup:
    """Checked settings of a drive, and its factory."""

    def __init__(
        self,
        name: str,
        traffic: str | None,
        hold: float | None,
        advice: str | None,
        driver: str | None,
        settings: dict[str, Any],
    ) -> None:
        traffic = traffic_of(name, traffic, DRIVE_TRAFFIC)
        # Each drive begins with its own seed, so the setting applies to the series.
        self.own_seed = _checked_seed(settings.get("seed"))
        settings = {key: value for key, value in settings.items() if key != "seed"}
        self.configuration, self.arguments = drive_configuration(name, traffic, hold, advice, driver, settings)
        self.variables = sumo_variables() if self.configuration.needs_sumo else {}
        self.folder = os.getcwd()
        self.hold_s: float = json.loads(self.configuration.json())["hold_s"]

    def drive(self) -> LocalDrive | WorkerDrive:
        """Makes a drive, in this process if SUMO is not needed."""
        return self.worker() if self.configuration.needs_sumo else LocalDrive(self.arguments)

    def worker(self) -> WorkerDrive:
        """Makes a drive in a process of its own."""
        return WorkerDrive(self.arguments, self.variables, self.folder)


class Camera:
    """View and size of the pictures of a drive, if it is drawn."""

    def __init__(self, render_mode: str | None, view: str, size: tuple[int, int]) -> None:
        """
        Raises:
            ValueError: The mode, view or size is invalid.
            DependencyNotInstalled: The package was built without its renderer.
        """
        if render_mode not in (None, "rgb_array"):
            raise RenderModeError(f"render_mode is {render_mode!r}; allowed: None, 'rgb_array'")
        if view not in VIEWS:
            raise ValueError(f"view is {view!r}{did_you_mean(view, VIEWS)}; allowed: {', '.join(VIEWS)}")
        sides = tuple(size) if isinstance(size, (tuple, list)) else ()
        if len(sides) != 2 or not all(type(side) is int and 1 <= side <= _MOST_PIXELS for side in sides):
            raise ValueError(f"size is {size!r}; allowed: (width, height) in pixels, each from 1 to {_MOST_PIXELS}")
        if render_mode is not None and not HAS_DESKTOP:
            raise RendererMissing(_NO_RENDERER)
        self.is_on = render_mode is not None
        self.arguments = (*sides, view)


def drive_metadata(hold_s: float) -> dict[str, Any]:
    """Returns Gymnasium's metadata for an environment with steps of this length."""
    return {"render_modes": ["rgb_array"] if HAS_DESKTOP else [], "render_fps": 1.0 / hold_s}


def check_one_advised(settings: dict[str, Any]) -> None:
    """Refuses settings of drives with other advised vehicles than the participant's.

    Raises:
        ValueError: The settings advise other vehicles.
    """
    if str(settings.get("advised", 1)) != "1":
        raise ValueError(
            f"advised is {settings['advised']!r}; allowed: 1, the participant's vehicle; codrive.make_parallel advises several, as agents"
        )
    if settings.get("participant", True) is not True:
        raise ValueError(f"participant is {settings['participant']!r}; allowed: True, because the advice is for the participant's vehicle")


def _checked_seed(seed: Any) -> int | None:
    is_whole = isinstance(seed, (int, np.integer)) and not isinstance(seed, bool)
    if seed is not None and not (is_whole and 0 <= seed < SEEDS):
        raise ValueError(f"seed is {seed!r}; allowed: a whole number from 0 to {SEEDS - 1}")
    return None if seed is None else int(seed)


class DriveSeries:
    """Series of drives for ``reset`` and ``step``: keeps the next seed, and whether a step is possible now."""

    def __init__(self, setup: Setup, camera: Camera) -> None:
        self._setup = setup
        self._camera = camera
        self._drive: LocalDrive | WorkerDrive | None = None
        self._has_begun = False
        self._is_closed = False
        #: Reason why there can be no hold now, if any.
        self._why_not: str | None = NEVER

    def first_seed(self, seed: int | None) -> int | None:
        """Returns the seed for ``reset(seed)``: if none is given, at first that of the settings."""
        check_open(self._is_closed)
        return self._setup.own_seed if seed is None and not self._has_begun else seed

    def begin(self, seed: int | None, random: np.random.Generator) -> Observed:
        """Begins the drive of this seed, or of the next seed from ``random``."""
        own = next_seed(seed, random)
        self._has_begun, self._why_not = True, _FAILED
        if self._drive is None:
            self._drive = self._setup.drive()
        observed = self._done(self._drive.begin, own)
        self._why_not = None
        return observed

    def check_step(self) -> None:
        """Refuses a step if none is possible.

        Raises:
            ClosedEnvironmentError: The drives are closed.
            ResetNeeded: No episode has begun, or it has ended.
        """
        check_open(self._is_closed)
        if self._why_not is not None:
            raise ResetNeeded(self._why_not)

    def hold(self, actions: NDArray[np.float32]) -> HoldResult:
        """Drives one hold under these actions, float32, ``(agents,)``."""
        return self._done(self._drive.hold, actions)

    def end(self) -> None:
        """Notes the end of the episode."""
        self._why_not = ENDED

    def fail(self) -> None:
        """Marks the drive as failed and ends it."""
        self._why_not = _FAILED
        self._lose()

    def render(self) -> NDArray[np.uint8] | None:
        """Returns the present picture, if pictures are on."""
        self._check_begun()
        return self._drive.render(*self._camera.arguments) if self._camera.is_on else None

    def fingerprint(self) -> str:
        """Returns a hash over all states of this drive so far."""
        self._check_begun()
        return self._drive.fingerprint()

    def close(self) -> None:
        """Ends the series."""
        self._is_closed = True
        self._lose()

    def _check_begun(self) -> None:
        check_open(self._is_closed)
        if self._why_not in (NEVER, _FAILED):
            raise ResetNeeded(self._why_not)

    def _done(self, call: Callable[..., Any], *arguments: Any) -> Any:
        """Makes a call; a drive that has failed is not used again."""
        try:
            return call(*arguments)
        except BaseException:
            self.fail()
            raise

    def _lose(self) -> None:
        drive, self._drive = self._drive, None
        if drive is not None:
            drive.close()


def next_seed(seed: int | None, random: np.random.Generator) -> int:
    """Returns the seed of a drive: the given one, else the next of a series."""
    return int(random.integers(SEEDS)) if seed is None else checked_seed(seed)
