"""Pictures on the screen, for ``render_mode="human"``: in a notebook, or in a window of tkinter."""

from __future__ import annotations

import importlib
import importlib.util
import os
import struct
import sys
import zlib
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codrive_sim._spaces import RendererMissing


def png(picture: NDArray[np.uint8]) -> bytes:
    """Returns a picture, ``(height, width, 3)``, as a PNG file."""
    height, width = picture.shape[:2]
    # Each row begins with the number of its filter; 0 is none.
    rows = np.concatenate([np.zeros((height, 1), np.uint8), picture.reshape(height, 3 * width)], axis=1)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", header) + _chunk(b"IDAT", zlib.compress(rows.tobytes(), 9)) + _chunk(b"IEND", b"")


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def _is_notebook() -> bool:
    """Returns whether this process is a Jupyter kernel; IPython is loaded in each."""
    ipython = sys.modules.get("IPython")
    return ipython is not None and hasattr(ipython.get_ipython(), "kernel")


def can_show() -> bool:
    """Returns whether a window or a notebook is likely here; only an attempt can tell."""
    has_display = sys.platform in ("win32", "darwin") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    return _is_notebook() or (has_display and importlib.util.find_spec("tkinter") is not None)


class Window:
    """Successive pictures in one place: the output of a notebook's cell, or a window."""

    def __init__(self, title: str) -> None:
        """
        Raises:
            DependencyNotInstalled: There is neither a notebook nor tkinter with a display.
        """
        self._place: _Notebook | _Desktop = _Notebook() if _is_notebook() else _Desktop(title)

    def show(self, picture: NDArray[np.uint8]) -> None:
        """Shows a picture, uint8, ``(height, width, 3)``, in place of the last one; does nothing once the window is closed."""
        self._place.show(picture)

    def close(self) -> None:
        """Closes the window; the last picture stays in a notebook."""
        self._place.close()


class _Notebook:
    """Output of a notebook's cell."""

    def __init__(self) -> None:
        self._display: Any = importlib.import_module("IPython.display")
        self._handle: Any = None

    def show(self, picture: NDArray[np.uint8]) -> None:
        if self._display is None:
            return
        image = self._display.Image(data=png(picture))
        if self._handle is None:
            self._handle = self._display.display(image, display_id=True)
        else:
            self._handle.update(image)

    def close(self) -> None:
        self._display = None


class _Desktop:
    """Window of tkinter, hidden until it has a picture."""

    def __init__(self, title: str) -> None:
        try:
            self._tkinter: Any = importlib.import_module("tkinter")
        except ImportError as fault:
            raise _no_window(fault) from None
        try:
            self._root: Any = self._tkinter.Tk()
        except self._tkinter.TclError as fault:
            raise _no_window(fault) from None
        self._root.withdraw()
        self._root.title(title)
        self._root.protocol("WM_DELETE_WINDOW", self.close)
        self._label: Any = self._tkinter.Label(self._root, borderwidth=0)
        self._label.pack()

    def show(self, picture: NDArray[np.uint8]) -> None:
        if self._root is None:
            return
        height, width = picture.shape[:2]
        try:
            image = self._tkinter.PhotoImage(master=self._root, data=b"P6 %d %d 255\n" % (width, height) + picture.tobytes(), format="PPM")
            self._label.configure(image=image)
            # Tk shows a picture only while Python keeps it.
            self._label.image = image
            self._root.deiconify()
            self._root.update()
        except self._tkinter.TclError:
            # The window was closed while it was updated, or its display is gone.
            self._root = None

    def close(self) -> None:
        root, self._root = self._root, None
        if root is not None:
            with suppress(self._tkinter.TclError):
                root.destroy()


def _no_window(fault: Exception) -> RendererMissing:
    return RendererMissing(
        f"render_mode='human' needs a notebook, or tkinter and a display: {fault}; "
        "remedy: render_mode='rgb_array', whose render() returns each picture as an array"
    )
