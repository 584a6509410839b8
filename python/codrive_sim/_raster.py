"""Shapes and texts with smooth edges, drawn into pictures with numpy alone.

A picture is ``(height, width, 3)``, float32, 0 to 255. Pixel (0, 0) is the square from (0, 0) to (1, 1), y downwards; distances in pixels
have the suffix ``_px``.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Places = NDArray[np.float64]

#: Longest piece of a band that is measured at once, pixels, and the number of pixels measured at once, which fit the processor's cache.
_PIECE_PX = 24.0
_AT_ONCE = 100_000

#: Colours, red, green and blue from 0 to 255.
PAPER = np.array((252, 252, 250), np.float32)
INK = np.array((62, 68, 78), np.float32)
OUTLINE = np.array((16, 22, 44), np.float32)
_WINDSCREEN = np.array((38, 44, 56), np.float32)

#: Colours of speeds at equal distances from standstill to the top speed. The lightness rises all the way, for readers who see few hues and
#: for prints in grey; all forms of colour blindness tell the ends, red and blue, apart.
_SPEEDS = np.array(
    ((104, 8, 26), (166, 30, 28), (210, 72, 30), (228, 112, 44), (222, 150, 66), (150, 190, 146), (76, 204, 222)), np.float32
)

#: Glyphs: a character and its nine rows of five pixels, each row a digit to the base 32. The last two rows lie below the base line.
_GLYPHS = {
    code[0]: code[1:]
    for code in (
        "0ehhhhhe00 14c4444e00 2eh1248v00 3eh161he00 426aiv2200 5vgu11he00 6egguhhe00 7v12444400 8ehhehhe00 9ehhf11e00 "
        "a00e1fhf00 c00ehghe00 d11fhhhf00 e00ehvge00 hgguhhhh00 ig0ggggg00 lggggggg00 m00ullll00 n00uhhhh00 o00ehhhe00 "
        "p00uhhhugg s00fge1u00 t88u888600 v00hhha400 /11248gg00 .000000g00 ,0000008g0 -000u00000"
    ).split()
}


def blend(part: Floats, cover: Floats, colour: Floats) -> None:
    """Lays a colour over a part of a picture, ``(height, width, 3)``, by its cover, ``(height, width)``, 0 to 1."""
    part += (colour - part) * cover[..., None]


def speed_colours(speed_mps: NDArray[np.float64], top_speed_mps: float) -> Floats:
    """Returns the colours of speeds, ``(n, 3)``, 0 to 255; speeds beyond the top speed have its colour."""
    place = np.clip(speed_mps / top_speed_mps, 0.0, 1.0) * (len(_SPEEDS) - 1)
    return np.stack([np.interp(place, np.arange(len(_SPEEDS)), _SPEEDS[:, part]) for part in range(3)], axis=-1).astype(np.float32)


def measure(border: Floats, begin: Places, end: Places, half_px: NDArray[np.float64]) -> None:
    """Lowers the distances to the nearest border, ``(height, width)``, pixels, to those of straight bands with round ends.

    ``begin``, ``end``: ends of the bands, ``(bands, 2)``; ``half_px``: half of their widths, ``(bands,)``. A distance inside is negative.
    """
    # Long bands are cut, so that the square around each piece is small.
    pieces = np.ceil(np.hypot(*(end - begin).T) / _PIECE_PX).astype(np.intp).clip(1)
    band = np.repeat(np.arange(len(pieces)), pieces)
    share = ((np.arange(len(band)) - np.repeat(np.cumsum(pieces) - pieces, pieces)) / pieces[band])[:, None]
    step = ((end - begin) / pieces[:, None])[band]
    start = begin[band] + share * (end - begin)[band]
    reach = half_px[band] + 2.0
    corner = np.floor(np.minimum(start, start + step) - reach[:, None])
    side = np.ceil((np.abs(step).max(axis=1) + 2.0 * reach + 1.0) / 8.0).astype(np.intp) * 8
    for size in np.unique(side):
        chosen = np.flatnonzero(side == size)
        for some in np.array_split(chosen, len(chosen) * size**2 // _AT_ONCE + 1):
            _measure_squares(border, corner[some], int(size), start[some], step[some], half_px[band[some]])


def _measure_squares(border: Floats, corner: Places, size: int, start: Places, step: Places, half_px: NDArray[np.float64]) -> None:
    """Lowers the distances in squares, each around one piece of a band."""
    column, row = (corner[:, axis, None] + np.arange(size) for axis in (0, 1))
    x, y = (column + 0.5 - start[:, :1])[:, None, :], (row + 0.5 - start[:, 1:])[:, :, None]
    dx, dy = step[:, 0, None, None], step[:, 1, None, None]
    along = np.clip((x * dx + y * dy) / np.maximum(dx * dx + dy * dy, 1e-9), 0.0, 1.0)
    distance = np.hypot(x - along * dx, y - along * dy) - half_px[:, None, None]
    height, width = border.shape
    inside = ((column >= 0) & (column < width))[:, None, :] & ((row >= 0) & (row < height))[:, :, None]
    cell = (row[:, :, None] * width + column[:, None, :])[inside].astype(np.intp)
    np.minimum.at(border.reshape(-1), cell, distance[inside].astype(np.float32))


def draw_vehicles(part: Floats, places: NDArray[np.float64], colours: Floats, outline_px: float) -> None:
    """Draws vehicles as seen from above, in their order. ``places``: x, y, heading in rad counter-clockwise, length and width in pixels,
    ``(vehicles, 5)``. ``colours``: ``(vehicles, 3)``. ``outline_px``: thickness of the dark outline; 0 for none."""
    if not len(places):
        return
    x, y, heading, long, broad = (column[:, None, None] for column in places.astype(np.float32).T)
    reach = int(np.ceil(0.5 * np.hypot(long, broad).max() + 1.7 * outline_px)) + 1
    corner = np.floor(places[:, :2]).astype(np.intp) - reach
    offset = np.arange(2 * reach + 1, dtype=np.float32) + 0.5
    right, down = corner[:, 0, None, None] + offset[None, None, :] - x, corner[:, 1, None, None] + offset[None, :, None] - y
    forward, aside = right * np.cos(heading) - down * np.sin(heading), right * np.sin(heading) + down * np.cos(heading)
    # Signed distance to a rectangle with round corners.
    round_px = 0.28 * broad
    beyond_x, beyond_y = np.abs(forward) - (0.5 * long - round_px), np.abs(aside) - (0.5 * broad - round_px)
    distance = np.hypot(np.maximum(beyond_x, 0.0), np.maximum(beyond_y, 0.0)) + np.minimum(np.maximum(beyond_x, beyond_y), 0.0) - round_px
    # From below: a dark outline, a light gap, the vehicle, and its windscreen if it can be seen.
    windscreen = np.maximum(np.abs(forward - 0.2 * long) - 0.07 * long, np.abs(aside) - 0.36 * broad)
    layers = [(distance - max(0.5, 0.7 * outline_px), PAPER), (distance, colours[:, None, None, :])]
    if outline_px > 0.0:
        layers.insert(0, (distance - 1.7 * outline_px, OUTLINE))
    if broad.max() > 5.0:
        layers.append((windscreen, _WINDSCREEN))
    cover, colour = np.zeros_like(distance), np.zeros((*distance.shape, 3), np.float32)
    for edge, paint in layers:
        over = np.clip(0.5 - edge, 0.0, 1.0)
        colour += (paint - colour) * over[..., None]
        cover += (1.0 - cover) * over
    below = (1.0 - cover)[..., None]
    height, width = part.shape[:2]
    size = 2 * reach + 1
    for number, (left, top) in enumerate(corner.tolist()):
        rows, columns = slice(max(-top, 0), min(height - top, size)), slice(max(-left, 0), min(width - left, size))
        window = part[top + rows.start : top + rows.stop, left + columns.start : left + columns.stop]
        window *= below[number, rows, columns]
        window += colour[number, rows, columns]


@lru_cache(maxsize=256)
def _glyph(character: str, dot_px: float) -> Floats:
    """Returns the cover of a character, 0 to 1: round strokes through the pixels of its glyph, so that it looks good at each size."""
    rows = [int(digit, 32) for digit in _GLYPHS.get(character, "000000000")]
    lit = {(x, y) for y, row in enumerate(rows) for x in range(5) if row >> (4 - x) & 1}
    columns = max((x for x, _ in lit), default=2) + 1
    strokes = [(x, y, x, y) for x, y in lit]
    for x, y in lit:
        for dx, dy in ((1, 0), (0, 1), (1, 1), (-1, 1)):
            # Pixels that touch at a corner are one stroke unless other pixels join them.
            is_joined = dx and dy and ((x + dx, y) in lit or (x, y + dy) in lit)
            if (x + dx, y + dy) in lit and not is_joined:
                strokes.append((x, y, x + dx, y + dy))
    border = np.full((int(np.ceil(9 * dot_px)), int(np.ceil(columns * dot_px))), np.inf, np.float32)
    ends = (np.reshape(strokes, (-1, 4)) + 0.5) * dot_px
    measure(border, ends[:, :2], ends[:, 2:], np.full(len(ends), 0.46 * dot_px))
    cover: Floats = np.clip(0.5 - border, 0.0, 1.0)
    return cover


def text_width(text: str, dot_px: float) -> int:
    """Returns the width of a text, pixels."""
    widths: list[int] = [_glyph(character, dot_px).shape[1] for character in text]
    return sum(widths) + round(dot_px) * (len(text) - 1)


def write(picture: Floats, text: str, x: int, middle: int, dot_px: float, align: float) -> None:
    """Writes a text. ``align``: share of its width left of ``x``. ``middle``: the row through the middle of its digits."""
    left, top = x - round(align * text_width(text, dot_px)), middle - int(3.5 * dot_px)
    for character in text:
        glyph = _glyph(character, dot_px)
        part = picture[top : top + glyph.shape[0], left : left + glyph.shape[1]]
        blend(part, glyph[: part.shape[0], : part.shape[1]], INK)
        left += glyph.shape[1] + round(dot_px)
