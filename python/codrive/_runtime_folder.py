"""A folder for the sockets of this session, where the system gives none: libraries of graphics complain on each start without one."""

from __future__ import annotations

import atexit
import os
import shutil
import sys
import tempfile

#: As the freedesktop.org specification of base folders calls it; what it names has to be of mode 700.
_NAME = "XDG_RUNTIME_DIR"
#: The one that was made, and the process that removes it.
_made: tuple[str, int] | None = None


def runtime_variables() -> dict[str, str]:
    """Variables of the environment for a process that draws: none where the folder is set already, and none but on Linux."""
    global _made
    if os.environ.get(_NAME) or not sys.platform.startswith("linux"):
        return {}
    if _made is None or not os.path.isdir(_made[0]):
        # Of mode 700.
        _made = (tempfile.mkdtemp(prefix="codrive-runtime-"), os.getpid())
        atexit.register(_remove, *_made)
    return {_NAME: _made[0]}


def _remove(folder: str, owner: int) -> None:
    # A fork has the same folder, and is not the one to remove it.
    if os.getpid() == owner:
        shutil.rmtree(folder, ignore_errors=True)
