"""Settings from keyword arguments."""

from __future__ import annotations

import importlib.util
import json
import os
import pathlib
from typing import Any

import numpy as np
from gymnasium.error import DependencyNotInstalled

from codrive_sim._codrive import Configuration, DriveConfiguration, sumo_home
from codrive_sim._drives import Arguments
from codrive_sim._words import InWordsOfPython, did_you_mean

#: Names of the rings of training.
RINGS = ("ring-250", "ring-641")
#: Engines of the traffic.
TRAFFIC = ("ring", "native", "sumo")

_NO_SUMO = (
    "traffic='sumo' needs SUMO, which is neither in SUMO_HOME nor in the package sumo: pip install eclipse-sumo==1.28.0; "
    "traffic='native' drives rings and other closed lanes without it"
)

#: Arguments of some functions that others do not take, with the reason.
_MISPLACED = {
    "num_envs": "only codrive_sim.make_vec has several environments; codrive_sim.evaluate has over, the number of rings",
    "copy": "only codrive_sim.make_vec can return the same arrays each time",
    "render_mode": "only environments draw pictures",
    "view": "only environments draw pictures",
    "size": "only environments draw pictures",
    "own_process": "only codrive_sim.make and codrive_sim.make_parallel with SUMO can do without a process of its own",
    "observation": "only environments take functions",
    "observation_space": "only environments take functions",
    "traffic": "this environment is a fast ring; codrive_sim.make has other engines",
    "over": "only codrive_sim.evaluate has this argument; codrive_sim.make_vec has num_envs",
}


def advised_text(advised: Any) -> str:
    """Returns a number of advised vehicles, or a share of all, as the settings have it.

    Raises:
        TypeError: This is neither.
    """
    if isinstance(advised, bool) or not isinstance(advised, (str, int, float, np.integer, np.floating)):
        raise TypeError(f"advised is {advised!r}; allowed: a number of vehicles, or a share such as '20%' or 0.2")
    return str(advised)


def is_ring(name: object) -> bool:
    """Returns True for the name of a ring of training, or of its file."""
    return isinstance(name, str) and (name in RINGS or name.endswith(".toml"))


def traffic_of(name: str, traffic: str | None, allowed: tuple[str, ...] = TRAFFIC) -> str:
    """Returns the requested traffic; without one, that of the name: rings and training configurations are rings if these are allowed,
    all else is driven in SUMO.

    A file of trajectories (``.csv``, ``.csv.gz``) is allowed wherever a whole drive is.

    Raises:
        ValueError: There is no such engine.
    """
    if traffic is None:
        return ("ring" if "ring" in allowed else "native") if is_ring(name) else "sumo"
    if isinstance(traffic, str) and (traffic in allowed or ("native" in allowed and traffic.endswith((".csv", ".csv.gz")))):
        return traffic
    raise ValueError(
        f"traffic is {traffic!r}{did_you_mean(traffic, allowed)}; allowed: {', '.join(allowed)}, or a file of trajectories (.csv)"
    )


def configuration(
    name: str,
    hold: float | None,
    advice: str | None,
    driver: str | None,
    settings: dict[str, Any],
) -> Configuration:
    """Returns the checked settings for these arguments of ``make``.

    Raises:
        TypeError: There is no setting of that name, one is given twice, or a value has the wrong type.
        ValueError: A value is not allowed.
    """
    if "advised" in settings:
        settings = {**settings, "advised": advised_text(settings["advised"])}
    arguments = _arguments(name, hold, advice, driver, settings)
    try:
        with InWordsOfPython(_given(hold=hold, advice=advice)):
            return Configuration(*arguments)
    except ValueError as fault:
        if is_ring(name):
            raise
        raise ValueError(f"{fault}\n  remedy: traffic='sumo' drives other maps") from None


def drive_configuration(
    name: str,
    traffic: str,
    hold: float | None,
    advice: str | None,
    driver: str | None,
    settings: dict[str, Any],
) -> tuple[DriveConfiguration, Arguments]:
    """Returns the checked settings of a whole drive, and the arguments that make them again in another process.

    Raises:
        TypeError: There is no setting of that name, one is given twice, or a value has the wrong type.
        ValueError: A value is not allowed.
    """
    arguments = _arguments(name, hold, advice, driver, {**settings, "traffic": traffic}, ("traffic",))
    with InWordsOfPython(_given(hold=hold, advice=advice)):
        return DriveConfiguration(*arguments), arguments


def _given(**shorter: Any) -> list[str]:
    return [argument for argument, value in shorter.items() if value is not None]


def _arguments(
    name: str,
    hold: float | None,
    advice: str | None,
    driver: str | None,
    settings: dict[str, Any],
    allowed: tuple[str, ...] = (),
) -> Arguments:
    """Returns the arguments; ``allowed`` are the misplaced ones that are not misplaced here."""
    for short, given, long in (("hold", hold, "hold_s"), ("advice", advice, "action")):
        if given is not None:
            if long in settings:
                raise TypeError(f"{short} and {long} are the same setting: give one of them")
            settings = {**settings, long: given}
    for what, text in (("name", name), ("driver", driver)):
        if text is not None and not isinstance(text, str):
            raise TypeError(f"{what} is {text!r}; allowed: a text")
    for argument, why in _MISPLACED.items():
        if argument in settings and argument not in allowed:
            raise TypeError(f"{argument}: {why}")
    return Arguments(name, driver, settings)


def settings(name: str = "ring-250", **changes: Any) -> dict[str, Any]:
    """Returns all settings as ``make`` would take them: names and values, tables as dicts, SI units.

    Raises:
        TypeError: There is no setting of that name.
        ValueError: A value is not allowed.
    """
    traffic = traffic_of(name, changes.pop("traffic", None))
    arguments = {key: changes.pop(key, None) for key in ("hold", "advice", "driver")}
    if traffic == "ring":
        return json.loads(configuration(name, **arguments, settings=changes).json())
    changes.pop("seed", None)
    own = json.loads(drive_configuration(name, traffic, **arguments, settings=changes)[0].json())
    del own["map"]
    # The settings do not contain the driver drawn for each drive.
    return own if arguments["driver"] is None else {**own, "driver": arguments["driver"]}


def sumo_variables() -> dict[str, str]:
    """Returns environment variables with which a process finds SUMO; none if it finds SUMO anyway, else the place of the pip package.

    Raises:
        DependencyNotInstalled: SUMO is not installed.
    """
    is_said = bool(os.environ.get("CODRIVE_SUMO_HOME")) or _holds_sumo(os.environ.get("SUMO_HOME"))
    if not is_said:
        try:
            package = importlib.util.find_spec("sumo")
        except ValueError:
            package = None
        home = os.path.dirname(package.origin) if package is not None and package.origin else None
        if _holds_sumo(home):
            return {"SUMO_HOME": home}
    if sumo_home() is None:
        raise DependencyNotInstalled(_NO_SUMO)
    return {}


def _holds_sumo(home: str | None) -> bool:
    """Returns True if the folder has the SUMO library that drives need."""
    return bool(home) and any(any((pathlib.Path(home) / folder).glob("*sumocpp*")) for folder in ("lib64", "lib", "bin"))
