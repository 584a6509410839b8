"""The name ``codrive`` of Python distributions. On the package index it is another project's, and old builds of this package had it."""

from __future__ import annotations

import importlib.util


def namesake_remedy() -> tuple[bool, str]:
    """Returns whether an old build of this package is installed as ``codrive``, and what to do about an installed ``codrive``; an empty text
    without one."""
    if importlib.util.find_spec("codrive") is None:
        return False, ""
    # Takes 20 ms, which the start of each process of a drive should not.
    from importlib import metadata

    try:
        namesake = metadata.distribution("codrive")
    except metadata.PackageNotFoundError:
        return False, ""
    if any(file.name.startswith("_codrive.") for file in namesake.files or ()):
        return True, "an old build of this package is installed under the name codrive\n  remedy: pip uninstall codrive"
    return False, "the installed package codrive is another project; this one is codrive-sim, imported as codrive_sim"
