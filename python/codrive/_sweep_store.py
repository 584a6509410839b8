"""Storage for the parts of a sweep: a folder, or any address that fsspec knows."""

from __future__ import annotations

import os
import pathlib
import uuid
from collections.abc import Iterable

import fsspec

#: Folder of the parts, as in ``codrive sweep``.
PARTS = "parts"


class Store:
    """Storage for the parts: a folder, or an address of fsspec."""

    def __init__(self, out: str) -> None:
        self.out = out
        self._fs, self._root = fsspec.core.url_to_fs(out)
        self._parts = f"{self._root.rstrip('/')}/{PARTS}"

    def names(self) -> set[str]:
        """Returns the names of the existing parts."""
        self._fs.makedirs(self._parts, exist_ok=True)
        self._fs.invalidate_cache(self._parts)
        try:
            paths = self._fs.ls(self._parts, detail=False)
        except FileNotFoundError:
            # Object stores have no folders, only names that contain slashes.
            return set()
        return {path.rsplit("/", 1)[-1] for path in paths}

    def put(self, name: str, part: bytes) -> None:
        """Writes a part completely or not at all."""
        path = f"{self._parts}/{name}"
        if self.folder is None:
            # Object stores show an object only when it is complete.
            self._fs.pipe_file(path, part)
            return
        # Machines that share the folder may have processes with the same id.
        beside = f"{self._parts}/.{name}.{uuid.uuid4().hex}"
        try:
            pathlib.Path(beside).write_bytes(part)
            os.replace(beside, path)
        except OSError as why:
            pathlib.Path(beside).unlink(missing_ok=True)
            raise RuntimeError(f"{path}: {why.strerror}") from why

    def get(self, names: Iterable[str], folder: pathlib.Path) -> None:
        """Copies parts into a folder of this machine."""
        for name in names:
            self._fs.get_file(f"{self._parts}/{name}", str(folder / name))

    def upload(self, path: pathlib.Path) -> None:
        """Puts a table beside the parts."""
        self._fs.put_file(str(path), f"{self._root.rstrip('/')}/{path.name}")

    @property
    def folder(self) -> pathlib.Path | None:
        """Returns the folder, if it is on this machine."""
        protocol = self._fs.protocol
        is_here = "file" in ((protocol,) if isinstance(protocol, str) else protocol)
        return pathlib.Path(self._root) if is_here else None
