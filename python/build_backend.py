"""Build backend of the package: maturin's, after a check of the compilers that a build needs. Without Rust, maturin alone would download a
toolchain, and pip would not show that it does.
"""

from __future__ import annotations

import os
import pathlib
import re
import shutil
import subprocess
import sys
from collections.abc import Mapping
from typing import Any

import maturin
from maturin import (  # noqa: F401, as pip calls them here
    build_editable,
    build_sdist,
    build_wheel,
    get_requires_for_build_sdist,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)


def get_requires_for_build_wheel(config_settings: dict[str, Any] | None = None) -> list[str]:
    """Returns the requirements of a build. Ends it with one line about what is missing here."""
    if missing := missing_compiler(os.environ):
        sys.exit(missing)
    return maturin.get_requires_for_build_wheel(config_settings)


get_requires_for_build_editable = get_requires_for_build_wheel


def missing_compiler(environment: Mapping[str, str]) -> str | None:
    """Returns what to install before a build, in one line; None if nothing is missing."""
    path, needed = environment.get("PATH"), _rust_version()
    install = f"install Rust 1.{needed} or newer from https://rustup.rs, open a new shell, and run the same command again"
    version = _output([shutil.which("rustc", path=path), "--version"]) if shutil.which("cargo", path=path) else ""
    found = re.match(r"rustc 1\.(\d+)", version)
    if not found:
        return f"codrive-sim is compiled here, and no Rust compiler was found: {install}"
    if int(found[1]) < needed:
        return f"codrive-sim is compiled here, and {version} is too old: rustup update stable, or {install}"
    # Rust links with the C compiler, which also compiles libraries. On Windows, Rust finds Microsoft's by itself.
    if os.name != "nt" and not environment.get("CC") and not shutil.which("cc", path=path):
        return "codrive-sim is compiled here, and no C compiler (cc) was found: apt install gcc (Debian), xcode-select --install (macOS)"
    return None


def _output(command: list[str | None]) -> str:
    """Returns the first line that a program prints; an empty text if it cannot run."""
    if command[0] is None:
        return ""
    try:
        lines = subprocess.run(command, capture_output=True, text=True, timeout=60).stdout.splitlines()
    except (OSError, subprocess.SubprocessError):
        return ""
    return lines[0] if lines else ""


def _rust_version() -> int:
    """Returns the oldest minor version of Rust that compiles the package, from the manifest beside this file."""
    manifest = pathlib.Path(__file__).with_name("Cargo.toml").read_text(encoding="utf-8")
    return int(re.search(r'^rust-version = "1\.(\d+)"', manifest, re.MULTILINE)[1])
