"""Tests of the hints about another distribution with the name codrive, by distributions of empty files."""

import pathlib
import subprocess
import sys

import pytest

from codrive_sim._distribute import RayCluster
from codrive_sim._namesake import namesake_remedy


def distribution(folder: pathlib.Path, *files: str) -> pathlib.Path:
    """Writes a distribution codrive with these files, as pip does. Returns the folder to search."""
    listed = folder / "codrive-0.2.1.dist-info"
    listed.mkdir()
    (listed / "METADATA").write_text("Metadata-Version: 2.1\nName: codrive\nVersion: 0.2.1\n")
    (listed / "RECORD").write_text("".join(f"{file},,\n" for file in files))
    for file in files:
        (folder / file).parent.mkdir(exist_ok=True)
        (folder / file).touch()
    return folder


def test_an_old_build_is_told_from_another_projects_package(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    assert namesake_remedy() == (False, "")
    for name, files, is_old, text in (
        ("old", ["codrive/__init__.py", "codrive/_codrive.abi3.so"], True, "remedy: pip uninstall codrive"),
        ("theirs", ["codrive/__init__.py", "codrive/motor.py"], False, "is another project; this one is codrive-sim"),
    ):
        (tmp_path / name).mkdir()
        monkeypatch.setattr(sys, "path", [str(distribution(tmp_path / name, *files))])
        found_old, remedy = namesake_remedy()
        assert found_old is is_old and text in remedy


def test_an_import_warns_of_an_old_build_only(tmp_path):
    for file, warns in (("codrive/_codrive.abi3.so", True), ("codrive/motor.py", False)):
        folder = tmp_path / file.replace("/", "-")
        folder.mkdir()
        code = f"import sys; sys.path.append({str(distribution(folder, file))!r}); import codrive_sim"
        run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        assert run.returncode == 0 and ("pip uninstall codrive" in run.stderr) is warns, run.stderr


def test_a_cluster_without_ray_names_the_other_project(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(ImportError) as without:
        RayCluster()
    assert str(without.value) == "runs on a cluster need Ray: pip install './python[ray]'"
    monkeypatch.syspath_prepend(distribution(tmp_path, "codrive/motor.py"))
    with pytest.raises(ImportError, match="(?s)pip install './python.ray.'\n.*codrive is another project"):
        RayCluster()
