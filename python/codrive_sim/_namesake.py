"""The name ``codrive`` of Python distributions. On the package index it is another project's, and old builds of this package had it."""

from __future__ import annotations

from importlib import metadata


def namesake_remedy() -> tuple[bool, str]:
    """Returns whether an old build of this package is installed as ``codrive``, and what to do about an installed ``codrive``; an empty text
    without one."""
    try:
        namesake = metadata.distribution("codrive")
    except metadata.PackageNotFoundError:
        return False, ""
    if any(file.name.startswith("_codrive.") for file in namesake.files or ()):
        return True, "an old build of this package is installed under the name codrive\n  remedy: pip uninstall codrive"
    return False, "the installed package codrive is another project; this one is codrive-sim, imported as codrive_sim"
