"""``make``, ``make_vec`` and ``make_parallel``, and the same environments by Gymnasium's ids."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import gymnasium
from gymnasium.envs.registration import registry

from codrive._drive import DriveEnv
from codrive._drive_vector import DriveVectorEnv
from codrive._ring import RingEnv, RingVectorEnv
from codrive._settings import engine_of

if TYPE_CHECKING:
    from codrive._parallel import DriveParallelEnv

#: Ids of Gymnasium and the ring that each is.
IDS = {"codrive/Ring250-v0": "ring-250", "codrive/Ring641-v0": "ring-641"}
#: The id of whole drives, whose map is ``name=``.
DRIVE_ID = "codrive/Drive-v0"


def register() -> None:
    """Makes the ids of ``IDS`` and ``DRIVE_ID`` known to Gymnasium. Importing codrive does it; a second time does nothing."""
    for name, ring in IDS.items():
        if name not in registry:
            gymnasium.register(
                name,
                entry_point="codrive:RingEnv",
                vector_entry_point="codrive:RingVectorEnv",
                kwargs={"name": ring},
            )
    if DRIVE_ID not in registry:
        gymnasium.register(DRIVE_ID, entry_point="codrive:DriveEnv", vector_entry_point="codrive:DriveVectorEnv")


def make(
    name: str = "ring-250",
    *,
    hold: float | None = None,
    advice: str | None = None,
    driver: str | None = None,
    engine: str | None = None,
    render_mode: str | None = None,
    **settings: Any,
) -> gymnasium.Env:
    """One environment: a ring of the fast engine, or a whole drive.

    Args:
        name: ``"ring-250"`` or ``"ring-641"``; the FILE.toml of a training's configuration, which is a ring, too; for whole drives any
            shipped map, or the folder or net.xml of an imported one.
        hold: How long one action stands, s; the setting ``hold_s``.
        advice: ``"acceleration"`` or ``"speed"``: what an action is; the setting ``action``.
        driver: Who follows the advice. ``"follow"``, ``"perfect"``, ``"sloppy"``, ``"idm"``, ``"exact"`` and ``"guarded"`` are the
            same in each episode, ``"late"``, ``"people"``, ``"perp"`` and ``"anyone"`` are drawn for each; or numbers,
            ``"reaction=1,error=0.5"`` (s, m/s). Without one, as the settings say: on rings to the letter.
        engine: What moves the cars: ``"ring"``, the fast ring of training; ``"sumo"``, a whole drive with the physics of a car among
            SUMO's traffic, in a process of its own; ``"native"``, the same among the traffic of the native engine, on closed single
            lanes. None: ``"ring"`` for rings, ``"sumo"`` for all else.
        render_mode: ``"rgb_array"`` draws whole drives, as ``view`` (``"driver"``, ``"mirror"``, ``"birdseye"``, ``"chase"``) and
            ``size`` (pixels) say, where the package is built with its renderer; None: nothing is drawn.
        **settings: Any setting of ``codrive train`` by its own name, of whole drives those of ``codrive run`` and what an episode needs
            (``codrive.settings(name, engine=...)`` lists them); a table is a dict, ``idm={"v0": 20.0}``. They come after ``driver`` and
            change him, too.

    Returns:
        A ``RingEnv`` or a ``DriveEnv``.

    Raises:
        TypeError: There is no setting of that name.
        ValueError: A value is not allowed; the message says what is.
        gymnasium.error.DependencyNotInstalled: SUMO, or the renderer, is needed and not there.
    """
    engine = engine_of(name, engine)
    own = settings if engine == "ring" else {**settings, "engine": engine}
    kind = RingEnv if engine == "ring" else DriveEnv
    return kind(name, hold=hold, advice=advice, driver=driver, render_mode=render_mode, **own)


def make_vec(
    name: str = "ring-250",
    num_envs: int = 1,
    *,
    hold: float | None = None,
    advice: str | None = None,
    driver: str | None = None,
    engine: str | None = None,
    copy: bool = True,
    render_mode: str | None = None,
    **settings: Any,
) -> gymnasium.vector.VectorEnv:
    """Many rings as one environment, moved by all cores at once; or many whole drives, each in a process of its own.

    Args:
        name: As ``make``.
        num_envs: Rings, 1 to 65,536. Blocks of 16 move together: a multiple of 16 wastes nothing. Of whole drives 1 to 1,024.
        hold: As ``make``.
        advice: As ``make``.
        driver: As ``make``.
        engine: As ``make``.
        copy: False: ``step`` and ``reset`` of rings give the same arrays each time, and the next call overwrites them.
        render_mode: As ``make``.
        **settings: As ``make``.

    Returns:
        A ``RingVectorEnv`` or a ``DriveVectorEnv``.

    Raises:
        TypeError: There is no setting of that name.
        ValueError: A value is not allowed; the message says what is.
        gymnasium.error.DependencyNotInstalled: SUMO, or the renderer, is needed and not there.
    """
    engine = engine_of(name, engine)
    own = settings if engine == "ring" else {**settings, "engine": engine}
    kind = RingVectorEnv if engine == "ring" else DriveVectorEnv
    return kind(name, num_envs, hold=hold, advice=advice, driver=driver, copy=copy, render_mode=render_mode, **own)


def make_parallel(
    name: str = "ring-250",
    *,
    advised: str | float,
    hold: float | None = None,
    advice: str | None = None,
    driver: str | None = None,
    engine: str | None = None,
    render_mode: str | None = None,
    **settings: Any,
) -> DriveParallelEnv:
    """One whole drive with several advised vehicles, each an agent of a ``pettingzoo.ParallelEnv``.

    Args:
        name: As ``make``.
        advised: How many vehicles are advised, the participant's the first: a share of all (``"20%"``, ``0.2``; on a network of the cars
            that come) or a number (``3``).
        hold: As ``make``.
        advice: As ``make``.
        driver: As ``make``; each agent has one of his own.
        engine: ``"sumo"`` or ``"native"``; None: ``"native"`` for rings, ``"sumo"`` for all else. ``"ring"`` has one advised vehicle in
            each ring.
        render_mode: As ``make``.
        **settings: As ``make`` of whole drives.

    Raises:
        TypeError: There is no setting of that name.
        ValueError: A value is not allowed; the message says what is.
        ImportError: PettingZoo is not installed.
        gymnasium.error.DependencyNotInstalled: SUMO, or the renderer, is needed and not there.
    """
    from codrive._parallel import DriveParallelEnv

    return DriveParallelEnv(
        name, advised=advised, hold=hold, advice=advice, driver=driver, engine=engine, render_mode=render_mode, **settings
    )
