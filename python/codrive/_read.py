"""``read``: recordings and the data sets of studies, as tables and pictures."""

from __future__ import annotations

import functools
import html
import io
import json
import os
import pathlib
from collections.abc import Iterator
from typing import Any

from codrive._codrive import find_drives, measures, recorded_settings, space_time
from codrive._frames import Frames, library


def read(folder: str | os.PathLike[str]) -> Recording | DataSet:
    """Opens what ``codrive`` has recorded: one drive (``codrive run --out``), the data set of a study, or one participant of it.

    Args:
        folder: That of a recording (with ``manifest.json``), of a data set (with ``dataset_description.json``), or a ``sub-*`` in one.

    Returns:
        A ``Recording`` or a ``DataSet``. Tables are read when they are asked for.

    Raises:
        FileNotFoundError: There is no such folder.
        ValueError: It holds nothing that was recorded, or a recording was cut; the message says what mends it.
    """
    title, is_data_set, found = find_drives(pathlib.Path(folder))
    recordings = [Recording(*drive) for drive in found]
    return DataSet(pathlib.Path(folder), title, recordings) if is_data_set else recordings[0]


class Recording:
    """One recorded drive.

    ``recording["ego"]`` is a table as pandas has it; ``tables`` lists them. A notebook shows the positions of all vehicles over time.

    Attributes:
        folder: Where it is.
        participant: ``sub-...`` in a study; else empty, as the next four.
        segment: Segment of the study.
        place: Place among the trials.
        condition: Condition.
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
        """What was driven, where, and by which program: ``manifest.json``."""
        return json.loads((self.folder / "manifest.json").read_text(encoding="utf-8"))

    @functools.cached_property
    def settings(self) -> dict[str, Any]:
        """How the drive was set, by the names of a scenario, SI units."""
        return json.loads(recorded_settings(self.folder))

    @property
    def tables(self) -> list[str]:
        """Names of its tables; those of other devices are ``streams/NAME``."""
        files = [*self.folder.glob("*.parquet"), *self.folder.glob("streams/*.parquet")]
        return sorted(file.relative_to(self.folder).with_suffix("").as_posix() for file in files)

    def __getitem__(self, name: str) -> Any:
        """The table of this name as pandas has it."""
        return self.table(name)

    def table(self, name: str, as_: Frames = "pandas") -> Any:
        """A table: ``tick`` counts 10 ms, all else in the units that the column's name ends in.

        Raises:
            KeyError: There is no such table; the message lists them.
            ImportError: What reads Parquet is not installed.
        """
        if name not in self.tables:
            raise KeyError(f"no table {name!r} in {self.folder}; there are {', '.join(self.tables)}")
        return _frame(self.folder / f"{name}.parquet", as_)

    def measures(self, as_: Frames = "pandas") -> Any:
        """The drive in numbers: its row of ``codrive analyse``'s trials.csv."""
        return _csv(measures(self.folder), as_)

    def space_time(self) -> str | None:
        """Positions of all vehicles over time, coloured by speed, the ego outlined, as SVG; None where there is nothing to draw."""
        return space_time(self.folder)

    @property
    def title(self) -> str:
        """The drive in words."""
        words = [self.participant, self.segment, self.place, self.condition]
        return " ".join(word for word in words if word) or self.folder.name

    def __repr__(self) -> str:
        return f"<codrive.Recording {self.title}: {', '.join(self.tables)}>"

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
    """The drives of a study, or of one participant of it.

    Attributes:
        folder: Where it is.
        title: Name of the study, or the participant.
        recordings: Its drives, in the order of participants and places; those that are excluded are left out.
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
        """A row a drive: participant, segment, place, condition, levels of factors, folder, as pandas has it."""
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
        """A row a drive in numbers: trials.csv of ``codrive analyse``, computed on all cores."""
        return _csv(measures(self.folder), as_)

    def __repr__(self) -> str:
        people = {one.participant for one in self.recordings}
        return f"<codrive.DataSet {self.title}: {len(people)} participants, {len(self)} drives>"

    def _repr_html_(self) -> str:
        head = f"<p><b>{html.escape(self.title)}</b></p>{self.drives.to_html(max_rows=20)}"
        return head + self.recordings[0]._repr_html_()


def _frame(path: pathlib.Path, as_: Frames) -> Any:
    try:
        return library(as_).read_parquet(path)
    except ImportError as fault:
        if as_ == "polars":
            raise
        raise ImportError("pandas reads these tables with pyarrow: pip install pyarrow, or ask for as_='polars'") from fault


def _csv(text: str, as_: Frames) -> Any:
    # Codes such as 01 are words.
    words = ("participant", "segment", "place", "condition", "ended")
    frames = library(as_)
    if as_ == "polars":
        kinds = {word: frames.String for word in words}
        return frames.read_csv(io.StringIO(text), schema_overrides=kinds, infer_schema_length=None)
    return frames.read_csv(io.StringIO(text), dtype=dict.fromkeys(words, str))
