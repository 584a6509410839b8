"""Folder for the sockets of this session, if the system provides none. Without it, graphics libraries print a warning at each start."""

from __future__ import annotations

import atexit
import os
import shutil
import sys
import tempfile

#: Variable of the freedesktop.org specification of base folders; the folder must have mode 700.
_NAME = "XDG_RUNTIME_DIR"
#: Folder that was made, and the process that removes it.
_made: tuple[str, int] | None = None


def runtime_variables() -> dict[str, str]:
    """Returns environment variables for a process that draws; none if the folder is already set or the system is not Linux."""
    global _made
    if os.environ.get(_NAME) or not sys.platform.startswith("linux"):
        return {}
    if _made is None or not os.path.isdir(_made[0]):
        # mkdtemp uses mode 700.
        _made = (tempfile.mkdtemp(prefix="codrive-runtime-"), os.getpid())
        atexit.register(_remove, *_made)
    return {_NAME: _made[0]}


def _remove(folder: str, owner: int) -> None:
    # A fork has the same folder but must not remove it.
    if os.getpid() == owner:
        shutil.rmtree(folder, ignore_errors=True)
