"""``read``: recordings and data sets of studies, as tables and pictures."""

from __future__ import annotations

import functools
import html
import io
import json
import os
import pathlib
from collections.abc import Iterator
from typing import Any

from codrive_sim._codrive import find_drives, measures, recorded_settings, space_time
from codrive_sim._frames import Frames, library


def read(folder: str | os.PathLike[str]) -> Any:
    """Opens a recording of one drive (``codrive run --out DIR``), the data set of a study, or one participant of it.

    Args:
        folder: Folder of a recording (with ``manifest.json``), of a data set (with ``dataset_description.json``), or a ``sub-*`` in one.

    Returns:
        A ``Recording`` or a ``DataSet``, as the folder says; for type checkers: ``drive: codrive_sim.Recording = codrive_sim.read("out")``.
        Tables are read on access.

    Raises:
        FileNotFoundError: There is no such folder.
        ValueError: The folder holds no recording, or a recording was interrupted; the message names the remedy.
    """
    title, is_data_set, found = find_drives(pathlib.Path(folder))
    recordings = [Recording(*drive) for drive in found]
    return DataSet(pathlib.Path(folder), title, recordings) if is_data_set else recordings[0]


class Recording:
    """One recorded drive.

    ``recording["ego"]`` is a pandas table; ``tables`` lists the names. A notebook shows the positions of all vehicles over time.

    Attributes:
        folder: Folder of the recording.
        participant: ``sub-...`` in a study; otherwise empty, like the next four.
        segment: Segment of the study.
        place: Place among the trials.
        condition: Name of the condition.
        levels: Level of each factor.
        baseline: The same drive from the same seed without advice, or None.
    """

    def __init__(
        self,
        participant: str,
        segment: str,
        place: str,
        condition: str,
        levels: list[tuple[str, str]],
        folder: pathlib.Path,
        baseline: pathlib.Path | None,
    ) -> None:
        self.participant, self.segment, self.place, self.condition = participant, segment, place, condition
        self.levels = dict(levels)
        self.folder = folder
        self.baseline = None if baseline is None else Recording(participant, segment, place, condition, levels, baseline, None)

    @functools.cached_property
    def manifest(self) -> dict[str, Any]:
        """Returns the description of the drive, the map and the program: ``manifest.json``."""
        return json.loads((self.folder / "manifest.json").read_text(encoding="utf-8"))

    @functools.cached_property
    def settings(self) -> dict[str, Any]:
        """Returns the settings of the drive, by the names of a scenario, SI units."""
        return json.loads(recorded_settings(self.folder))

    @property
    def tables(self) -> list[str]:
        """Returns the names of the tables; tables of other devices are ``streams/NAME``."""
        files = [*self.folder.glob("*.parquet"), *self.folder.glob("streams/*.parquet")]
        return sorted(file.relative_to(self.folder).with_suffix("").as_posix() for file in files)

    def __getitem__(self, name: str) -> Any:
        """Returns the pandas table of this name."""
        return self.table(name)

    def table(self, name: str, as_: Frames = "pandas") -> Any:
        """Returns a table: ``tick`` counts 10 ms; all other columns have the unit at the end of their name.

        Raises:
            KeyError: There is no such table; the message lists the tables.
            ImportError: The library for Parquet is not installed.
        """
        if name not in self.tables:
            raise KeyError(f"no table {name!r} in {self.folder}; allowed: {', '.join(self.tables)}")
        return _frame(self.folder / f"{name}.parquet", as_)

    def measures(self, as_: Frames = "pandas") -> Any:
        """Returns the measures of the drive: its row of ``codrive analyse``'s trials.csv."""
        return _csv(measures(self.folder), as_)

    def space_time(self) -> str | None:
        """Returns the positions of all vehicles over time, coloured by speed, the ego outlined, as SVG; None if too little to draw."""
        return space_time(self.folder)

    @property
    def title(self) -> str:
        """Returns participant, segment, place and condition, or the name of the folder."""
        words = [self.participant, self.segment, self.place, self.condition]
        return " ".join(word for word in words if word) or self.folder.name

    def __repr__(self) -> str:
        return f"<codrive_sim.Recording {self.title}: {', '.join(self.tables)}>"

    def _repr_html_(self) -> str:
        facts = {
            "map": self.manifest["map"]["name"],
            "policy": self.manifest["policy"]["name"],
            "driver": self.manifest["driver"],
            "ended": self.manifest.get("ended") or "cut",
        }
        said = ", ".join(f"{key} {html.escape(str(value))}" for key, value in facts.items())
        return f"<p><b>{html.escape(self.title)}</b>: {said}</p>{self.space_time() or ''}"


class DataSet:
    """Drives of a study, or of one participant of it.

    Attributes:
        folder: Folder of the data set.
        title: Name of the study, or the participant.
        recordings: Drives in the order of participants and places, without excluded ones.
    """

    def __init__(self, folder: pathlib.Path, title: str, recordings: list[Recording]) -> None:
        self.folder, self.title, self.recordings = folder, title, recordings

    def __len__(self) -> int:
        return len(self.recordings)

    def __iter__(self) -> Iterator[Recording]:
        return iter(self.recordings)

    def __getitem__(self, at: int) -> Recording:
        return self.recordings[at]

    @property
    def drives(self) -> Any:
        """Returns a pandas table with one row per drive: participant, segment, place, condition, levels of factors, folder."""
        return library("pandas").DataFrame(
            {
                "participant": one.participant,
                "segment": one.segment,
                "place": one.place,
                "condition": one.condition,
                **one.levels,
                "folder": str(one.folder),
            }
            for one in self.recordings
        )

    def measures(self, as_: Frames = "pandas") -> Any:
        """Returns the measures, one row per drive: trials.csv of ``codrive analyse``, computed on all cores."""
        return _csv(measures(self.folder), as_)

    def __repr__(self) -> str:
        people = {one.participant for one in self.recordings}
        return f"<codrive_sim.DataSet {self.title}: {len(people)} participants, {len(self)} drives>"

    def _repr_html_(self) -> str:
        head = f"<p><b>{html.escape(self.title)}</b></p>{self.drives.to_html(max_rows=20)}"
        return head + self.recordings[0]._repr_html_()


def _frame(path: pathlib.Path, as_: Frames) -> Any:
    try:
        return library(as_).read_parquet(path)
    except ImportError as fault:
        if as_ == "polars":
            raise
        raise ImportError("pandas reads these tables with pyarrow: pip install pyarrow, or use as_='polars'") from fault


def _csv(text: str, as_: Frames) -> Any:
    # Codes such as 01 are text.
    words = ("participant", "segment", "place", "condition", "ended")
    frames = library(as_)
    if as_ == "polars":
        kinds = {word: frames.String for word in words}
        return frames.read_csv(io.StringIO(text), schema_overrides=kinds, infer_schema_length=None)
    return frames.read_csv(io.StringIO(text), dtype=dict.fromkeys(words, str))
