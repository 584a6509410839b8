"""``evaluate``: results of policies over whole horizons, with the numbers of ``codrive evaluate``."""

from __future__ import annotations

import json
import os
import sys
import warnings
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from codrive._library_policies import MEANING, actions_of, label, trained_with
from codrive._codrive import Configuration, evaluate_actions, evaluate_policy, policy_names
from codrive._frames import Frames, library
from codrive._settings import configuration
from codrive._words import in_words_of_python

_ELSEWHERE = "codrive.evaluate drives training rings only; use codrive.make or a plan of codrive.sweep for other maps"


def policies() -> list[str]:
    """Returns the names of the policies that ``evaluate`` knows: the built-in ones, then the shipped ones."""
    built_in, shipped = policy_names()
    return [*built_in, *shipped]


def evaluate(
    policy: Any = None,
    name: str = "ring-250",
    *,
    over: int = 20,
    hold: float | Sequence[float] | None = None,
    driver: str | None = "follow",
    advice: str | None = None,
    policy_speed: float = 0.0,
    as_: Frames = "pandas",
    progress: bool | None = None,
    **settings: Any,
) -> Any:
    """Evaluates policies on the same rings over whole horizons, transients included.

    Args:
        policy: A name (from ``codrive.policies()``, or ``"auto"`` for the one shipped for the ring), a policy.toml, or an ONNX file;
            a callable that takes observations, float32, ``(over, k)``, and returns actions, ``(over, 1)`` or ``(over,)``, as for
            ``make_vec`` with the same settings; an object with ``predict``, such as a model of Stable-Baselines3; an algorithm of RLlib
            (its default module) or an ``RLModule``, on PyTorch; or a list of these. None: all built-in policies. A model that was trained
            in an environment of codrive brings its kind of advice, inputs, scales and hold along; a recurrent one keeps its state, and
            one with a ``VecNormalize`` gets normalised observations.
        name: As ``codrive.make``.
        over: Number of rings, each with its own random numbers, 1 to 100,000.
        hold: Duration of one advice, s; or a list of these. None: that of the model, or of the settings.
        driver: Driver who follows the advice, as ``codrive.make``; None: as in the settings.
        advice: Meaning of a callable's actions: ``"acceleration"`` or ``"speed"``. A model brings its own.
        policy_speed: Target speed of the built-in policies, m/s; 0 is 98.5 % of the equilibrium speed.
        as_: ``"pandas"`` or ``"polars"``.
        progress: Shows progress on standard error; None: if it is a terminal.
        **settings: As ``codrive.make``.

    Returns:
        A data frame with one row for each policy, hold and ring: ``policy``, ``hold_s``, ``driver``, ``seed``, ``ring``, then
        the results of ``codrive evaluate --json`` for a ring: ``mean_speed_mps`` and ``settled_speed_mps`` (m/s, all vehicles, over the
        horizon and over its last quarter), ``speed_sd_over_vehicles_mps``, ``speed_sd_over_time_mps``, ``last_disturbance_s``,
        ``min_gap_to_neighbours_m``, ``crashed``, ``crash_s``, ``fuel_l_100km``, ``flow_per_h``, ``time_in_range`` and the measures of
        conflicts; docs/measures.md defines all of them.

    Raises:
        TypeError: There is no setting of that name, or ``policy`` is not a policy.
        ValueError: A value is not allowed, there is no such policy, its actions are invalid, or a model was trained with another meaning of
            observations or actions.
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
    settings = {**settings, "hold_max_s": 0.0} if name.endswith(".toml") else settings
    held = list(hold) if isinstance(hold, Iterable) else [hold]
    cases = [(one, _case(one, name, hold_s, advice, driver, settings)) for one in asked for hold_s in held]
    rows: list[dict[str, Any]] = []
    meter = _Meter(len(cases) * int(over), progress)
    for one, case in cases:
        own, results = _results(one, case, name, policy_speed, int(over), meter)
        config = json.loads(case.json())
        head = {"policy": own, "hold_s": config["hold_s"], "driver": driver or "configured", "seed": config["seed"]}
        rows += [{**head, "ring": ring, **result} for ring, result in enumerate(results)]
    meter.end()
    columns = {key: [row.get(key) for row in rows] for key in dict.fromkeys(key for row in rows for key in row)}
    more = {"infer_schema_length": None} if as_ == "polars" else {}
    return frames.DataFrame(columns, **more)


def _case(
    policy: Any, name: str, hold: float | None, advice: str | None, driver: str | None, settings: dict[str, Any]
) -> Configuration:
    """Returns the settings of one evaluation. What a model was trained with fills in what was not given.

    Raises:
        ValueError: What was given contradicts the model.
    """
    own = trained_with(policy)
    if own is None:
        return configuration(name, hold, advice, driver, settings, _ELSEWHERE)
    brought = {key: own[key] for key in MEANING if not (key == "action" and advice is not None)}
    hold = own["hold_s"] if hold is None and "hold_s" not in settings else hold
    case = configuration(name, hold, advice, driver, {**brought, **settings}, _ELSEWHERE)
    now = json.loads(case.json())
    for key in MEANING:
        if now[key] != own[key]:
            said = "advice" if key == "action" else key
            raise ValueError(f"{said} is {now[key]!r}, and {label(policy)} was trained with {own[key]!r}; leave it out: the model brings it")
    return case


def _results(
    policy: Any, case: Configuration, name: str, policy_speed: float, over: int, meter: _Meter
) -> tuple[str, list[dict[str, Any]]]:
    """Returns the name of a policy, and its result on each ring."""
    if isinstance(policy, (str, os.PathLike)):
        with in_words_of_python():
            own, warning, text = evaluate_policy(case, os.fspath(policy), name, policy_speed, over, meter.at)
        if warning:
            warnings.warn(f"{own}: {warning}", stacklevel=3)
    else:
        own, text = label(policy), evaluate_actions(case, over, actions_of(policy, case, over))
        meter.at(over)
    meter.next(over)
    return own, json.loads(text)


class _Meter:
    """Progress of an evaluation, in one line."""

    def __init__(self, rings: int, shown: bool | None) -> None:
        self._rings = rings
        self._before = 0
        self._is_shown = sys.stderr.isatty() if shown is None else bool(shown)

    def at(self, of_case: int) -> None:
        """Shows the number of finished rings of the present case."""
        if self._is_shown:
            print(f"\r{self._before + of_case} of {self._rings} rings", end="", file=sys.stderr, flush=True)

    def next(self, of_case: int) -> None:
        """Counts the rings of the present case as finished."""
        self._before += of_case

    def end(self) -> None:
        """Ends the line."""
        if self._is_shown:
            print(file=sys.stderr)
