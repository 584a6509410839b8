"""Tests of the schematic picture of traffic, by colours at places that are worked out by hand, and of the windows that show it."""

import io
import pickle
import sys
import types

import numpy as np
import pytest
from gymnasium.error import DependencyNotInstalled

from codrive_sim import _schematic
from codrive_sim._schematic import RoadShape, Schematic, Scene
from codrive_sim._show import Window, png

#: Colours of standstill, of half of the top speed, and of the top speed.
STANDSTILL, HALF, TOP = (104, 8, 26), (228, 112, 44), (76, 204, 222)
PAPER, ASPHALT, OUTLINE, AXIS = (252, 252, 250), (176, 181, 188), (16, 22, 44), (62, 68, 78)
#: Lane of 100 m to the east, 4 m wide.
LANE = RoadShape([np.array([[0.0, 0.0], [100.0, 0.0]])], [4.0], False, 0.0)
#: Picture without texts. Of its 200 pixels, 4 are margin on both sides, and so are 5.95 in the road's part: half of the smallest vehicle's
#: length, 2.75, and two outlines of 1.6. The lane's 104 m, with its round ends, fill the remaining 180.1 pixels.
SMALL, SCALE = (200, 100), 180.1 / 104.0


def ring(parts=72):
    angle = np.arange(parts) * 2.0 * np.pi / parts
    return RoadShape([40.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)], [4.0], True, 250.0)


def traffic(time_s=0.0, **given):
    """Returns cars of 5 m by 2 m at rest in the middle of the lane, unless other arrays are given."""
    count = max([len(values) for values in given.values()], default=1)
    usual = dict(x_m=50.0, y_m=0.0, yaw_rad=0.0, length_m=5.0, width_m=2.0, speed_mps=0.0, s_m=np.nan, is_advised=False)
    return Scene(time_s, **{name: np.asarray(given.get(name, [value] * count)) for name, value in usual.items()})


def drawn(road=LANE, size=SMALL, moments=(), top_speed_mps=20.0):
    schematic = Schematic(road, size, top_speed_mps)
    for moment in moments:
        schematic.note(moment)
    return schematic.draw()


def plot_of(picture):
    """Returns left, top, right and bottom of the diagram's plot: the pixels beside its axes."""
    is_axis = (picture == AXIS).all(axis=2)
    left = int(np.argmax(is_axis.sum(axis=0))) + 1
    bottom = int(np.argmax(is_axis.sum(axis=1)))
    return left, int(np.flatnonzero(is_axis[:, left - 1])[0]), int(np.flatnonzero(is_axis[bottom])[-1]) + 1, bottom


def test_an_empty_road_is_asphalt_on_paper():
    picture = drawn()
    assert picture.shape == (100, 200, 3) and picture.dtype == np.uint8
    # The lane is 6.9 pixels wide around the middle row.
    assert tuple(picture[48, 30]) == ASPHALT and (picture[50, 12:188] == ASPHALT).all()
    assert tuple(picture[50, 2]) == tuple(picture[30, 100]) == PAPER


@pytest.mark.parametrize("speed_mps, colour", [(0.0, STANDSTILL), (10.0, HALF), (20.0, TOP), (55.0, TOP), (-1.0, STANDSTILL)])
def test_a_car_has_the_colour_of_its_speed(speed_mps, colour):
    assert tuple(drawn(moments=[traffic(speed_mps=[speed_mps])])[50, 100]) == colour


def test_cars_are_at_their_places():
    picture = drawn(moments=[traffic(x_m=[20.0, 90.0], speed_mps=[0.0, 20.0])])
    assert tuple(picture[50, int(100 - 30 * SCALE)]) == STANDSTILL
    assert tuple(picture[50, int(100 + 40 * SCALE)]) == TOP
    assert tuple(picture[50, 100]) == ASPHALT


def test_north_is_up():
    road = RoadShape([np.array([[0.0, -20.0], [0.0, 20.0]])], [4.0], False, 0.0)
    # The height is 100 - 2 * (4 + 5.95) pixels for 44 m.
    picture = drawn(road, moments=[traffic(x_m=[0.0], y_m=[10.0])])
    assert tuple(picture[int(50 - 10 * 80.1 / 44), 100]) == STANDSTILL


