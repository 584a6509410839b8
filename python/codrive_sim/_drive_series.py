"""Settings and pictures of whole drives, and series of drives."""

from __future__ import annotations

import json
import os
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.utils.seeding import np_random
from numpy.typing import NDArray

from codrive_sim._camera import Camera, Pictures
from codrive_sim._drives import DriveLog, HoldResult, Leaders, LocalDrive, Observed, Order, Road, Seen
from codrive_sim._settings import drive_configuration, sumo_variables, traffic_of
from codrive_sim._spaces import ENDED, NEVER, SEEDS, check_open, check_settings, checked_seed
from codrive_sim._traffic import OwnDrive, OwnFunctions, Vehicles
from codrive_sim._words import did_you_mean
from codrive_sim._workers import WorkerDrive

#: Engines of whole drives.
DRIVE_TRAFFIC = ("native", "sumo")

_FAILED = "the drive has failed, or was stopped; call reset() first"

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
        own_process: bool = True,
        takes_orders_only: bool = False,
    ) -> None:
        if not isinstance(own_process, bool):
            raise ValueError(f"own_process is {own_process!r}; allowed: True, False")
        self._own_process = own_process
        traffic = traffic_of(name, traffic, DRIVE_TRAFFIC)
        # Each drive begins with its own seed, so the setting applies to the series.
        self.own_seed = _checked_seed(settings.get("seed"))
        settings = {key: value for key, value in settings.items() if key != "seed"}
        self.configuration, self.arguments = drive_configuration(name, traffic, hold, advice, driver, settings)
        known = json.loads(self.configuration.json())
        if self.configuration.advises_none and not takes_orders_only:
            raise ValueError(f"advised is {known['advised']}; allowed: at least one vehicle, so that the actions have a receiver")
        self.variables = sumo_variables() if self.configuration.needs_sumo else {}
        self.folder = os.getcwd()
        self.hold_s: float = known["hold_s"]
        self.top_speed_mps: float = known["top_speed_mps"]

    def drive(self) -> LocalDrive | WorkerDrive:
        """Makes a drive, in this process if SUMO is not needed or is wanted here."""
        if self.configuration.needs_sumo and self._own_process:
            return self.worker()
        os.environ.update(self.variables)
        return LocalDrive(self.arguments)

    def worker(self) -> WorkerDrive:
        """Makes a drive in a process of its own."""
        return WorkerDrive(self.arguments, self.variables, self.folder)


def check_one_advised(settings: dict[str, Any]) -> None:
    """Refuses settings of drives with other advised vehicles than the participant's.

    Raises:
        ValueError: The settings advise other vehicles.
    """
    if str(settings.get("advised", 1)) != "1":
        raise ValueError(
            f"advised is {settings['advised']!r}; allowed: 1, the participant's vehicle; codrive_sim.make_parallel advises several, as agents"
        )


def _checked_seed(seed: Any) -> int | None:
    is_whole = isinstance(seed, (int, np.integer)) and not isinstance(seed, bool)
    if seed is not None and not (is_whole and 0 <= seed < SEEDS):
        raise ValueError(f"seed is {seed!r}; allowed: a whole number from 0 to {SEEDS - 1}")
    return None if seed is None else int(seed)


