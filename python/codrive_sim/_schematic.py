"""Schematic picture of traffic, drawn with numpy alone: the road from above, and the space-time diagram of a route.

Distances in pixels have the suffix ``_px``.
"""

from __future__ import annotations

import copy
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from codrive_sim._raster import INK, OUTLINE, PAPER, Floats, blend, draw_vehicles, measure, speed_colours, text_width, write

#: Colours, red, green and blue from 0 to 255.
_ASPHALT = np.array((176, 181, 188), np.float32)
_EDGE = np.array((226, 229, 233), np.float32)
_GRID = np.array((232, 234, 237), np.float32)
#: Lengths of the time axis from 60 s on, as multiples of powers of ten: a run fills at least three quarters of the axis.
_NICE = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)
_FIRST_SPAN_S = 60.0
#: Longest time between two moments that a line bridges, s: the speed at its end says too little about a longer one.
_BRIDGED_S = 10.0
#: Smallest drawn width of a lane, pixels.
_LEAST_LANE_PX = 1.2
#: Share of the dark outline's colour in lines of advised vehicles, and their weight in the mixed colour of crossing lines, so that they are
#: seen above others.
_DARKENED = 0.7
_ABOVE = 6.0
#: Largest slope of a line in the diagram, pixels per pixel; steeper lines, of several rounds in a few pixels, become dots.
_STEEPEST = 12.0
#: Smallest width and height of a picture with texts and a diagram, pixels; the texts of smaller ones would overlap.
_LEAST_SIZE = (240, 160)


class RoadShape(NamedTuple):
    """Lanes of a road, seen from above."""

    #: Centre lines, ``(points, 2)``, m, x to the east and y to the north.
    lanes: list[NDArray[np.float64]]
    #: Width of each lane, m.
    widths_m: list[float]
    #: Whether the route is a ring, on which vehicles come round again.
    is_closed: bool
    #: Length of the route of the space-time diagram, m; 0 if there is none.
    length_m: float


class Scene(NamedTuple):
    """Vehicles at one moment, each array ``(vehicles,)``."""

    time_s: float
    #: Centres of the vehicles, m.
    x_m: NDArray[np.float64]
    y_m: NDArray[np.float64]
    #: Headings, rad, counter-clockwise from east.
    yaw_rad: NDArray[np.float64]
    length_m: NDArray[np.float64]
    width_m: NDArray[np.float64]
    speed_mps: NDArray[np.float64]
    #: Positions of the fronts along the route, m; NaN for vehicles beside the route.
    s_m: NDArray[np.float64]
    is_advised: NDArray[np.bool_]


class _Box(NamedTuple):
    """Part of a picture, whole pixels."""

    left: int
    top: int
    right: int
    bottom: int

    def of(self, picture: Floats) -> Floats:
        """Returns the view of this part of a picture."""
        return picture[self.top : self.bottom, self.left : self.right]


