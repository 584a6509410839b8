"""``make``, ``make_vec`` and ``make_parallel``, and the same environments by their Gymnasium ids."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, overload

import gymnasium
from gymnasium.envs.registration import registry

from codrive_sim._drive import DriveEnv
from codrive_sim._drive_vector import DriveVectorEnv
from codrive_sim._ring import RingEnv, RingVectorEnv
from codrive_sim._settings import traffic_of
from codrive_sim.benchmarks import BENCHMARKS

if TYPE_CHECKING:
    from codrive_sim._parallel import DriveParallelEnv

#: Shipped rings, and shipped maps of which all environments are whole drives.
Ring = Literal["ring-250", "ring-641"]
DriveMap = Literal["bottleneck", "figure-eight", "grid", "merge", "motorway", "practice", "town", "two-lane-ring"]

#: Gymnasium ids and their rings.
IDS = {"codrive/Ring250-v0": "ring-250", "codrive/Ring641-v0": "ring-641"}
#: Gymnasium id of whole drives; ``name=`` sets the map.
DRIVE_ID = "codrive/Drive-v0"


def register() -> None:
    """Registers the ids of ``IDS``, ``BENCHMARKS`` and ``DRIVE_ID`` with Gymnasium. The import of codrive calls it; another call does nothing."""
    for name, ring in IDS.items():
        if name not in registry:
            gymnasium.register(
                name,
                entry_point="codrive_sim:RingEnv",
                vector_entry_point="codrive_sim:RingVectorEnv",
                kwargs={"name": ring},
            )
    for benchmark in BENCHMARKS:
        if f"codrive/{benchmark.name}" not in registry:
            entry = f"codrive_sim.benchmarks:{benchmark.kind}"
            gymnasium.register(f"codrive/{benchmark.name}", entry_point=entry, kwargs=benchmark.arguments)
    if DRIVE_ID not in registry:
        gymnasium.register(DRIVE_ID, entry_point="codrive_sim:DriveEnv", vector_entry_point="codrive_sim:DriveVectorEnv")


@overload
def make(
    name: Ring = "ring-250",
    *,
    hold: float | None = None,
    advice: str | None = None,
    driver: str | None = None,
    traffic: Literal["ring"] | None = None,
    render_mode: str | None = None,
    **settings: Any,
) -> RingEnv: ...


@overload
def make(
    name: str = "ring-250",
    *,
    hold: float | None = None,
    advice: str | None = None,
    driver: str | None = None,
    traffic: Literal["native", "sumo"],
    render_mode: str | None = None,
    **settings: Any,
) -> DriveEnv: ...


@overload
def make(
    name: DriveMap,
    *,
    hold: float | None = None,
    advice: str | None = None,
    driver: str | None = None,
    traffic: None = None,
    render_mode: str | None = None,
    **settings: Any,
) -> DriveEnv: ...


@overload
def make(
    name: str = "ring-250",
    *,
    hold: float | None = None,
    advice: str | None = None,
    driver: str | None = None,
    traffic: str | None = None,
    render_mode: str | None = None,
    **settings: Any,
) -> RingEnv | DriveEnv: ...


def make(
    name: str = "ring-250",
    *,
    hold: float | None = None,
    advice: str | None = None,
    driver: str | None = None,
    traffic: str | None = None,
    render_mode: str | None = None,
    **settings: Any,
) -> RingEnv | DriveEnv:
    """Makes one environment: a ring of the fast engine, or a whole drive.

    Args:
        name: ``"ring-250"`` or ``"ring-641"``; the FILE.toml of a training configuration, which is a ring, too; for whole drives any
            shipped map, or the folder or net.xml of an imported one.
        hold: Duration of one action, s; the setting ``hold_s``.
        advice: Meaning of an action, ``"acceleration"`` or ``"speed"``; the setting ``action``.
        driver: Driver who follows the advice. ``"follow"``, ``"perfect"``, ``"sloppy"``, ``"idm"``, ``"exact"`` and ``"guarded"`` are the
            same in each episode; ``"late"``, ``"people"``, ``"perp"`` and ``"anyone"`` are drawn for each. Or parameters,
            ``"reaction=1,error=0.5"`` (s, m/s). None: as in the settings; on rings the driver follows exactly.
        traffic: Engine of the traffic: ``"ring"``, the fast ring of training; ``"sumo"``, a whole drive with vehicle physics in SUMO's
            traffic, in a process of its own; ``"native"``, the same in the traffic of the native engine, on closed single lanes;
            the path of a file of trajectories (``.csv``), behind whose vehicles the ego and those of the native engine drive on an open
            lane. None: ``"ring"`` for rings, ``"sumo"`` for all else.
        render_mode: ``"rgb_array"``: ``render()`` returns a picture. ``"human"``: each step shows it in a window or in the notebook. None:
            nothing is drawn. ``view="schematic"`` is the road from above with all vehicles, beside a space-time diagram. Whole drives also
            have ``"driver"`` (their default), ``"mirror"``, ``"birdseye"`` and ``"chase"``, if the package is built with its renderer.
            ``size=(1280, 720)``, pixels.
        **settings: ``own_process=False`` runs SUMO in this process, which holds one at a time: a step has no messages to wait for, and a
            crash of SUMO ends Python. ``reward``, ``observation`` and ``observation_space`` of your own (docs/python.md). Any setting of
            ``codrive train`` by its own name; for whole drives those of ``codrive run`` and of episodes (``codrive_sim.settings(name,
            traffic=...)`` lists them). A table is a dict, ``idm={"v0": 20.0}``. They are applied after ``driver`` and change it, too.

    Returns:
        A ``RingEnv`` or a ``DriveEnv``.

    Raises:
        TypeError: There is no setting of that name.
        ValueError: A value is not allowed; the message lists the allowed ones.
        gymnasium.error.DependencyNotInstalled: SUMO or the renderer is needed and not installed.
    """
    traffic = traffic_of(name, traffic)
    own = settings if traffic == "ring" else {**settings, "traffic": traffic}
    kind = RingEnv if traffic == "ring" else DriveEnv
    return kind(name, hold=hold, advice=advice, driver=driver, render_mode=render_mode, **own)


@overload
def make_vec(
    name: Ring = "ring-250",
    num_envs: int = 1,
    *,
    hold: float | None = None,
    advice: str | None = None,
    driver: str | None = None,
    traffic: Literal["ring"] | None = None,
    copy: bool = True,
    render_mode: str | None = None,
    **settings: Any,
) -> RingVectorEnv: ...


@overload
def make_vec(
    name: str = "ring-250",
    num_envs: int = 1,
    *,
    hold: float | None = None,
    advice: str | None = None,
    driver: str | None = None,
    traffic: Literal["native", "sumo"],
    copy: bool = True,
    render_mode: str | None = None,
    **settings: Any,
) -> DriveVectorEnv: ...


@overload
def make_vec(
    name: DriveMap,
    num_envs: int = 1,
    *,
    hold: float | None = None,
    advice: str | None = None,
    driver: str | None = None,
    traffic: None = None,
    copy: bool = True,
    render_mode: str | None = None,
    **settings: Any,
) -> DriveVectorEnv: ...


@overload
def make_vec(
    name: str = "ring-250",
    num_envs: int = 1,
    *,
    hold: float | None = None,
    advice: str | None = None,
    driver: str | None = None,
    traffic: str | None = None,
    copy: bool = True,
    render_mode: str | None = None,
    **settings: Any,
) -> RingVectorEnv | DriveVectorEnv: ...


def make_vec(
    name: str = "ring-250",
    num_envs: int = 1,
    *,
    hold: float | None = None,
    advice: str | None = None,
    driver: str | None = None,
    traffic: str | None = None,
    copy: bool = True,
    render_mode: str | None = None,
    **settings: Any,
) -> RingVectorEnv | DriveVectorEnv:
    """Makes many rings as one environment, which runs on all cores; or many whole drives, each in a process of its own.

    Args:
        name: As ``make``.
        num_envs: Number of rings, 1 to 65,536, best a multiple of 16, as blocks of 16 move together; or of whole drives, 1 to 1,024.
        hold: As ``make``.
        advice: As ``make``.
        driver: As ``make``.
        traffic: As ``make``.
        copy: False: ``step`` and ``reset`` of rings return the same arrays each time, and the next call overwrites them.
        render_mode: None or ``"rgb_array"``, as ``make``; up to 64 rings are drawn.
        **settings: As ``make``. ``advised``, a number (``4``) or a share (``"20%"``), makes each advised vehicle of each ring or closed road a
            row, ring after ring; ``envs.agents`` names those of each.

    Returns:
        A ``RingVectorEnv`` or a ``DriveVectorEnv``.

    Raises:
        TypeError: There is no setting of that name.
        ValueError: A value is not allowed; the message lists the allowed ones.
        gymnasium.error.DependencyNotInstalled: SUMO or the renderer is needed and not installed.
    """
    traffic = traffic_of(name, traffic)
    own = settings if traffic == "ring" else {**settings, "traffic": traffic}
    kind = RingVectorEnv if traffic == "ring" else DriveVectorEnv
    return kind(name, num_envs, hold=hold, advice=advice, driver=driver, copy=copy, render_mode=render_mode, **own)


def make_parallel(
    name: str = "ring-250",
    *,
    advised: str | float,
    hold: float | None = None,
    advice: str | None = None,
    driver: str | None = None,
    traffic: str | None = None,
    lane_changes: bool = False,
    render_mode: str | None = None,
    **settings: Any,
) -> DriveParallelEnv:
    """Makes one whole drive with several advised vehicles, each an agent of a ``pettingzoo.ParallelEnv``.

    Args:
        name: As ``make``.
        advised: Number of advised vehicles (``3``), the participant's first; or a share of all (``"20%"``, ``0.2``), on a network of the
            vehicles that enter.
        hold: As ``make``.
        advice: As ``make``.
        driver: As ``make``; each agent has a driver of its own.
        traffic: ``"sumo"``, ``"native"``, or the path of a file of trajectories; None: ``"native"`` for rings, ``"sumo"`` for
            all else. ``make_vec`` has the advised vehicles of fast rings.
        lane_changes: True: an action has a lane beside the advice. For agents on a network, with ``participant=False``.
        render_mode: As ``make``.
        **settings: As ``make`` of whole drives.

    Raises:
        TypeError: There is no setting of that name.
        ValueError: A value is not allowed; the message lists the allowed ones.
        ImportError: PettingZoo is not installed.
        gymnasium.error.DependencyNotInstalled: SUMO or the renderer is needed and not installed.
    """
    from codrive_sim._parallel import DriveParallelEnv

    return DriveParallelEnv(
        name,
        advised=advised,
        hold=hold,
        advice=advice,
        driver=driver,
        traffic=traffic,
        lane_changes=lane_changes,
        render_mode=render_mode,
        **settings,
    )
