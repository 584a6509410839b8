"""Pictures of environments: views of the program's renderer, and the schematic of the road and its traffic."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import NDArray

from codrive_sim._codrive import HAS_DESKTOP
from codrive_sim._drives import Road
from codrive_sim._schematic import RoadShape, Scene, Schematic
from codrive_sim._show import Window, can_show
from codrive_sim._spaces import NEVER, RendererMissing, RenderModeError
from codrive_sim._traffic import Vehicles
from codrive_sim._words import did_you_mean

#: Modes of drawing: an array from ``render()``, or a window that each step draws; a vector environment has no window.
RENDER_MODES = ("rgb_array", "human")
VECTOR_RENDER_MODES = RENDER_MODES[:1]
#: Modes that are possible here: without a display or a notebook there is no window.
POSSIBLE_MODES = [mode for mode in RENDER_MODES if mode != "human" or can_show()]
#: Views of the renderer, and the schematic.
VIEWS = ("driver", "mirror", "birdseye", "chase", "schematic")
#: Largest side of a picture, pixels.
_MOST_PIXELS = 8192

_NO_RENDERER = (
    "view={!r} needs codrive built with its renderer: pip install ./python --config-settings=build-args='--features desktop'; "
    "view='schematic' does not"
)


class Camera:
    """Mode, view and size of the pictures of an environment. Without a view it is ``"driver"`` where the renderer is built, else the
    schematic; rings of the fast engine have the schematic alone."""

    def __init__(
        self,
        render_mode: str | None,
        view: str | None,
        size: tuple[int, int],
        modes: tuple[str, ...] = RENDER_MODES,
        views: tuple[str, ...] = VIEWS,
    ) -> None:
        """
        Raises:
            ValueError: The mode, view or size is invalid.
            DependencyNotInstalled: The package was built without its renderer, or there is no place for a window.
        """
        if render_mode not in (None, *modes):
            raise RenderModeError(f"render_mode is {render_mode!r}; allowed: None, {', '.join(map(repr, modes))}")
        if view is not None and view not in views:
            others = "" if views == VIEWS else "; traffic='native' and traffic='sumo' have the others"
            raise ValueError(f"view is {view!r}{did_you_mean(view, views)}; allowed: {', '.join(views)}{others}")
        sides = tuple(size) if isinstance(size, (tuple, list)) else ()
        if len(sides) != 2 or not all(type(side) is int and 1 <= side <= _MOST_PIXELS for side in sides):
            raise ValueError(f"size is {size!r}; allowed: (width, height) in pixels, each from 1 to {_MOST_PIXELS}")
        self.view: str = view if view is not None else VIEWS[0] if HAS_DESKTOP and VIEWS[0] in views else "schematic"
        if render_mode is not None and self.view != "schematic" and not HAS_DESKTOP:
            raise RendererMissing(_NO_RENDERER.format(self.view))
        self.size: tuple[int, int] = (sides[0], sides[1])
        #: Arguments of ``LocalDrive.render``.
        self.arguments = (*self.size, self.view)
        self.is_on = render_mode is not None
        self.is_shown = render_mode == "human"
        self.is_schematic = self.is_on and self.view == "schematic"


def picture_metadata(hold_s: float, modes: tuple[str, ...] = RENDER_MODES) -> dict[str, Any]:
    """Returns Gymnasium's metadata for an environment with steps of this length."""
    return {"render_modes": [mode for mode in POSSIBLE_MODES if mode in modes], "render_fps": 1.0 / hold_s}


class Pictures:
    """Pictures of one environment."""

    def __init__(self, camera: Camera, top_speed_mps: float) -> None:
        """``top_speed_mps`` is the end of the scale of colours of the schematic."""
        self.camera = camera
        self._top_speed_mps = top_speed_mps
        self._schematic: Schematic | None = None
        self._window = Window("codrive") if camera.is_shown else None

    def clear(self, is_road_new: bool = False) -> None:
        """Forgets what was noted, because an episode begins; also the road if it is another one."""
        if is_road_new:
            self._schematic = None
        elif self._schematic is not None:
            self._schematic.clear()

    def note(self, road: Callable[[], Road], time_s: float, vehicles: Vehicles) -> None:
        """Notes the present moment for the schematic; ``road`` is called once for each road."""
        if self._schematic is None:
            self._schematic = Schematic(_shape(road()), self.camera.size, self._top_speed_mps)
        v = vehicles
        self._schematic.note(
            Scene(time_s, v.x_m, v.y_m, v.yaw_rad, v.length_m, v.width_m, v.speed_mps, v.s_m, v.is_advised)
        )

    def picture(self, of_renderer: Callable[[], NDArray[np.uint8]]) -> NDArray[np.uint8]:
        """Returns the present picture, uint8, ``(height, width, 3)``; ``of_renderer`` makes that of other views than the schematic."""
        return of_renderer() if self._schematic is None else self._schematic.draw()

    def render(self, of_renderer: Callable[[], NDArray[np.uint8]]) -> NDArray[np.uint8] | None:
        """Returns the result of Gymnasium's ``render``: a picture, or None where there is none or a window shows it."""
        return self.picture(of_renderer) if self.camera.is_on and not self.camera.is_shown else None

    def show(self, of_renderer: Callable[[], NDArray[np.uint8]]) -> None:
        """Shows the present picture in the window, if there is one."""
        if self._window is not None:
            self._window.show(self.picture(of_renderer))

    def close(self) -> None:
        """Closes the window."""
        if self._window is not None:
            self._window.close()


def no_renderer() -> NDArray[np.uint8]:
    """Raises the error of a picture before an episode.

    Raises:
        ResetNeeded: Always.
    """
    raise ResetNeeded(NEVER)


def _shape(road: Road) -> RoadShape:
    """Returns a road for the schematic."""
    return RoadShape([points for *_, points in road.lanes], [width_m for _, width_m, _ in road.lanes], road.is_closed, road.length_m)