class DriveSeries:
    """Series of drives for ``reset`` and ``step``: keeps the next seed, whether a step is possible now, and all that the drive was told."""

    def __init__(self, setup: Setup, camera: Camera, own: OwnFunctions) -> None:
        self._setup = setup
        self._pictures = Pictures(camera, setup.top_speed_mps)
        self._own = own
        self._own_drive = OwnDrive(own)
        self._drive: LocalDrive | WorkerDrive | None = None
        self._random: np.random.Generator | None = None
        self._log: DriveLog | None = None
        self._seen: Seen | None = None
        self._road: Road | None = None
        self._is_closed = False
        #: Reason why there can be no hold now, if any.
        self._why_not: str | None = NEVER

    def first_seed(self, seed: int | None) -> int | None:
        """Returns the seed for ``reset(seed)``: if none is given, at first that of the settings."""
        check_open(self._is_closed)
        return self._setup.own_seed if seed is None and self._log is None else seed

    def begin(self, seed: int | None) -> Observed:
        """Begins the drive of this seed, or the next one of the series that the last seed started."""
        if seed is not None or self._random is None:
            self._random, _ = np_random(None if seed is None else checked_seed(seed))
        own = next_seed(seed, self._random)
        self._log = DriveLog(own)
        return self._begun("begin", own)

    @property
    def seed(self) -> int:
        """Returns the seed of the present drive."""
        if self._log is None:
            raise ResetNeeded(NEVER)
        return self._log.seed

    def check_step(self) -> None:
        """Refuses a step if none is possible.

        Raises:
            ClosedEnvironmentError: The drives are closed.
            ResetNeeded: No episode has begun, or it has ended.
        """
        check_open(self._is_closed)
        if self._why_not is not None:
            raise ResetNeeded(self._why_not)

    def hold(self, actions: NDArray[np.float32], orders: list[Order] | None = None) -> HoldResult:
        """Drives one hold under these actions, float32, ``(agents,)``, after these orders."""
        result: HoldResult = self._told("hold", actions.copy(), orders)
        self._show()
        if not self._own.are_given:
            return result
        try:
            return self._own_drive.hold(actions, result, self.seen())
        except BaseException:
            # The function has not seen this hold.
            self.fail()
            raise

    def traffic_step(
        self, actions: NDArray[np.float32], orders: list[Order], reach_m: float | None
    ) -> tuple[HoldResult, Seen, Leaders | None]:
        """Drives one hold as ``hold``, and returns the traffic after it, too, with the vehicles ahead within a distance, m, if there is one."""
        result: tuple[HoldResult, Seen, Leaders | None] = self._told("traffic_step", actions, orders, reach_m)
        self._seen = result[1]
        self._show()
        return result

    def order(self, name: str, *arguments: Any) -> None:
        """Gives the traffic an order, which counts from the next hold on. One that is refused changes nothing."""
        self.check_step()
        drive = self._present()
        try:
            drive.call("order", name, *arguments)
        except ValueError:
            raise
        except BaseException:
            self.fail()
            raise
        self._note("order", name, *arguments)

    def seen(self) -> Seen:
        """Returns the traffic now."""
        if self._seen is None:
            self._seen = self._present().call("seen")
        return self._seen

    def leaders(self, reach_m: float) -> Leaders:
        """Returns the vehicle ahead of each vehicle on its way, within a distance, m."""
        found: Leaders = self._present().call("leaders", reach_m)
        return found

    def names(self, cars: list[int]) -> list[tuple[str, str]]:
        """Returns the names of these vehicles in the demand, and those of their types."""
        found: list[tuple[str, str]] = self._present().call("names", cars)
        return found

    def road(self) -> Road:
        """Returns the road."""
        if self._road is None:
            self._road = self._present().call("road")
        return self._road

    def end(self) -> None:
        """Notes the end of the episode."""
        self._why_not = ENDED

    def fail(self) -> None:
        """Marks the drive as failed and ends it."""
        self._why_not = _FAILED
        self._lose()

    def render(self) -> NDArray[np.uint8] | None:
        """Returns the present picture, if pictures are on."""
        self._present()
        return self._pictures.render(self._rendered)

    def fingerprint(self) -> str:
        """Returns a hash over all states of this drive so far."""
        return self._present().call("fingerprint")

    def state(self) -> dict[str, Any]:
        """Returns all that the drive was told since it began, as ``set_state`` takes it.

        Raises:
            ResetNeeded: No episode has begun.
        """
        self._present()
        log, random = self._log, self._random
        if log is None or random is None:
            raise ResetNeeded(NEVER)
        return state_of(self._setup.configuration.json(), log, random, self._why_not == ENDED)

    def set_state(self, state: dict[str, Any]) -> Observed:
        """Drives again to this state.

        Raises:
            ValueError: This is no state, or that of other settings.
        """
        check_open(self._is_closed)
        self._log = log_of(state, self._setup.configuration.json())
        self._random = random_of(state)
        observed = self._begun("restore", self._log)
        if state["has_ended"]:
            self.end()
        return observed

    def close(self) -> None:
        """Ends the series."""
        self._is_closed = True
        self._pictures.close()
        self._lose()

    def _begun(self, call: str, *arguments: Any) -> Observed:
        self._why_not, self._seen = _FAILED, None
        if self._drive is None:
            self._drive = self._setup.drive()
        observed = self._done(call, *arguments)
        self._why_not = None
        self._pictures.clear()
        self._show()
        return self._own_drive.begin(observed, self.seen()) if self._own.are_given else observed

    def _show(self) -> None:
        """Shows the present moment to the pictures, if there are any."""
        camera = self._pictures.camera
        if not camera.is_on:
            return
        if camera.is_schematic:
            seen = self.seen()
            self._pictures.note(self.road, seen.time_s, Vehicles.of(seen.columns))
        self._pictures.show(self._rendered)

    def _rendered(self) -> NDArray[np.uint8]:
        """Returns the picture of the renderer."""
        picture: NDArray[np.uint8] = self._present().call("render", *self._pictures.camera.arguments)
        return picture

    def _told(self, call: str, *arguments: Any) -> Any:
        result = self._done(call, *arguments)
        self._note(call, *arguments)
        return result

    def _note(self, call: str, *arguments: Any) -> None:
        self._seen = None
        if self._log is not None:
            self._log.calls.append((call, arguments))

    def _present(self) -> LocalDrive | WorkerDrive:
        check_open(self._is_closed)
        if self._drive is None or self._why_not in (NEVER, _FAILED):
            raise ResetNeeded(self._why_not or NEVER)
        return self._drive

    def _done(self, call: str, *arguments: Any) -> Any:
        """Makes a call; a drive that has failed is not used again."""
        try:
            return self._drive.call(call, *arguments)
        except BaseException:
            self.fail()
            raise

    def _lose(self) -> None:
        drive, self._drive = self._drive, None
        if drive is not None:
            drive.close()


def state_of(settings: str, log: DriveLog, random: np.random.Generator, has_ended: bool) -> dict[str, Any]:
    """Returns the state of a drive with these settings, JSON, in the series of this generator of seeds."""
    calls, generator = list(log.calls), random.bit_generator.state
    return {"settings": settings, "seed": log.seed, "calls": calls, "random": generator, "has_ended": has_ended}


def random_of(state: dict[str, Any]) -> np.random.Generator:
    """Returns the generator of seeds of a state."""
    random, _ = np_random(0)
    random.bit_generator.state = state["random"]
    return random


def log_of(state: Any, settings: str) -> DriveLog:
    """Returns the log of a state of a drive with these settings, JSON.

    Raises:
        ValueError: This is no state of a drive, or that of other settings.
    """
    if not isinstance(state, dict) or not {"settings", "seed", "calls", "random", "has_ended"} <= state.keys():
        raise ValueError("this is no state of a drive; allowed: what get_state of such an environment returns")
    check_settings(state["settings"], settings)
    log = DriveLog(state["seed"])
    log.calls = list(state["calls"])
    return log


def next_seed(seed: int | None, random: np.random.Generator) -> int:
    """Returns the seed of a drive: the given one, else the next of a series."""
    return int(random.integers(SEEDS)) if seed is None else checked_seed(seed)
