"""What a test says that cannot run here: scripts/test holds it against tests/not-run-here."""

import os

import pytest


def leave_out(request, reason, why):
    """Notes the test of a fixture's ``request`` under ``reason``, the name of a list of tests/not-run-here, and skips it."""
    if file := os.environ.get("CODRIVE_TESTS_NOT_RUN"):
        with open(file, "a", encoding="utf-8") as notes:
            notes.write(f"{reason}\tpython::{request.node.name}\n")
    pytest.skip(why)
