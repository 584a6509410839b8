"""Tests of recordings and data sets: Python reads the same values as the files and the program."""

import csv
import json
import os
import pathlib
import shutil
import subprocess
import xml.etree.ElementTree

import numpy as np
import pandas
import polars
import pyarrow.parquet
import pytest

import codrive_sim

ROOT = pathlib.Path(__file__).parents[2]
PROGRAM = pathlib.Path(os.environ.get("CODRIVE_PROGRAM", ROOT / "target/debug/codrive"))
# Two trials of one participant.
STUDY = """title = "Small"
participants = 1
[base]
traffic = "native"
vehicles = 3
duration_s = 2.0
[[condition]]
name = "slow"
set = { policy_speed_mps = 3.0 }
[[condition]]
name = "fast"
set = { policy_speed_mps = 5.0 }
[[segment]]
kind = "trials"
name = "trial"
"""


def program(*arguments):
    assert PROGRAM.is_file(), f"{PROGRAM} is not there: cargo build, or CODRIVE_PROGRAM says where it is"
    subprocess.run([PROGRAM, *arguments], check=True, capture_output=True, text=True, cwd=ROOT)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Records a drive of 15 s with 21 vehicles of the native engine, and makes its report."""
    out = tmp_path_factory.mktemp("read") / "out"
    program("run", "--traffic", "native", "--policy", "pi", "--driver", "sloppy", "--duration", "15", "--seed", "3", "--out", out)
    program("analyse", out)
    return out


def test_a_recording_has_the_tables_that_are_in_its_folder(folder):
    drive = codrive_sim.read(folder)
    assert isinstance(drive, codrive_sim.Recording)
    assert drive.tables == sorted(path.stem for path in folder.glob("*.parquet")) and {"ego", "cars"} <= set(drive.tables)
    for name in drive.tables:
        other = pyarrow.parquet.read_table(folder / f"{name}.parquet")
        assert list(drive[name].columns) == other.column_names == drive.table(name, "polars").columns
        assert len(drive[name]) == other.num_rows == drive.table(name, "polars").height
    assert np.array_equal(drive["ego"].speed_mps, pyarrow.parquet.read_table(folder / "ego.parquet")["speed_mps"].to_numpy())
    # 15 s in ticks of 10 ms.
    assert drive["ego"].tick.max() == 1500
    assert isinstance(drive["ego"], pandas.DataFrame) and isinstance(drive.table("ego", "polars"), polars.DataFrame)


def test_a_recording_knows_how_it_was_set(folder):
    drive = codrive_sim.read(str(folder))
    assert drive.settings["duration_s"] == 15.0 and drive.settings["seed"] == 3 and drive.settings["policy"] == "pi"
    assert drive.manifest == json.loads((folder / "manifest.json").read_text())
    assert drive.baseline is None and drive.levels == {} and "ego" in repr(drive)


def test_measures_are_those_of_the_report(folder):
    (analysed,) = [path for path in folder.parent.rglob("trials.csv")]
    with open(analysed, encoding="utf-8") as file:
        (told,) = csv.DictReader(file)
    for row in (codrive_sim.read(folder).measures().iloc[0], codrive_sim.read(folder).measures("polars").row(0, named=True)):
        for name, value in told.items():
            own = row[name]
            assert own == value if isinstance(own, str) else value == "" and pandas.isna(own) or float(value) == own, name


def test_a_notebook_shows_a_picture_of_each_vehicles_way(folder):
    drive = codrive_sim.read(folder)
    picture = xml.etree.ElementTree.fromstring(drive.space_time())
    assert picture.tag.endswith("svg") and len(picture.findall(".//{*}image") + picture.findall(".//{*}path")) > 0
    assert drive.space_time() in drive._repr_html_() and "ring-250" in drive._repr_html_()


def test_a_data_set_lists_its_drives_and_measures_all_of_them(tmp_path):
    (tmp_path / "small.toml").write_text(STUDY)
    program("study", "rehearse", tmp_path / "small.toml", "--participants", "1", "--out", tmp_path / "study")
    data = codrive_sim.read(tmp_path / "study")
    before = sorted(path for path in (tmp_path / "study").rglob("*"))
    trials = sorted(path.parent.name for path in (tmp_path / "study").rglob("manifest.json") if not path.parent.name.endswith("-baseline"))
    assert isinstance(data, codrive_sim.DataSet) and [drive.folder.name for drive in data] == trials
    assert len(data) == len(trials) and data[0].participant == "sub-R01"
    assert all(drive.baseline.folder.name == f"{drive.folder.name}-baseline" for drive in data)
    assert list(data.drives.participant) == ["sub-R01"] * len(data) and "condition" in data.drives
    measured = data.measures()
    assert list(measured.participant) == list(data.drives.participant) and measured.mean_speed_mps.between(0, 20).all()
    assert "<svg" in data._repr_html_() and "1 participants" in repr(data)
    assert sorted(path for path in (tmp_path / "study").rglob("*")) == before


def test_what_cannot_be_read_is_said(folder, tmp_path):
    with pytest.raises(FileNotFoundError, match="no folder .*nowhere"):
        codrive_sim.read(tmp_path / "nowhere")
    with pytest.raises(ValueError, match=str(tmp_path)):
        codrive_sim.read(tmp_path)
    with pytest.raises(KeyError, match="no table 'eggo'.*ego"):
        codrive_sim.read(folder)["eggo"]
    with pytest.raises(ValueError, match="'pandas', 'polars'"):
        codrive_sim.read(folder).table("ego", "arrow")
    cut = tmp_path / "cut"
    shutil.copytree(folder, cut)
    (cut / "scenario.toml").write_text("speed = ")
    with pytest.raises(ValueError, match="scenario.toml"):
        codrive_sim.read(cut).settings
    shutil.copy(folder / "scenario.toml", cut)
    (cut / "cars.parquet").write_bytes(b"PAR1")
    with pytest.raises(Exception, match="(?i)parquet"):
        codrive_sim.read(cut)["cars"]
    with pytest.raises(ValueError, match="cars.parquet"):
        codrive_sim.read(cut).space_time()
