"""Tests of the build's check of compilers, with programs that only print a version."""

import importlib.util
import os
import pathlib
import re
import subprocess
import sys

import pytest

FOLDER = pathlib.Path(__file__).parents[1]
#: Oldest Rust that builds the program, as its manifest says.
OLDEST = re.search(r'^rust-version = "(.*)"$', (FOLDER.parent / "Cargo.toml").read_text(encoding="utf-8"), re.MULTILINE)[1]

pytestmark = pytest.mark.skipif(os.name == "nt", reason="the programs are scripts of a shell")


@pytest.fixture
def backend():
    """Returns the module of the build."""
    spec = importlib.util.spec_from_file_location("build_backend", FOLDER / "build_backend.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def programs(folder: pathlib.Path, **printed: str) -> dict[str, str]:
    """Returns an environment with nothing but programs of these names, which print these texts."""
    for name, text in printed.items():
        (folder / name).write_text(f"#!/bin/sh\necho '{text}'\n")
        (folder / name).chmod(0o755)
    return {"PATH": str(folder)}


def test_a_build_without_rust_says_in_one_line_what_to_install(backend, tmp_path):
    for there in ({}, {"cc": "cc"}, {"rustc": f"rustc {OLDEST}.0"}, {"cargo": "cargo", "rustc": "error: no default toolchain"}):
        folder = tmp_path / str(len(list(tmp_path.iterdir())))
        folder.mkdir()
        said = backend.missing_compiler(programs(folder, **there))
        assert "no Rust compiler was found" in said and f"install Rust {OLDEST} or newer from https://rustup.rs" in said and "\n" not in said


def test_an_old_rust_and_a_missing_linker_are_named(backend, tmp_path):
    rust = {"cargo": "cargo", "rustc": "rustc 1.94.1 (e408947bf 2026-03-25)"}
    said = backend.missing_compiler(programs(tmp_path, cc="cc", **rust))
    assert "rustc 1.94.1 (e408947bf 2026-03-25) is too old: rustup update stable" in said and "\n" not in said
    rust["rustc"] = f"rustc {OLDEST}.0 (59807616e 2026-04-14)"
    assert backend.missing_compiler(programs(tmp_path, cc="cc", **rust)) is None
    (tmp_path / "cc").unlink()
    said = backend.missing_compiler(programs(tmp_path, **rust))
    assert "no C compiler (cc) was found" in said and "\n" not in said
    assert backend.missing_compiler({**programs(tmp_path, **rust), "CC": "clang"}) is None


def test_the_hook_that_installers_call_first_ends_with_that_line(tmp_path):
    ask = "import build_backend; print(build_backend.get_requires_for_build_wheel())"
    asked = {"capture_output": True, "text": True, "cwd": FOLDER}
    path = os.pathsep.join(filter(None, sys.path))
    refused = subprocess.run([sys.executable, "-c", ask], env={"PATH": str(tmp_path), "PYTHONPATH": path}, **asked)
    assert refused.returncode == 1 and refused.stdout == "" and len(refused.stderr.splitlines()) == 1, refused.stderr
    rust = programs(tmp_path, cargo="cargo", rustc=f"rustc {OLDEST}.0", cc="cc")
    begun = subprocess.run([sys.executable, "-c", ask], env={**rust, "PYTHONPATH": path}, **asked)
    assert begun.returncode == 0 and begun.stdout == "[]\n", begun.stderr
