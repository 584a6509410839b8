"""Whole drives side by side as a vector environment of Gymnasium, each in a process of its own, with one or several advised vehicles each."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.utils.seeding import np_random
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from codrive_sim._camera import VECTOR_RENDER_MODES, Camera, Pictures, picture_metadata
from codrive_sim._codrive import DriveConfiguration
from codrive_sim._drive_series import Setup, log_of, next_seed, random_of, state_of
from codrive_sim._drives import DriveLog, Observed, Road, Seen
from codrive_sim._settings import advised_text
from codrive_sim._spaces import (
    NEVER,
    AdviceMeaning,
    Picklable,
    as_float32,
    check_actions,
    check_open,
    checked_count,
    checked_mask,
    checked_vector_seed,
    final_infos,
    spaces,
    vector_infos,
)
from codrive_sim._traffic import OwnDrive, OwnFunctions, Vehicles, hold_info
from codrive_sim._workers import close_all

#: Maximum number of processes.
_MOST = 1024


class DriveVectorEnv(Picklable, AdviceMeaning, gymnasium.vector.VectorEnv):
    """Whole drives that run at the same time, each in a process of its own; see ``codrive_sim.DriveEnv`` for a single drive.

    Arrays, infos and endings are as in ``codrive_sim.RingVectorEnv``: a drive that ends begins another in the same step
    (``AutoresetMode.SAME_STEP``). ``reset(seed=s)`` begins in environment ``i`` the drives that ``codrive_sim.DriveEnv`` drives after
    ``reset(seed=s + i)``.

    With ``advised`` on a closed road each advised vehicle of each drive is a row, drive after drive, so that ``num_envs`` of the environment is
    that of the drives times the agents of each. The agents of a drive begin and end their episodes together.

    If a process is lost, or Ctrl-C stops a step, the step raises; ``reset`` starts another process and begins all drives again.
    """

    metadata = {"render_modes": list(VECTOR_RENDER_MODES), "autoreset_mode": AutoresetMode.SAME_STEP}

    def __init__(
        self,
        name: str = "ring-250",
        num_envs: int = 1,
        *,
        traffic: str | None = None,
        hold: float | None = None,
        advice: str | None = None,
        driver: str | None = None,
        copy: bool = True,
        render_mode: str | None = None,
        view: str | None = None,
        size: tuple[int, int] = (1280, 720),
        **settings: Any,
    ) -> None:
        """See ``codrive_sim.make_vec``."""
        self._drives = []
        self._camera = camera = Camera(render_mode, view, size, VECTOR_RENDER_MODES)
        self._drive_count = checked_count(num_envs, _MOST)
        self._own = OwnFunctions.taken_from(settings)
        advised = {"advised": advised_text(settings["advised"])} if "advised" in settings else {}
        self._setup = Setup(name, traffic, hold, advice, driver, {**settings, **advised})
        if self._setup.configuration.is_open and str(settings.get("advised", 1)) != "1":
            raise ValueError(
                f"advised is {settings['advised']!r}; allowed: 1 on a network, where other advised vehicles come and go; codrive_sim.make_parallel "
                "has them as agents"
            )
        #: Names of the agents of each drive, in the order of its rows.
        self.agents: list[str] = self._setup.configuration.possible_agents()
        self.num_envs = self._drive_count * len(self.agents)
        self.render_mode = render_mode
        self._road: Road | None = None
        self._pictures = [Pictures(camera, self._setup.top_speed_mps) for _ in range(self._drive_count)]
        self.settings: DriveConfiguration = self._setup.configuration
        self.single_observation_space, self.single_action_space = spaces(self.settings, self._own.space)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.metadata = {**picture_metadata(self._setup.hold_s, VECTOR_RENDER_MODES), "autoreset_mode": AutoresetMode.SAME_STEP}
        self._drives = [self._setup.worker() for _ in range(self._drive_count)]
        self._random = [np_random()[0] for _ in range(self._drive_count)]
        self._own_drives = [OwnDrive(self._own) for _ in range(self._drive_count)]
        space = self.observation_space
        self._observations = np.zeros(space.shape or (self.num_envs,), space.dtype)
        #: All that each drive was told since it began; none before the first reset.
        self._logs: dict[int, DriveLog] = {}
        #: True for drives whose episode can continue.
        self._is_ready = np.zeros(self._drive_count, np.bool_)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[Any], dict[str, Any]]:
        """Begins an episode in each environment.

        Args:
            seed: Drive ``i`` begins with ``seed + i``; None: the next ones.
            options: ``{"reset_mask": mask}``, bool, ``(num_envs,)``: resets only the drives with a marked agent.

        Returns:
            Observations, float32, ``(num_envs, k)``, and an empty dict.

        Raises:
            RuntimeError: A drive has failed.
        """
        check_open(self.closed)
        checked_vector_seed(seed, "drive i begins with seed + i")
        mask = checked_mask(options, self.num_envs)
        if seed is None and not self._logs:
            seed = self._setup.own_seed
        super().reset(seed=seed)
        where = np.arange(self._drive_count) if mask is None else np.flatnonzero(self._rows(mask).any(axis=1))
        if seed is not None:
            for number in where:
                self._random[number] = np_random(int(seed) + int(number))[0]
        self._begin({int(number): None if seed is None else int(seed) + int(number) for number in where})
        return self._observations.copy(), {}

    def step(
        self, actions: Any
    ) -> tuple[NDArray[Any], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Drives one hold of every drive under these actions, ``(num_envs, 1)``, or ``(num_envs,)`` for levels.

        Raises:
            ValueError: The actions have another shape, or one is NaN or out of range.
            ResetNeeded: No episode has begun.
            RuntimeError: A drive has failed.
        """
        check_open(self.closed)
        if not self._is_ready.all():
            raise ResetNeeded(NEVER)
        levels = self.settings.levels
        given = as_float32(actions, levels, (self.num_envs,) if levels else (self.num_envs, 1))
        check_actions(given, levels, lambda number: f" of environment {number}")
        told = {number: (acted.copy(),) for number, acted in enumerate(self._rows(given))}
        results = self._all("hold", told)
        for number, arguments in told.items():
            self._logs[number].calls.append(("hold", arguments))
        seen = self._seen(told)
        if self._own.are_given:
            try:
                for number, (actions,) in told.items():
                    results[number] = self._own_drives[number].hold(actions, results[number], seen[number])
            except BaseException:
                # The function has not seen this hold.
                self._is_ready[:] = False
                raise
        rewards = np.concatenate([result.rewards for result in results.values()])
        terminations = np.concatenate([result.terminations for result in results.values()])
        agents = len(self.agents)
        truncations = np.repeat([result.is_truncated for result in results.values()], agents) & ~terminations
        values = [hold_info(result) for result in results.values()]
        columns = {name: np.repeat([value[name] for value in values], agents) for name in values[0]}
        final = np.concatenate([result.final_observations for result in results.values()])
        ended = terminations | truncations
        self._observations[~ended] = final[~ended]
        infos = vector_infos(columns)
        if ended.any():
            infos.update(final_infos(ended, final, columns))
            self._begin({int(number): None for number in np.flatnonzero(self._rows(ended).any(axis=1))})
        return self._observations.copy(), rewards, terminations, truncations, infos

    @property
    def vehicles(self) -> tuple[Vehicles, ...]:
        """Returns all vehicles of each drive now as columns."""
        check_open(self.closed)
        return tuple(Vehicles.of(seen.columns) for seen in self._of_all("seen", ()))

    def get_state(self) -> dict[str, Any]:
        """Returns the state of all drives: their seeds, and all that they were told since. It can be pickled."""
        check_open(self.closed)
        if not self._is_ready.all():
            raise ResetNeeded(NEVER)
        settings, numbers = self.settings.json(), range(self._drive_count)
        return {"drives": [state_of(settings, self._logs[number], self._random[number], False) for number in numbers]}

    def set_state(self, state: dict[str, Any]) -> NDArray[Any]:
        """Drives again to a state that ``get_state`` of an environment with the same settings and ``num_envs`` has returned. Returns the
        observations there, ``(num_envs, k)``.

        Raises:
            ValueError: This is no state, or that of other settings.
        """
        check_open(self.closed)
        drives = state.get("drives") if isinstance(state, dict) else None
        if not isinstance(drives, list) or len(drives) != self._drive_count:
            raise ValueError(f"this is no state of {self._drive_count} drives; allowed: what get_state of such environments returns")
        logs = [log_of(drive, self.settings.json()) for drive in drives]
        self._take(self._all("restore", {number: (log,) for number, log in enumerate(logs)}))
        self._logs = dict(enumerate(logs))
        self._random = [random_of(drive) for drive in drives]
        return self._observations.copy()

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Returns the present picture of each drive, uint8, ``(height, width, 3)``; None without a ``render_mode``."""
        check_open(self.closed)
        if self.render_mode != "rgb_array":
            return None
        rendered = [None] * self._drive_count
        if not self._camera.is_schematic:
            rendered = self._of_all("render", self._camera.arguments)
        return tuple(pictures.picture(lambda own=own: own) for pictures, own in zip(self._pictures, rendered))

    def fingerprints(self) -> list[str]:
        """Returns for each drive a hash over all its states so far; equal states have equal hashes, to the bit."""
        check_open(self.closed)
        return self._of_all("fingerprint", ())

    def close_extras(self, **_: Any) -> None:
        """Ends the processes."""
        close_all(self._drives)

    def _rows(self, array: NDArray[Any]) -> NDArray[Any]:
        """Returns a view of an array ``(num_envs, ...)`` as ``(drives, agents, ...)``."""
        return array.reshape(self._drive_count, len(self.agents), *array.shape[1:])

    def _of_all(self, call: str, arguments: tuple[Any, ...]) -> list[Any]:
        if not self._is_ready.all():
            raise ResetNeeded(NEVER)
        return list(self._all(call, dict.fromkeys(range(self._drive_count), arguments)).values())

    def _begin(self, seeds: dict[int, int | None]) -> None:
        """Begins drives in these environments, with these seeds or the next ones of their series."""
        own = {number: next_seed(seed, self._random[number]) for number, seed in seeds.items()}
        begun = self._all("begin", {number: (seed,) for number, seed in own.items()})
        for number, seed in own.items():
            self._logs[number] = DriveLog(seed)
        self._take(begun)

    def _seen(self, numbers: Iterable[int]) -> dict[int, Seen]:
        """Returns the traffic of these drives now for functions and pictures, and shows it to the latter; nothing without either."""
        if not self._own.are_given and not self._camera.is_schematic:
            return {}
        seen: dict[int, Seen] = self._all("seen", dict.fromkeys(numbers, ()))
        if self._camera.is_schematic:
            for number, now in seen.items():
                self._pictures[number].note(self._the_road, now.time_s, Vehicles.of(now.columns))
        return seen

    def _the_road(self) -> Road:
        """Returns the road, which is the same for all drives."""
        if self._road is None:
            self._road = self._all("road", {0: ()})[0]
        return self._road

    def _take(self, begun: dict[int, Observed]) -> None:
        """Takes the observations of drives that have just begun."""
        for number in begun:
            self._pictures[number].clear()
        seen = self._seen(begun)
        if self._own.are_given:
            begun = {number: self._own_drives[number].begin(observed, seen[number]) for number, observed in begun.items()}
        for number, observed in begun.items():
            if len(observed.agents) != len(self.agents):
                raise RuntimeError(f"{len(observed.agents)} vehicles are advised; allowed: {len(self.agents)} in each drive")
            self._rows(self._observations)[number] = observed.observations
            self._is_ready[number] = True

    def _all(self, call: str, arguments: dict[int, tuple[Any, ...]]) -> dict[int, Any]:
        """Makes the same call to several drives at once. If one fails, none continues."""
        self._is_ready[list(arguments)] = False
        answers: dict[int, Any] = {}
        faults: dict[int, Exception] = {}
        try:
            for number, given in arguments.items():
                try:
                    self._drives[number].ask(call, *given)
                except Exception as fault:
                    faults[number] = fault
            for number in arguments.keys() - faults.keys():
                try:
                    answers[number] = self._drives[number].answer()
                except Exception as fault:
                    faults[number] = fault
        except BaseException:
            # Ctrl-C: a process without a response is still driving; its response would be taken for that to the next call.
            self._is_ready[:] = False
            for number in arguments.keys() - answers.keys():
                self._drives[number].kill()
            raise
        if faults:
            self._is_ready[:] = False
            for number in faults:
                self._drives[number].kill()
            first = min(faults)
            raise type(faults[first])(f"environment {first}: {faults[first]}") from None
        self._is_ready[list(arguments)] = True
        return {number: answers[number] for number in arguments}