class Schematic:
    """Picture of a road and its traffic: the road from above, and beside it, or below in tall pictures and of long roads, the diagram.

    The diagram's memory depends on the size of the picture only: lines are kept as pixels, in columns that become longer with time.
    """

    def __init__(self, road: RoadShape, size: tuple[int, int], top_speed_mps: float) -> None:
        """``size``: width and height, pixels. ``top_speed_mps``: end of the scale of colours, above 0."""
        self._road, self._top_speed_mps = road, top_speed_mps
        width, height = size
        self._has_text = width >= _LEAST_SIZE[0] and height >= _LEAST_SIZE[1]
        #: Size of one of the font's pixels.
        self._dot_px = max(1.0, min(width, height) / 300.0)
        self._outline_px = 1.0 + 0.6 * self._dot_px
        #: Smallest drawn length and width of a vehicle: on large networks vehicles are drawn larger than they are, or none could be seen.
        self._least_px = (3.5 + 2.0 * self._dot_px, 2.0 + self._dot_px)
        road_box, plot = self._layout(width, height)
        self._fixed = np.tile(PAPER, (height, width, 1))
        self._scale_px = _draw_road(road_box.of(self._fixed), road, 0.5 * self._least_px[0] + 2.0 * self._outline_px)
        self._road_box, self._plot = road_box, plot
        if self._has_text:
            self._draw_speeds()
        if plot is not None:
            #: Columns of time, rows from the top, and the lines' cover, their weight, and red, green, blue and speed, m/s, times weight.
            self._history = np.zeros((2 * (plot.right - plot.left), plot.bottom - plot.top, 6), np.float32)
            #: Length of the time axis for which the lines of each column were drawn, s.
            self._drawn_for_s = np.full(len(self._history), _FIRST_SPAN_S)
        self.clear()

    def clear(self) -> None:
        """Forgets all vehicles, because a new episode begins."""
        self._traffic: Scene | None = None
        self._set_span(0.0, _FIRST_SPAN_S)
        if self._plot is not None:
            self._history[:] = 0.0
            self._column_s = _FIRST_SPAN_S / len(self._history)

    def note(self, traffic: Scene) -> None:
        """Takes the vehicles of the present moment, for the next picture and for the diagram; an earlier time begins a new episode."""
        if self._traffic is not None and traffic.time_s < self._traffic.time_s:
            self.clear()
        before = self._traffic
        self._traffic = copy.deepcopy(traffic)
        if self._plot is None:
            return
        if before is None:
            self._set_span(traffic.time_s, _FIRST_SPAN_S)
        elif traffic.time_s > before.time_s:
            self._make_room(traffic.time_s - self._begin_s)
            self._trace(self._traffic, max(before.time_s, traffic.time_s - _BRIDGED_S))

    def draw(self) -> NDArray[np.uint8]:
        """Returns the picture of the last moment noted, uint8, ``(height, width, 3)``."""
        if self._plot is not None and self._traffic is not None:
            self._draw_diagram(self._plot, self._traffic.time_s - self._begin_s)
        picture = self._background.copy()
        if self._traffic is not None:
            self._draw_vehicles(self._road_box.of(picture), self._traffic)
            if self._has_text:
                self._draw_heading(picture, self._traffic)
        return np.rint(picture, out=picture).astype(np.uint8)

    # Layout and the parts that stay

    def _layout(self, width: int, height: int) -> tuple[_Box, _Box | None]:
        """Returns the boxes of the road and of the diagram's plot, if it has room."""
        margin = min(round(4 * self._dot_px), min(width, height) // 4)
        if not self._has_text:
            return _Box(margin, margin, width - margin, height - margin), None
        row = round(13 * self._dot_px)
        if self._road.length_m <= 0.0:
            return _Box(margin, row, width - margin, height - row), None
        left = round(6 * self._dot_px * len(f"{self._road.length_m:.0f}")) + 2 * margin
        right, foot = round(17 * self._dot_px), 2 * row
        _, (east_m, north_m) = _extent(self._road)
        if width > height and east_m < 2.0 * north_m:
            middle = min(round(0.46 * width), round(1.4 * height))
            return _Box(margin, row, middle - margin, height - foot), _Box(middle + left, row, width - right, height - foot)
        middle = min(height // 2, round(width * north_m / east_m) + 3 * row)
        return _Box(margin, row, width - margin, middle - row), _Box(left, middle + row, width - right, height - foot)

    def _draw_speeds(self) -> None:
        """Draws the colour bar below the road, and beside it the mark of advised vehicles if there is room."""
        box, dot = self._road_box, self._dot_px
        y = box.bottom + round(7 * dot)
        texts = ("0 m/s", f"{self._top_speed_mps:.3g} m/s", "advised")
        widths = [text_width(text, dot) for text in texts]
        bar, gap = round(60 * dot), round(5 * dot)
        free = box.right - box.left - 2 * gap - widths[0] - widths[1]
        has_mark = free >= bar + 7 * gap + widths[2]
        bar = min(bar, free)
        x = (box.left + box.right - bar - 2 * gap - widths[0] - widths[1] - (7 * gap + widths[2] if has_mark else 0)) // 2
        write(self._fixed, texts[0], x, y, dot, 0.0)
        x += widths[0] + gap
        half = round(2.5 * dot)
        shades = speed_colours((np.arange(bar) + 0.5) / bar, 1.0)
        self._fixed[y - half : y + half + 1, x : x + bar] = shades
        write(self._fixed, texts[1], x + bar + gap, y, dot, 0.0)
        if has_mark:
            x += bar + 2 * gap + widths[1] + 3 * gap
            middle = np.array([[x + 0.5, y + 0.5, 0.0, 9 * dot, 4 * dot]])
            draw_vehicles(self._fixed, middle, speed_colours(np.array([0.5]), 1.0), self._outline_px)
            write(self._fixed, texts[2], x + round(2.4 * gap), y, dot, 0.0)

    def _set_span(self, begin_s: float, span_s: float) -> None:
        """Draws the diagram's axes for this time, and keeps them with the fixed parts as background."""
        self._begin_s, self._span_s = begin_s, span_s
        self._background = self._fixed.copy()
        if self._plot is None:
            return
        picture, box, dot, length_m = self._background, self._plot, self._dot_px, self._road.length_m
        wide, high = box.right - box.left, box.bottom - box.top
        line = max(1, round(0.6 * dot))
        for mark in _marks(0.0, length_m, int(high / (26 * dot))):
            y = min(int(box.bottom - mark / length_m * high), box.bottom - 1)
            picture[y : y + line, box.left : box.right] = _GRID
            write(picture, f"{mark:.0f}", box.left - round(4 * dot), y, dot, 1.0)
        longest = len(f"{begin_s + span_s:.0f}")
        for mark in _marks(begin_s, begin_s + span_s, int(wide / (6 * dot * (longest + 2)))):
            x = min(int(box.left + (mark - begin_s) / span_s * wide), box.right - 1)
            picture[box.top : box.bottom, x : x + line] = _GRID
            write(picture, f"{mark:.0f}", x, box.bottom + round(9 * dot), dot, 0.5)
        picture[box.top : box.bottom + line, box.left - line : box.left] = INK
        picture[box.bottom : box.bottom + line, box.left : box.right] = INK
        write(picture, "time, s", (box.left + box.right) // 2, box.bottom + round(20 * dot), dot, 0.5)
        write(picture, "position, m", box.left, box.top - round(7 * dot), dot, 0.0)
        #: Plot without lines, and the number of its columns whose lines are in the background.
        self._axes, self._drawn = box.of(picture).copy(), 0

    # Vehicles

    def _draw_vehicles(self, part: Floats, traffic: Scene) -> None:
        """Draws the vehicles into the road's part of a picture, advised ones last."""
        height, width = part.shape[:2]
        west, north, scale = self._scale_px
        x, y = (traffic.x_m - west) * scale, (north - traffic.y_m) * scale
        long, broad = (np.maximum(side * scale, least) for side, least in zip((traffic.length_m, traffic.width_m), self._least_px))
        shown = np.flatnonzero((x >= 0.0) & (x <= width) & (y >= 0.0) & (y <= height))
        places = np.stack([x, y, traffic.yaw_rad, long, broad], axis=1)
        colours = speed_colours(traffic.speed_mps, self._top_speed_mps)
        for is_advised, outline_px in ((False, 0.0), (True, self._outline_px)):
            chosen = shown[traffic.is_advised[shown] == is_advised]
            draw_vehicles(part, places[chosen], colours[chosen], outline_px)

    def _draw_heading(self, picture: Floats, traffic: Scene) -> None:
        """Writes the time, and the mean speed and the number of vehicles if there is room."""
        box, count = self._road_box, len(traffic.speed_mps)
        texts = [f"{traffic.time_s:.1f} s"]
        if count:
            texts += [f"{texts[0]},  mean {traffic.speed_mps.mean():.1f} m/s"]
            texts += [f"{texts[1]},  {count} vehicle{'s' if count > 1 else ''}"]
        fitting = [text for text in texts if text_width(text, self._dot_px) <= box.right - box.left]
        write(picture, fitting[-1], (box.left + box.right) // 2, box.top - round(7 * self._dot_px), self._dot_px, 0.5)

    # Space-time diagram

    def _make_room(self, elapsed_s: float) -> None:
        """Makes the columns of the history longer, and the time axis, until they hold this time."""
        history = self._history
        while elapsed_s > len(history) * self._column_s:
            half = len(history) // 2
            history[:half] = 0.5 * (history[0::2] + history[1::2])
            history[half:] = 0.0
            self._drawn_for_s[:half] = self._drawn_for_s.reshape(half, 2).mean(axis=1)
            self._column_s *= 2.0
            self._drawn = 0
        if elapsed_s > self._span_s:
            power = 10.0 ** np.floor(np.log10(elapsed_s))
            spans = [nice * power for nice in (*_NICE, 10.0)]
            self._set_span(self._begin_s, next(span for span in spans if span >= elapsed_s))

    def _trace(self, traffic: Scene, since_s: float) -> None:
        """Adds the lines of all vehicles on the route from this moment to that of ``traffic`` to the history."""
        columns, height = self._history.shape[:2]
        length_m, per_m = self._road.length_m, height / self._road.length_m
        first, last = (since_s - self._begin_s) / self._column_s, (traffic.time_s - self._begin_s) / self._column_s
        number = np.arange(int(first), min(int(np.ceil(last)), columns))
        begin, end = np.maximum(number, first), np.minimum(number + 1, last)
        back_s = (last - 0.5 * (begin + end)) * self._column_s
        on = np.flatnonzero(np.isfinite(traffic.s_m))
        speed, is_advised = traffic.speed_mps[on], traffic.is_advised[on]
        s_m = traffic.s_m[on][:, None] - speed[:, None] * back_s
        if self._road.is_closed:
            s_m %= length_m
        y = (height - s_m * per_m)[..., None]
        block = self._history[number[0] : number[0] + len(number)]
        self._drawn_for_s[number] = self._span_s
        colours = speed_colours(speed, self._top_speed_mps)
        colours[is_advised] = _DARKENED * OUTLINE + (1.0 - _DARKENED) * colours[is_advised]
        thick_px = 0.6 + 0.45 * self._dot_px + np.where(is_advised, 1.8 * self._dot_px, 0.0)[:, None, None]
        # A steep line needs marks that are higher, to look equally thick.
        stretch = self._stretch(speed[:, None, None], self._span_s)
        reach = 0.5 * (thick_px + 1.0) * stretch
        rows = np.floor(y - reach) + np.arange(int(2.0 * reach.max(initial=0.0)) + 2)
        cover = np.clip(0.5 * (thick_px + 1.0) - np.abs(rows + 0.5 - y) / stretch, 0.0, 1.0) * (end - begin)[:, None]
        inside = (rows >= 0) & (rows < height) & (cover > 0.0)
        cell = (np.arange(len(number))[:, None] * height + rows)[inside].astype(np.intp)
        vehicle = np.broadcast_to(np.arange(len(on))[:, None, None], rows.shape)[inside]
        weight = cover[inside] * np.where(is_advised[vehicle], _ABOVE, 1.0)
        for channel, values in enumerate((cover[inside], weight, *(weight * colours[vehicle].T), weight * speed[vehicle])):
            block[..., channel] += np.bincount(cell, values, len(number) * height).reshape(-1, height)

    def _stretch(self, speed_mps: NDArray[Any], span_s: float | NDArray[np.float64]) -> NDArray[Any]:
        """Returns the height of lines of these speeds over their thickness, on a time axis of this length."""
        high, wide = self._history.shape[1], 0.5 * len(self._history)
        return np.minimum(np.hypot(1.0, speed_mps * (high / self._road.length_m / wide) * span_s), _STEEPEST)

    def _draw_diagram(self, plot: _Box, elapsed_s: float) -> None:
        """Draws the columns of the history that are new since the last picture into the background."""
        columns, wide = len(self._history), plot.right - plot.left
        first = np.minimum(np.floor(np.arange(wide + 1) * (self._span_s / self._column_s / wide) + 1e-6).astype(np.intp), columns)
        begun = int(np.count_nonzero((first[:-1] <= elapsed_s / self._column_s) & (first[:-1] < columns)))
        edges = first[self._drawn : begun + 1]
        if len(edges) < 2:
            return
        sums = np.add.reduceat(self._history[: edges[-1]], edges[:-1], axis=0).transpose(1, 0, 2)
        colours = (sums[..., 2:] / np.maximum(sums[..., 1:2], 1e-6)).astype(np.float32)
        # Lines of a shorter time axis were compressed, and became as much thinner as they became steeper.
        gain = self._stretch(colours[..., 3], self._span_s) / self._stretch(colours[..., 3], self._drawn_for_s[edges[:-1]])
        part = self._axes[:, self._drawn : begun].copy()
        blend(part, np.minimum(sums[..., 0] / np.diff(edges) * gain, 1.0), colours[..., :3])
        plot.of(self._background)[:, self._drawn : begun] = part
        # More may come into the last column.
        self._drawn = begun - 1


def _extent(road: RoadShape) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Returns the middle of the lanes and their extents to the east and to the north, with the half width of lanes around them, m."""
    points = np.concatenate([np.reshape(lane, (-1, 2)) for lane in road.lanes] or [np.zeros((1, 2))])
    low, high = points.min(axis=0), points.max(axis=0)
    return 0.5 * (low + high), high - low + max(road.widths_m, default=1.0)


def _draw_road(part: Floats, road: RoadShape, margin_px: float) -> tuple[float, float, float]:
    """Draws the lanes as large as they fit. Returns x of the left side and y of the upper side, m, and the scale, pixels/m."""
    height, width = part.shape[:2]
    middle, extent = _extent(road)
    # Small pictures, which lack room for the margin, have a smaller one.
    room = [max(side - 2.0 * margin_px, 0.5 * side) for side in (width, height)]
    scale = min(room[0] / extent[0], room[1] / extent[1])
    west, north = middle[0] - 0.5 * width / scale, middle[1] + 0.5 * height / scale
    # Distance to the nearest border of a lane, negative on the lanes. Borders inside a junction's area are covered by other lanes.
    border = np.full((height, width), np.inf, np.float32)
    lines = [_thinned((lane - (west, north)) * (scale, -scale), road.is_closed) for lane in road.lanes]
    if lines:
        half_px = np.maximum(0.5 * scale * np.array(road.widths_m), 0.5 * _LEAST_LANE_PX)
        begin, end = np.concatenate([line[:-1] for line in lines]), np.concatenate([line[1:] for line in lines])
        measure(border, begin, end, np.repeat(half_px, [len(line) - 1 for line in lines]))
    blend(part, np.clip(0.5 - border, 0.0, 1.0), _ASPHALT)
    # Edges fade where lanes are so narrow that their edges would hide them.
    narrow_px = min(road.widths_m, default=0.0) * scale
    line_px = np.clip(0.12 * narrow_px, 0.0, 2.5)
    blend(part, np.clip(0.5 * line_px + 0.5 - np.abs(border), 0.0, 1.0) * np.clip(narrow_px / 2.0 - 1.0, 0.0, 1.0), _EDGE)
    return west, north, scale


def _thinned(points: NDArray[np.float64], is_closed: bool) -> NDArray[np.float64]:
    """Returns a line without points that are less than a pixel apart; the line of a whole ring returns to its first point."""
    steps = np.hypot(*np.diff(points, axis=0).T)
    # A ring of several pieces has a wide gap in each of its lines.
    if is_closed and len(steps) and np.hypot(*(points[0] - points[-1])) <= 1.5 * steps.max():
        points, steps = np.concatenate([points, points[:1]]), np.append(steps, 0.0)
    kept = np.floor(np.cumsum(steps)).astype(np.intp)
    return points[np.concatenate([[True], np.diff(kept, prepend=0)[:-1] > 0, [True]])] if len(steps) > 1 else points


def _marks(low: float, high: float, most: int) -> NDArray[np.float64]:
    """Returns round numbers from ``low`` to ``high`` at equal distances, at most about this many."""
    steps = [digit * 10.0**power for power in range(9) for digit in (1.0, 2.0, 5.0)]
    step = next(step for step in steps if (high - low) / step <= max(most, 1))
    return np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step
