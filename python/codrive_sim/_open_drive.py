"""Traffic of a drive for its user: columns of vehicles, signals and lanes, orders, and the state of the drive."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from codrive_sim._drive_series import DriveSeries
from codrive_sim._drives import Leaders
from codrive_sim._traffic import Vehicles, car_of


class Lane(NamedTuple):
    """Lane of the road: SUMO's id, width, m, and centre line, float64, ``(points, 2)``, metres to the east and north."""

    id: str
    width_m: float
    points_m: NDArray[np.float64]


class OpenDrive:
    """Part of the environments of one drive that shows its traffic and takes orders.

    All of it raises ``ResetNeeded`` before an episode has begun. Orders count from the next hold on. They need traffic of SUMO on a network.
    """

    _series: DriveSeries

    @property
    def vehicles(self) -> Vehicles:
        """Returns all vehicles now as columns."""
        return Vehicles.of(self._series.seen().columns)

    @property
    def signals(self) -> dict[str, str]:
        """Returns the letters that each signal shows now, one for each of its links, by SUMO's ids."""
        return dict(self._series.seen().signals)

    @property
    def time_s(self) -> float:
        """Returns the time since the episode began, s."""
        return self._series.seen().time_s

    @property
    def lanes(self) -> list[Lane]:
        """Returns all lanes of the road, those inside junctions, too."""
        return [Lane(*lane) for lane in self._series.road().lanes]

    def leaders(self, reach_m: float = 250.0) -> Leaders:
        """Returns the vehicle ahead of each of ``vehicles`` on its way within ``reach_m``, also across junctions: its number, -1 without one,
        and the gap, m. Only in traffic of SUMO on a network.

        Raises:
            ValueError: ``reach_m`` is not above 0, or vehicles have no ways here.
        """
        if not (np.isfinite(reach_m) and reach_m > 0.0):
            raise ValueError(f"reach_m is {reach_m!r}; allowed: above 0, m")
        return self._series.leaders(float(reach_m))

    def names(self, vehicles: ArrayLike) -> list[tuple[str, str]]:
        """Returns for vehicles of these numbers, as ``env.vehicles.car`` has them, the name in the demand and that of the type. Only in traffic
        of SUMO on a network.

        Raises:
            ValueError: There is no such vehicle, or vehicles have no names here.
        """
        return self._series.names([int(car) for car in np.asarray(vehicles).ravel()])

    def set_speed(self, vehicle: str | int, speed_mps: float, within_s: float = 0.0) -> None:
        """Orders a vehicle to change its speed evenly within a time, s, in the next step of SUMO at least; afterwards its model drives on. It
        obeys its checks (``set_speed_mode``). Advised vehicles follow their advice instead.

        Raises:
            ValueError: There is no such vehicle, it cannot be ordered, or a number is negative.
        """
        self._series.order("set_speed", car_of(vehicle), _at_least_0("speed_mps", speed_mps), _at_least_0("within_s", within_s))

    def set_max_speed(self, vehicle: str | int, speed_mps: float) -> None:
        """Orders the model of a vehicle to drive at this speed at most, until the next order. Advised vehicles follow their advice instead.

        Raises:
            ValueError: There is no such vehicle, it cannot be ordered, or the speed is negative.
        """
        self._series.order("set_max_speed", car_of(vehicle), _at_least_0("speed_mps", speed_mps))

    def set_speed_mode(self, vehicle: str | int, mode: int) -> None:
        """Orders a vehicle to obey these checks, the sum of SUMO's bits: 1 safe speed, 2 and 4 limits of acceleration and braking, 8 right of
        way, 16 red lights. 31, all of them, is what vehicles begin with.

        Raises:
            ValueError: There is no such vehicle, it cannot be ordered, or the mode is not from 0 to 63.
        """
        if isinstance(mode, bool) or not isinstance(mode, (int, np.integer)) or not 0 <= mode < 64:
            raise ValueError(f"mode is {mode!r}; allowed: a whole number from 0 to 63")
        self._series.order("set_speed_mode", car_of(vehicle), int(mode))

    def change_lane(self, vehicle: str | int, to_the_left: int, within_s: float = 5.0) -> None:
        """Orders a vehicle to change lanes, as soon as there is room: by this many to the left, negative to the right; 0 is to stay.

        From then on it changes lanes by order only, also where its route needs another lane. An order for a lane that does not exist has no
        effect. The participant's vehicle and others with a full body keep to their paths.

        Raises:
            ValueError: There is no such vehicle, or it cannot be ordered.
        """
        if isinstance(to_the_left, bool) or not isinstance(to_the_left, (int, np.integer)):
            raise ValueError(f"to_the_left is {to_the_left!r}; allowed: a whole number of lanes")
        if not (np.isfinite(within_s) and within_s > 0.0):
            raise ValueError(f"within_s is {within_s!r}; allowed: above 0, s")
        self._series.order("change_lane", car_of(vehicle), int(to_the_left), float(within_s))

    def set_route(self, vehicle: str | int, edges: list[str]) -> None:
        """Orders a vehicle to drive along these edges, by SUMO's ids, of which it is on the first.

        Raises:
            ValueError: There is no such vehicle, it cannot be ordered, or the edges are no route from where it is.
        """
        self._series.order("set_route", car_of(vehicle), [str(edge) for edge in edges])

    def set_signal(self, signal: str, shows: int | str) -> None:
        """Orders a signal, by SUMO's id, to begin the phase of this number of its programme, which goes on from there; or to show these
        letters, one for each of its links, until the next order.

        Raises:
            ValueError: There is no such signal or phase, or the letters are not as many as the signal's links.
        """
        if isinstance(shows, str):
            self._series.order("set_letters", signal, shows)
        elif isinstance(shows, (int, np.integer)) and not isinstance(shows, bool) and shows >= 0:
            self._series.order("set_phase", signal, int(shows))
        else:
            raise ValueError(f"shows is {shows!r}; allowed: the number of a phase, or letters")

    def get_state(self) -> dict[str, Any]:
        """Returns the state of the drive: its seed, and all that it was told since. It can be pickled."""
        return self._series.state()

    def fingerprint(self) -> str:
        """Returns a hash over all states of this drive so far; equal states have equal hashes, to the bit."""
        return self._series.fingerprint()

    def render(self) -> NDArray[np.uint8] | None:
        """Returns the present picture, uint8, ``(height, width, 3)``; None without a ``render_mode``."""
        return self._series.render()

    def close(self) -> None:
        """Ends the drive; the environment cannot be used afterwards."""
        self._series.close()


def _at_least_0(what: str, value: float) -> float:
    """
    Raises:
        ValueError: The number is negative, or not finite.
    """
    if not (np.isfinite(value) and value >= 0.0):
        raise ValueError(f"{what} is {value!r}; allowed: 0 or more")
    return float(value)