def test_headings_turn_counter_clockwise():
    picture = drawn(moments=[traffic(yaw_rad=[np.pi / 4])])
    # The car is 8.7 pixels long and 3.5 wide: this far from its middle it is there along its axis only.
    assert tuple(picture[47, 102]) == tuple(picture[52, 97]) == STANDSTILL
    assert tuple(picture[52, 102]) != STANDSTILL and tuple(picture[47, 97]) != STANDSTILL
    # This is 6.4 pixels along the axis, 2 in front of the car.
    assert tuple(picture[45, 104]) != STANDSTILL


def test_the_windscreen_is_in_the_front_half():
    road = LANE._replace(lanes=[LANE.lanes[0] / 5.0])
    # 24 m fill 180.1 pixels: the car is 37.5 pixels long, and its windscreen a fifth of this in front of its middle.
    picture = drawn(road, moments=[traffic(x_m=[10.0])])
    assert picture[50, 107].max() < 60 and tuple(picture[50, 92]) == STANDSTILL


def test_an_advised_vehicle_has_an_outline():
    # The car's side is 1.7 pixels from its middle, then come 1.1 of gap and the outline to 2.7 pixels.
    advised, other = (drawn(moments=[traffic(is_advised=[flag])]) for flag in (True, False))
    assert tuple(advised[53, 100]) == tuple(advised[46, 100]) == OUTLINE
    assert tuple(advised[50, 100]) == STANDSTILL
    assert not (other == OUTLINE).all(axis=2).any()


def test_an_advised_vehicle_is_drawn_above_its_neighbours():
    picture = drawn(moments=[traffic(speed_mps=[0.0, 20.0], is_advised=[True, False])])
    assert tuple(picture[50, 100]) == STANDSTILL


def test_vehicles_on_large_networks_are_drawn_larger():
    road = RoadShape([np.array([[0.0, 0.0], [10000.0, 0.0]])], [4.0], False, 0.0)
    # A car would be 0.09 pixels long; the smallest length is 5.5 pixels.
    picture = drawn(road, moments=[traffic(x_m=[5000.0])])
    assert (picture[50] == STANDSTILL).all(axis=1).sum() in (4, 5, 6)


def test_vehicles_outside_the_picture_are_left_out():
    given = traffic(x_m=[-500.0, 50.0, np.nan, 1e9], y_m=[0.0, 900.0, 0.0, 0.0], is_advised=[True, False, False, True])
    assert np.array_equal(drawn(moments=[given]), drawn())


def test_a_ring_is_closed_and_its_pieces_are_not():
    whole = drawn(ring(), (100, 100))
    # The gap between the last point and the first is 5 degrees, in the east.
    assert (whole[44:56, 80:] == ASPHALT).all(axis=2).any(axis=1).all()
    quarter = RoadShape([ring().lanes[0][:19]], [4.0], True, 0.0)
    assert tuple(drawn(quarter, (100, 100))[50, 50]) == PAPER


def test_lanes_side_by_side_have_a_lighter_line_between():
    road = RoadShape([np.array([[0.0, y], [20.0, y]]) for y in (-2.0, 2.0)], [4.0, 4.0], False, 0.0)
    picture = drawn(road)
    assert picture[50, 100].min() > 200
    assert tuple(picture[55, 100]) == tuple(picture[45, 100]) == ASPHALT


def test_the_lightness_of_colours_rises_with_speed():
    share = _schematic.speed_colours(np.linspace(0.0, 1.0, 101), 1.0) / 255.0
    # Relative luminance of sRGB, IEC 61966-2-1.
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    assert (np.diff(linear @ [0.2126, 0.7152, 0.0722]) > 0.0).all()


