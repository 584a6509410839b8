"""``make`` and ``make_vec``, and the same environments by Gymnasium's ids."""

from __future__ import annotations

import difflib
from typing import Any

import gymnasium
from gymnasium.envs.registration import registry

from codrive._ring import RingEnv, RingVectorEnv

#: Ids of Gymnasium and the ring that each is.
IDS = {"codrive/Ring250-v0": "ring-250", "codrive/Ring641-v0": "ring-641"}

#: What moves the cars, by name: the classes of one environment and of many.
_ENGINES: dict[str, tuple[type[gymnasium.Env], type[gymnasium.vector.VectorEnv]]] = {"ring": (RingEnv, RingVectorEnv)}


def register() -> None:
    """Makes the ids of ``IDS`` known to Gymnasium. Importing codrive does it; a second time does nothing."""
    for name, ring in IDS.items():
        if name not in registry:
            gymnasium.register(
                name,
                entry_point="codrive:RingEnv",
                vector_entry_point="codrive:RingVectorEnv",
                kwargs={"name": ring},
            )


def _engine(name: str) -> tuple[type[gymnasium.Env], type[gymnasium.vector.VectorEnv]]:
    if name in _ENGINES:
        return _ENGINES[name]
    near = difflib.get_close_matches(str(name), _ENGINES, n=1)
    meant = f" (did you mean {near[0]}?)" if near else ""
    raise ValueError(f"engine is {name!r}{meant}; allowed: {', '.join(_ENGINES)}")


def make(
    name: str = "ring-250",
    *,
    hold: float | None = None,
    advice: str | None = None,
    driver: str | None = None,
    engine: str = "ring",
    render_mode: None = None,
    **settings: Any,
) -> gymnasium.Env:
    """One ring as an environment.

    Args:
        name: ``"ring-250"`` or ``"ring-641"``, or the FILE.toml of a training's configuration.
        hold: How long one action stands, s; the setting ``hold_s``.
        advice: ``"acceleration"`` or ``"speed"``: what an action is; the setting ``action``.
        driver: Who follows the advice. ``"follow"``, ``"perfect"``, ``"sloppy"``, ``"idm"``, ``"exact"`` and ``"guarded"`` are the
            same in each episode, ``"late"``, ``"people"``, ``"perp"`` and ``"anyone"`` are drawn for each; or numbers,
            ``"reaction=1,error=0.5"`` (s, m/s). Without one, as the settings say: to the letter.
        engine: What moves the cars: ``"ring"``, the fast ring of training.
        render_mode: None: rings are not drawn.
        **settings: Any setting of ``codrive train`` by its own name (``codrive.settings()`` lists them); a table is a dict,
            ``idm={"v0": 20.0}``. They come after ``driver`` and change him, too.

    Returns:
        A ``RingEnv``.

    Raises:
        TypeError: There is no setting of that name.
        ValueError: A value is not allowed; the message says what is.
    """
    return _engine(engine)[0](name, hold=hold, advice=advice, driver=driver, render_mode=render_mode, **settings)


def make_vec(
    name: str = "ring-250",
    num_envs: int = 1,
    *,
    hold: float | None = None,
    advice: str | None = None,
    driver: str | None = None,
    engine: str = "ring",
    copy: bool = True,
    render_mode: None = None,
    **settings: Any,
) -> gymnasium.vector.VectorEnv:
    """Many rings as one environment, moved by all cores at once.

    Args:
        name: As ``make``.
        num_envs: Rings, 1 to 65,536. Blocks of 16 move together: a multiple of 16 wastes nothing.
        hold: As ``make``.
        advice: As ``make``.
        driver: As ``make``.
        engine: As ``make``.
        copy: False: ``step`` and ``reset`` give the same arrays each time, and the next call overwrites them.
        render_mode: As ``make``.
        **settings: As ``make``.

    Returns:
        A ``RingVectorEnv``.

    Raises:
        TypeError: There is no setting of that name.
        ValueError: A value is not allowed; the message says what is.
    """
    vector = _engine(engine)[1]
    return vector(
        name, num_envs=num_envs, hold=hold, advice=advice, driver=driver, copy=copy, render_mode=render_mode, **settings
    )
