"""Storage for the results of runs: a folder, or any address that fsspec knows."""

from __future__ import annotations

import os
import pathlib
import uuid
from collections.abc import Callable, Iterable
from typing import Any

#: Folder of the parts, as in ``codrive sweep``.
PARTS = "parts"
#: Folder of the checkpoints, as in ``codrive sweep``.
CHECKPOINTS = "checkpoints"


class Store:
    """Storage for the results of runs: a folder, or an address of fsspec. Names are relative to it, with slashes."""

    #: File system of fsspec; None for a folder of this machine.
    _fs: Any = None

    def __init__(self, out: str) -> None:
        """
        Raises:
            ImportError: The address needs fsspec.
        """
        self.out, self._root = out, out
        if "://" in out:
            try:
                import fsspec
            except ImportError:
                raise ImportError(f"the address {out} needs fsspec: pip install './python[ray]'") from None
            fs, self._root = fsspec.core.url_to_fs(out)
            is_here = "file" in ((fs.protocol,) if isinstance(fs.protocol, str) else fs.protocol)
            self._fs = None if is_here else fs

    @property
    def folder(self) -> pathlib.Path | None:
        """Returns the folder, if it is on this machine."""
        return pathlib.Path(self._root).absolute() if self._fs is None else None

    def names(self) -> set[str]:
        """Returns the names of the existing parts."""
        parts = self._place(PARTS)
        if self._fs is None:
            os.makedirs(parts, exist_ok=True)
            return set(os.listdir(parts))
        self._fs.makedirs(parts, exist_ok=True)
        self._fs.invalidate_cache(parts)
        try:
            return {path.rsplit("/", 1)[-1] for path in self._fs.ls(parts, detail=False)}
        except FileNotFoundError:
            # Object stores have no folders, only names that contain slashes.
            return set()

    def put(self, name: str, part: bytes) -> None:
        """Writes a part completely or not at all, and removes the checkpoint of its run."""
        self.write(f"{PARTS}/{name}", part)
        self.remove(_checkpoint(name))

    def get(self, names: Iterable[str], folder: pathlib.Path) -> None:
        """Copies parts from the store's address into a folder of this machine."""
        for name in names:
            self._fs.get_file(self._place(f"{PARTS}/{name}"), str(folder / name))

    def upload(self, path: pathlib.Path, name: str) -> None:
        """Copies a file of this machine to the store's address."""
        self._fs.makedirs(self._place(name).rpartition("/")[0], exist_ok=True)
        self._fs.put_file(str(path), self._place(name))

    def write(self, name: str, content: bytes) -> None:
        """Writes a file completely or not at all.

        Raises:
            RuntimeError: The file cannot be written.
        """
        path = self._place(name)
        if self._fs is not None:
            # Object stores show an object only when it is complete.
            self._fs.pipe_file(path, content)
            return
        # Machines that share the folder may have processes with the same id.
        beside = pathlib.Path(path).parent / f".{pathlib.Path(path).name}.{uuid.uuid4().hex}"
        try:
            beside.parent.mkdir(parents=True, exist_ok=True)
            beside.write_bytes(content)
            os.replace(beside, path)
        except OSError as why:
            beside.unlink(missing_ok=True)
            raise RuntimeError(f"{path}: {why.strerror}") from why

    def read(self, name: str) -> bytes | None:
        """Returns the content of a file; None if there is no such file."""
        try:
            return pathlib.Path(self._place(name)).read_bytes() if self._fs is None else self._fs.cat_file(self._place(name))
        except FileNotFoundError:
            return None

    def remove(self, name: str) -> None:
        """Removes a file, if there is one."""
        try:
            if self._fs is None:
                os.remove(self._place(name))
            else:
                self._fs.rm_file(self._place(name))
        except FileNotFoundError:
            pass

    def _place(self, name: str) -> str:
        return f"{self._root.rstrip('/')}/{name}"


class Checkpoint:
    """Checkpoint of the run with a part in a store. ``report`` takes what is worth telling about it."""

    def __init__(self, store: Store, name: str, report: Callable[[str], None]) -> None:
        self._store, self._name, self.report = store, _checkpoint(name), report

    def load(self) -> bytes | None:
        """Returns the checkpoint; None if there is none."""
        return self._store.read(self._name)

    def save(self, state: bytes) -> None:
        """Replaces the checkpoint as a whole."""
        self._store.write(self._name, state)


def _checkpoint(part: str) -> str:
    """Returns the name of the checkpoint of the run with this part."""
    return f"{CHECKPOINTS}/{part.rpartition('.')[0]}"
