"""Vehicles of fast rings as columns, and their pictures."""

from __future__ import annotations

import json

import numpy as np
from numpy.typing import NDArray

from codrive_sim._camera import Camera, Pictures, no_renderer
from codrive_sim._codrive import CAR_SIZE_M, Configuration, Rings
from codrive_sim._drives import Road
from codrive_sim._traffic import Vehicles, car_of

#: Width of a lane of which no file states one, m.
_LANE_WIDTH_M = 3.2
#: Views of fast rings, and the largest number of rings that are drawn.
VIEWS = ("schematic",)
_MOST_DRAWN = 64


class RingPictures:
    """Pictures of some rings."""

    def __init__(self, camera: Camera, num_envs: int, settings: Configuration) -> None:
        """
        Raises:
            ValueError: There are too many rings to draw.
        """
        if camera.is_on and num_envs > _MOST_DRAWN:
            raise ValueError(f"num_envs is {num_envs}; allowed with a render_mode: 1 to {_MOST_DRAWN}")
        known = json.loads(settings.json())
        self._cars = numbers_of(settings.possible_agents())
        self._hold_s: float = known["hold_s"]
        self._times_s = np.zeros(num_envs)
        self._of_rings = [Pictures(camera, known["top_speed_mps"]) for _ in range(num_envs if camera.is_on else 0)]

    def note(self, rings: Rings, begun: NDArray[np.bool_], has_ended: bool = False) -> None:
        """Notes the present moment of all rings; ``begun`` marks rings whose episodes have just begun. ``has_ended``: at the end of the last
        episodes."""
        if not self._of_rings:
            return
        columns, lengths_m, times_s = ring_columns(rings, has_ended, self._cars), rings.circumferences_m(has_ended), rings.times_s()
        for ring, pictures in enumerate(self._of_rings):
            if begun[ring]:
                # Each episode has a ring of its own length.
                pictures.clear(is_road_new=True)
            is_there = columns.lane[ring] >= 0
            vehicles = Vehicles(*(column[ring, is_there] for column in columns))
            time_s = self._times_s[ring] + self._hold_s if has_ended else times_s[ring]
            pictures.note(lambda length_m=lengths_m[ring]: _road(length_m), time_s, vehicles)
            pictures.show(no_renderer)
        self._times_s = times_s

    def drawn(self) -> list[NDArray[np.uint8]]:
        """Returns the present picture of each ring, uint8, ``(height, width, 3)``."""
        return [pictures.picture(no_renderer) for pictures in self._of_rings]

    def render(self) -> NDArray[np.uint8] | None:
        """Returns the present picture of the first ring; None where there is none or a window shows it."""
        return self._of_rings[0].render(no_renderer) if self._of_rings else None

    def close(self) -> None:
        """Closes the windows."""
        for pictures in self._of_rings:
            pictures.close()


def _road(length_m: float) -> Road:
    """Returns a ring of this length."""
    angle_rad = np.linspace(0.0, 2.0 * np.pi, 181)
    points_m = length_m / (2.0 * np.pi) * np.stack([np.cos(angle_rad), np.sin(angle_rad)], axis=1)
    return Road([("ring_0", _LANE_WIDTH_M, points_m)], float(length_m), True)


def numbers_of(agents: list[str]) -> NDArray[np.uint32]:
    """Returns the numbers of these vehicles."""
    return np.array([car_of(agent) for agent in agents], np.uint32)


def ring_columns(rings: Rings, has_ended: bool, cars: NDArray[np.uint32]) -> Vehicles:
    """Returns all vehicles, of which those with these numbers are advised, each column ``(rings, vehicles)``, at the end of the last
    episodes or now. Rings are drawn as circles, the start of the lane in the east."""
    s_m, speed_mps = rings.vehicles(has_ended)
    radius_m = (rings.circumferences_m(has_ended) / (2.0 * np.pi))[:, None]
    # A vehicle's place is that of its front, x and y are those of its middle.
    middle_rad = (s_m - CAR_SIZE_M[0] / 2.0) / radius_m
    is_there = np.isfinite(s_m)

    def of_all(value: float) -> NDArray[np.float64]:
        return np.where(is_there, value, np.nan)

    car = np.broadcast_to(np.arange(s_m.shape[1], dtype=np.uint32), s_m.shape)
    return Vehicles(
        car=car,
        is_advised=np.isin(car, cars) & is_there,
        lane=np.where(is_there, 0, -1).astype(np.int32),
        lane_s_m=s_m,
        lane_offset_m=of_all(0.0),
        s_m=s_m,
        x_m=radius_m * np.cos(middle_rad),
        y_m=radius_m * np.sin(middle_rad),
        yaw_rad=np.remainder(middle_rad + np.pi / 2.0, 2.0 * np.pi),
        speed_mps=speed_mps,
        accel_mps2=of_all(np.nan),
        length_m=of_all(CAR_SIZE_M[0]),
        width_m=of_all(CAR_SIZE_M[1]),
    )