def test_the_diagram_has_a_vehicles_line_at_its_place():
    # An advised vehicle stands at 125 m of 250 m; another drives at the top speed, from 0 to 200 m in 10 s.
    moments = [
        traffic(float(time), speed_mps=[0.0, 20.0], s_m=[125.0, 20.0 * time], is_advised=[True, False], x_m=[900.0, 900.0])
        for time in range(11)
    ]
    picture = drawn(ring(), (640, 360), moments)
    left, top, right, bottom = plot_of(picture)
    middle = (top + bottom) // 2
    # The axis is 60 s long. A line of an advised vehicle is seven tenths outline and three tenths its speed's colour.
    assert tuple(picture[middle, left + (right - left) * 3 // 60]) == (42, 18, 39)
    assert (picture[middle, left + (right - left) * 11 // 60 : right] > 200).all()
    # At 5 s the other is at 100 m, and there is the only blue of the column.
    column = picture[top:bottom, left + (right - left) * 5 // 60].astype(int)
    blue = np.flatnonzero(column[:, 2] - column[:, 0] > 50)
    assert abs(blue.mean() - 0.6 * (bottom - top)) < 4.0 and len(blue) < 12


@pytest.mark.parametrize("is_closed", [True, False])
def test_lines_go_on_at_the_start_of_a_ring_only(is_closed):
    moments = [traffic(time, speed_mps=[10.0], s_m=[50.0 if time else 20.0]) for time in (0.0, 5.0)]
    picture = drawn(ring()._replace(is_closed=is_closed), (640, 360), moments)
    left, top, right, bottom = plot_of(picture)
    assert ((picture[top:bottom, left:right] < 150).any(axis=2)).sum() > 20
    moments = [traffic(time, speed_mps=[10.0], s_m=[10.0 if time else 210.0]) for time in (0.0, 5.0)]
    picture = drawn(ring()._replace(is_closed=is_closed), (640, 360), moments)
    # Between 0 and 4 s the vehicle was at 210 to 250 m, the upper sixth of the plot.
    upper = picture[top : top + (bottom - top) // 6, left + 1 : right]
    assert (upper < 150).any() == is_closed


def test_vehicles_beside_the_route_are_not_in_the_diagram():
    moments = [traffic(time, s_m=[np.nan]) for time in (0.0, 5.0)]
    picture = drawn(ring(), (640, 360), moments)
    left, top, right, bottom = plot_of(picture)
    assert (picture[top:bottom, left:right] > 200).all()


def test_pictures_do_not_depend_on_earlier_pictures():
    # At the end, 245 s, the columns of the history have become longer since the axis of 250 s was drawn, at 200 s.
    moments = [traffic(1.9 * k, speed_mps=[3.0 + k % 5, 0.0], s_m=[2.0 * k % 250, 100.0], is_advised=[False, True]) for k in range(130)]
    often, once = (Schematic(ring(), (320, 200), 20.0) for _ in range(2))
    for moment in moments:
        often.note(moment)
        once.note(moment)
        often.draw()
    assert np.array_equal(often.draw(), once.draw())


def test_a_new_episode_begins_with_an_empty_diagram():
    first, second = traffic(0.0, s_m=[9.0]), traffic(5.0, s_m=[9.0])
    cleared, returned = (Schematic(ring(), (320, 200), 20.0) for _ in range(2))
    for schematic in (cleared, returned):
        schematic.note(first)
        schematic.note(second)
    cleared.clear()
    assert np.array_equal(cleared.draw(), drawn(ring(), (320, 200)))
    cleared.note(first)
    assert np.array_equal(cleared.draw(), drawn(ring(), (320, 200), [first]))
    # An earlier time is a new episode, too.
    returned.note(first)
    assert np.array_equal(returned.draw(), drawn(ring(), (320, 200), [first]))


def test_memory_stays_the_same_over_10_000_notes():
    schematic = Schematic(ring(), (240, 160), 20.0)
    sizes = []
    for second in range(10_000):
        schematic.note(traffic(float(second), speed_mps=[0.0], s_m=[125.0], is_advised=[True], x_m=[900.0]))
        if second in (1000, 9999):
            sizes.append(len(pickle.dumps(schematic)))
    assert sizes[1] == sizes[0]
    # The standing vehicle's line, of the 10,000 s, is as before all over the axis.
    picture = schematic.draw()
    left, top, right, bottom = plot_of(picture)
    assert (picture[(top + bottom) // 2, left : right - 1] == (42, 18, 39)).all()


SIZES = [(240, 160), (320, 200), (640, 360), (360, 640), (1280, 720), (1920, 1080), (240, 1080), (1920, 160), (500, 500)]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("road", [ring(), LANE, LANE._replace(length_m=12345.0)])
def test_texts_are_apart_and_inside_the_picture(size, road, monkeypatch):
    boxes = {}

    def recorded(picture, text, x, middle, dot_px, align):
        width = _schematic.text_width(text, dot_px)
        left, top = x - round(align * width), middle - int(3.5 * dot_px)
        # A digit has seven rows of the font; "p" and "," two more.
        boxes[text, left] = (left, top, left + width, top + int((9 if set(text) & set("p,") else 7) * dot_px))
        write(picture, text, x, middle, dot_px, align)

    write = _schematic.write
    monkeypatch.setattr(_schematic, "write", recorded)
    schematic = Schematic(road, size, 33.3)
    fixed = {"0 m/s", "33.3 m/s", "advised"}
    boxes = {key: box for key, box in boxes.items() if key[0] in fixed}
    assert len(boxes) >= 2
    schematic.note(traffic(9990.0, x_m=[np.nan] * 1000))
    schematic.draw()
    placed = list(boxes.items())
    for (text, _), (left, top, right, bottom) in placed:
        assert left >= 0 and top >= 0 and right <= size[0] and bottom <= size[1], text
    for number, (key, a) in enumerate(placed):
        for other, b in placed[:number]:
            assert a[2] < b[0] or b[2] < a[0] or a[3] <= b[1] or b[3] <= a[1], (key, other)


@pytest.mark.parametrize("size", [(1, 1), (3, 200), (16, 9), (239, 160), (240, 159), (300, 300)])
def test_small_and_odd_sizes_are_drawn_too(size):
    moments = [traffic(float(k), s_m=[3.0 * k]) for k in range(3)]
    assert drawn(ring(), size, moments).shape == (size[1], size[0], 3)
    assert drawn(ring(), size, [traffic(x_m=[])]).shape == (size[1], size[0], 3)


def test_png_files_are_read_by_another_program():
    image = pytest.importorskip("PIL.Image")
    picture = np.random.default_rng(1).integers(0, 256, (5, 7, 3), np.uint8)
    assert np.array_equal(np.asarray(image.open(io.BytesIO(png(picture)))), picture)


def test_a_notebook_has_one_display_that_is_updated(monkeypatch):
    shown, updated = [], []

    def display(image, display_id):
        shown.append(image)
        return types.SimpleNamespace(update=updated.append)

    shell = types.SimpleNamespace(kernel=object())
    monkeypatch.setitem(sys.modules, "IPython", types.SimpleNamespace(get_ipython=lambda: shell))
    monkeypatch.setitem(sys.modules, "IPython.display", types.SimpleNamespace(display=display, Image=lambda data: data))
    window = Window("codrive")
    pictures = [np.full((2, 2, 3), grey, np.uint8) for grey in (0, 1, 2, 3)]
    for picture in pictures[:3]:
        window.show(picture)
    window.close()
    window.show(pictures[3])
    assert shown == [png(pictures[0])] and updated == [png(picture) for picture in pictures[1:3]]


class FakeTk:
    """Stands for tkinter: a window that fails once it is destroyed, as Tk does."""

    def __init__(self):
        self.pictures, self.roots, self.is_gone = [], 0, False
        self.TclError = type("TclError", (Exception,), {})

    def Tk(self):
        self.roots += 1
        return self

    def Label(self, root, borderwidth):
        return types.SimpleNamespace(pack=lambda: None, configure=lambda image: self.pictures.append(image))

    def PhotoImage(self, master, data, format):
        assert master is self
        if self.is_gone:
            raise self.TclError("application has been destroyed")
        return data

    def protocol(self, name, called):
        self.closed_by_hand = called

    def destroy(self):
        if self.is_gone:
            raise self.TclError("application has been destroyed")
        self.is_gone = True

    def withdraw(self):
        pass

    title = deiconify = update = lambda self, *_: None


@pytest.mark.parametrize("is_shown_again", [True, False])
@pytest.mark.parametrize("how", ["by hand", "by another", "by close"])
def test_a_closed_window_stays_closed(how, is_shown_again, monkeypatch):
    tk = FakeTk()
    monkeypatch.delitem(sys.modules, "IPython", raising=False)
    monkeypatch.setitem(sys.modules, "tkinter", tk)
    window = Window("codrive")
    picture = np.arange(12, dtype=np.uint8).reshape(1, 4, 3)
    window.show(picture)
    {"by hand": tk.closed_by_hand, "by another": tk.destroy, "by close": window.close}[how]()
    if is_shown_again:
        window.show(picture)
    window.close()
    assert tk.pictures == [b"P6 4 1 255\n" + bytes(range(12))] and tk.roots == 1 and tk.is_gone


def test_neither_notebook_nor_display_is_refused_with_a_remedy(monkeypatch):
    monkeypatch.delitem(sys.modules, "IPython", raising=False)
    monkeypatch.delenv("DISPLAY", raising=False)
    with pytest.raises(DependencyNotInstalled, match=r"needs a notebook, or tkinter and a display: .*render_mode='rgb_array'") as caught:
        Window("codrive")
    assert isinstance(caught.value, TypeError)
    monkeypatch.setitem(sys.modules, "tkinter", None)
    with pytest.raises(DependencyNotInstalled, match=r"needs a notebook, or tkinter and a display: .*tkinter"):
        Window("codrive")
