"""``evaluate``: results of policies over whole horizons, with the numbers of ``codrive evaluate``."""

from __future__ import annotations

import json
import os
import sys
import warnings
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from codrive_sim._codrive import Configuration, evaluate_actions, evaluate_policy, measure_names, policy_names
from codrive_sim._drive_series import Setup
from codrive_sim._evaluation_drives import EvaluationArguments, Job, results_of
from codrive_sim._frames import Frames, library
from codrive_sim._library_policies import MEANING, RESIDUAL, actions_of, label, trained_with
from codrive_sim._settings import advised_text, configuration, traffic_of
from codrive_sim._words import InWordsOfPython

#: Columns before and after the measures, as in ``rings.csv`` of ``codrive evaluate``.
_KEY = ("policy", "hold_s", "driver", "traffic", "seed", "ring", "window_from_s", "window_to_s")
_ADVISED = ("advised_vehicles", "advised_share")

_PARTICIPANT = (
    "participant: an evaluation has the participant's vehicle on closed roads, and none where vehicles enter and leave; leave it out"
)


def policies() -> list[str]:
    """Returns the names of the policies that ``evaluate`` knows: the built-in ones, then the shipped ones."""
    built_in, shipped = policy_names()
    return [*built_in, *shipped]


def evaluate(
    policy: Any = None,
    name: str = "ring-250",
    *,
    traffic: str | None = None,
    advised: str | float | None = None,
    over: int = 20,
    hold: float | Sequence[float] | None = None,
    driver: str | None = "follow",
    advice: str | None = None,
    policy_speed: float = 0.0,
    as_: Frames = "pandas",
    progress: bool | None = None,
    **settings: Any,
) -> Any:
    """Evaluates policies on the same rings, or in the same whole drives, over whole horizons, transients included.

    Args:
        policy: A name (from ``codrive_sim.policies()``, or ``"auto"`` for the one shipped for the road), a policy.toml, or an ONNX file;
            a callable that takes observations, float32, ``(n, k)``, and returns actions, ``(n, 1)`` or ``(n,)``, as for
            ``make_vec`` with the same settings; an object with ``predict``, such as a model of Stable-Baselines3; an algorithm of RLlib
            (its default module) or an ``RLModule``, on PyTorch; or a list of these. None: all built-in policies. A model that was trained
            in an environment of codrive brings its kind of advice, inputs, scales and hold along; a recurrent one keeps its state, and
            one with a ``VecNormalize`` gets normalised observations. In fast rings ``n`` is ``over`` times the advised vehicles of each; in
            whole drives it is 1, one call for each advised vehicle, and a recurrent model has a state for each of them.
        name: As ``codrive_sim.make``.
        traffic: Engine of the traffic, as ``codrive_sim.make``: ``"ring"`` evaluates on fast rings, ``"native"``, ``"sumo"`` and files by whole
            drives, in processes on all cores. None: ``"ring"`` for rings, ``"sumo"`` for all else.
        advised: Advised vehicles: a number, ``4``, or a share, ``"25%"``; where vehicles enter and leave a share. None: the ego, or
            as in a FILE.toml.
        over: Number of rings or drives, each with its own random numbers, 1 to 100,000. Drive ``i`` has the seed ``seed + i``.
        hold: Duration of one advice, s; or a list of these. None: that of the model, or of the settings.
        driver: Driver who follows the advice, as ``codrive_sim.make``; None: as in the settings. Whole drives take one that is not drawn.
        advice: Meaning of a callable's actions: ``"acceleration"`` or ``"speed"``. A model brings its own.
        policy_speed: Target speed of the built-in policies, m/s; 0 is 98.5 % of the equilibrium speed.
        as_: ``"pandas"`` or ``"polars"``.
        progress: Shows progress on standard error; None: if it is a terminal.
        **settings: As ``codrive_sim.make`` with this ``traffic``.

    Returns:
        A data frame with the columns of ``codrive evaluate``'s ``rings.csv`` and one row for each policy, hold and ring or drive:
        ``policy``, ``hold_s``, ``driver``, ``traffic``, ``seed``, ``ring``, ``window_from_s``, ``window_to_s``; then the measures, such
        as ``mean_speed_mps`` and ``settled_speed_mps`` (m/s, all vehicles, over the horizon and over its last quarter) and ``crashed``;
        then ``advised_vehicles`` and ``advised_share``. docs/measures.md defines all measures.

    Raises:
        TypeError: There is no setting of that name, or ``policy`` is not a policy.
        ValueError: A value is not allowed, there is no such policy, its actions are invalid, or a model was trained with another meaning of
            observations or actions.
        RuntimeError: A drive has failed.
        gymnasium.error.DependencyNotInstalled: SUMO is needed and not installed.
    """
    frames = library(as_)
    if isinstance(over, bool) or not isinstance(over, (int, np.integer)) or not 1 <= over <= 100_000:
        raise ValueError(f"over is {over!r}; allowed: a whole number from 1 to 100000")
    if isinstance(policy_speed, bool) or not isinstance(policy_speed, (int, float, np.integer, np.floating)):
        raise TypeError(f"policy_speed is {policy_speed!r}; allowed: a number, m/s")
    policy_speed = float(policy_speed)
    if not (np.isfinite(policy_speed) and policy_speed >= 0.0):
        raise ValueError(f"policy_speed is {policy_speed}; allowed: 0 or more, m/s")
    if not isinstance(name, str):
        raise TypeError(f"name is {name!r}; allowed: a text")
    asked = policy_names()[0] if policy is None else policy if isinstance(policy, (list, tuple)) else [policy]
    held = list(hold) if isinstance(hold, Iterable) else [hold]
    traffic = traffic_of(name, traffic)
    if traffic == "ring":
        settings = {**settings, "hold_max_s": 0.0} if name.endswith(".toml") else settings
        settings = settings if advised is None else {**settings, "advised": advised}
    cases = [_Asked(one, hold_s, name, advice, driver, settings, policy_speed) for one in asked for hold_s in held]
    if traffic == "ring":
        rows = _over_rings([_RingCase(case) for case in cases], int(over), progress)
    else:
        share = None if advised is None else advised_text(advised)
        rows = _over_drives([_DriveCase(case, traffic, share) for case in cases], int(over), progress)
    columns = {key: [row.get(key) for row in rows] for key in (*_KEY, *measure_names(), *_ADVISED)}
    more = {"infer_schema_length": None} if as_ == "polars" else {}
    return frames.DataFrame(columns, **more)


