"""Settings from keyword arguments."""

from __future__ import annotations

import json
from typing import Any

from codrive._codrive import Configuration


def configuration(
    name: str,
    hold: float | None,
    advice: str | None,
    driver: str | None,
    settings: dict[str, Any],
) -> Configuration:
    """The checked settings that these arguments of ``make`` ask for.

    Raises:
        TypeError: There is no setting of that name, one is given twice, or a value has the wrong type.
        ValueError: A value is not allowed.
    """
    for short, given, long in (("hold", hold, "hold_s"), ("advice", advice, "action")):
        if given is not None:
            if long in settings:
                raise TypeError(f"{short} and {long} are the same setting: give one of them")
            settings = {**settings, long: given}
    for what, text in (("name", name), ("driver", driver)):
        if text is not None and not isinstance(text, str):
            raise TypeError(f"{what} is {text!r}; allowed: a text")
    return Configuration(name, driver, settings)


def settings(name: str = "ring-250", **changes: Any) -> dict[str, Any]:
    """All settings of a ring as ``make`` would take them: names and values, tables as dicts, SI units.

    Raises:
        TypeError: There is no setting of that name.
        ValueError: A value is not allowed.
    """
    arguments = {key: changes.pop(key, None) for key in ("hold", "advice", "driver")}
    return json.loads(configuration(name, **arguments, settings=changes).json())