class _Asked(NamedTuple):
    """One policy at one hold, with what else ``evaluate`` was given."""

    policy: Any
    hold: float | None
    name: str
    advice: str | None
    driver: str | None
    settings: dict[str, Any]
    policy_speed: float


class _RingCase:
    """Settings of one evaluation on fast rings. What a model was trained with fills in what was not given."""

    def __init__(self, asked: _Asked) -> None:
        """
        Raises:
            ValueError: What was given contradicts the model.
        """
        policy, hold, name, advice, driver, settings, policy_speed = asked
        self.policy = policy
        self.name = name
        self.policy_speed = policy_speed
        own = trained_with(policy)
        hold, filled = _filled(own, MEANING, hold, advice, settings)
        self.settings: Configuration = configuration(name, hold, advice, driver, filled)
        now = json.loads(self.settings.json())
        _check_meaning(policy, own, now)
        self.key = {**_key_of(now, driver), "traffic": "ring", "window_to_s": now["horizon_s"]}

    def results(self, over: int, meter: _Meter) -> tuple[str, str | None, list[dict[str, Any]]]:
        """Returns the name of the policy, a warning, and its result on each ring."""
        warning = None
        if isinstance(self.policy, (str, os.PathLike)):
            with InWordsOfPython():
                own, warning, text = evaluate_policy(
                    self.settings, os.fspath(self.policy), self.name, self.policy_speed, over, meter.at
                )
        else:
            rows = over * len(self.settings.possible_agents())
            own, text = label(self.policy), evaluate_actions(self.settings, over, actions_of(self.policy, self.settings, rows))
            meter.at(over)
        meter.next(over)
        return own, warning, json.loads(text)


class _DriveCase:
    """Settings of one evaluation by whole drives. What a model was trained with fills in what was not given."""

    def __init__(self, asked: _Asked, traffic: str, advised: str | None) -> None:
        """
        Raises:
            ValueError: What was given contradicts the model, or the road.
        """
        policy, hold, name, advice, driver, settings, policy_speed = asked
        if "participant" in settings:
            raise TypeError(_PARTICIPANT)
        is_named = isinstance(policy, (str, os.PathLike))
        own = trained_with(policy)
        if own is not None and own["residual_over"]:
            raise ValueError(
                f"{label(policy)} was trained with residual_over {own['residual_over']!r}, which whole drives do not add to its actions\n"
                "  remedy: evaluate the file of codrive_sim.save_policy, which contains it, or use traffic='ring'"
            )
        hold, filled = _filled(own, tuple(key for key in MEANING if key not in RESIDUAL), hold, advice, settings)
        setup = Setup(name, traffic, hold, advice, driver, filled)
        now = json.loads(setup.configuration.learning.json())
        _check_meaning(policy, own, now)
        self.arguments = EvaluationArguments(setup.arguments, os.fspath(policy) if is_named else None, policy_speed, advised)
        self.variables = setup.variables
        self.seed: int = now["seed"] if setup.own_seed is None else setup.own_seed
        drives = self.arguments.checked()
        self.warning = drives.warning
        self.engage = lambda: actions_of(policy, setup.configuration, 1)
        if not is_named:
            # An object that is no policy is refused before any drive.
            self.engage()
        self.key = {
            **_key_of(now, driver),
            "policy": drives.policy if is_named else label(policy),
            "traffic": traffic,
            "seed": self.seed,
            "window_to_s": now["horizon_s"],
        }


def _over_rings(cases: list[_RingCase], over: int, progress: bool | None) -> list[dict[str, Any]]:
    meter = _Meter(len(cases) * over, "rings", progress)
    rows: list[dict[str, Any]] = []
    for case in cases:
        own, warning, results = case.results(over, meter)
        _warn(own, warning)
        rows += [{**case.key, "policy": own, "ring": ring, **result} for ring, result in enumerate(results)]
    meter.end()
    return rows


def _over_drives(cases: list[_DriveCase], over: int, progress: bool | None) -> list[dict[str, Any]]:
    for case in cases:
        _warn(case.key["policy"], case.warning)
    meter = _Meter(len(cases) * over, "drives", progress)
    jobs = [Job(case.arguments, case.variables, case.seed + ring, case.engage) for case in cases for ring in range(over)]
    results = results_of(jobs, meter.at)
    meter.end()
    keys = [{**case.key, "ring": ring} for case in cases for ring in range(over)]
    return [{**key, **result} for key, result in zip(keys, results, strict=True)]


def _filled(
    own: dict[str, Any] | None, meaning: Sequence[str], hold: float | None, advice: str | None, settings: dict[str, Any]
) -> tuple[float | None, dict[str, Any]]:
    """Returns hold and settings with what a model was trained with (``own``) where it was not given."""
    if own is None:
        return hold, settings
    brought = {key: own[key] for key in meaning if not (key == "action" and advice is not None)}
    return own["hold_s"] if hold is None and "hold_s" not in settings else hold, {**brought, **settings}


def _check_meaning(policy: Any, own: dict[str, Any] | None, now: dict[str, Any]) -> None:
    """Refuses settings that give the numbers of a model another meaning.

    Raises:
        ValueError: A setting contradicts the model.
    """
    for key in MEANING if own is not None else ():
        if now[key] != own[key]:
            said = "advice" if key == "action" else key
            raise ValueError(f"{said} is {now[key]!r}, and {label(policy)} was trained with {own[key]!r}; leave it out: the model brings it")


def _key_of(now: dict[str, Any], driver: str | None) -> dict[str, Any]:
    """Returns the key columns that settings give."""
    return {"hold_s": now["hold_s"], "driver": driver or "configured", "seed": now["seed"], "window_from_s": 0.0}


def _warn(policy: str, warning: str | None) -> None:
    if warning:
        warnings.warn(f"{policy}: {warning}", stacklevel=4)


class _Meter:
    """Progress of an evaluation, in one line."""

    def __init__(self, count: int, unit: str, shown: bool | None) -> None:
        self._of = f"of {count} {unit}"
        self._before = 0
        self._is_shown = sys.stderr.isatty() if shown is None else bool(shown)

    def at(self, of_case: int) -> None:
        """Shows the number of finished rings of the present case, or of all drives."""
        if self._is_shown:
            print(f"\r{self._before + of_case} {self._of}", end="", file=sys.stderr, flush=True)

    def next(self, of_case: int) -> None:
        """Counts the rings of the present case as finished."""
        self._before += of_case

    def end(self) -> None:
        """Ends the line."""
        if self._is_shown:
            print(file=sys.stderr)
