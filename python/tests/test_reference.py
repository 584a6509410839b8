"""Test of docs/reference/python.md: the page is what the docstrings say. ``UPDATE_EXPECT=1`` with pytest writes it anew."""

import difflib
import inspect
import os
import pathlib
import re

import codrive_sim

PAGE = pathlib.Path(__file__).parents[2] / "docs/reference/python.md"
HEAD = """# Python: functions and classes

**Goal:** look up each function and class of the package `codrive_sim` with its arguments, results and errors. [Python: use](../python.md) shows how they work together.
"""
#: Sections of a docstring.
SECTION = re.compile(r"^(Args|Returns|Raises|Yields|Attributes):$", re.MULTILINE)
ENTRY = re.compile(r"^    (\*{0,2}\w[\w.*, ]*?): ", re.MULTILINE)


def signature(thing):
    """Returns the arguments of a function, without those of its instance."""
    try:
        found = inspect.signature(thing)
    except (TypeError, ValueError):
        return ""
    parameters = [one.replace(annotation=inspect.Parameter.empty) for name, one in found.parameters.items() if name not in ("self", "cls")]
    return str(found.replace(parameters=parameters, return_annotation=inspect.Signature.empty))


def text_of(doc):
    """Returns a docstring as Markdown: its sections as lists."""
    first, *rest = SECTION.split(inspect.cleandoc(doc))
    out = [first.strip()]
    for name, body in zip(rest[::2], rest[1::2]):
        entries = ENTRY.split("\n" + body)
        lines = [f"* `{entry}`: {' '.join(about.split())}" for entry, about in zip(entries[1::2], entries[2::2])]
        out.append(f"**{name}**\n\n" + ("\n".join(lines) if lines else " ".join(body.split())))
    return "\n\n".join(out).replace("``", "`") + "\n"


def section(name, thing, level=2):
    """Returns the section of a function or a class with its own methods and properties."""
    assert inspect.getdoc(thing), f"{name} has no docstring"
    of_calls = "" if isinstance(thing, property) else signature(thing)
    head = f"{'#' * level} `{name}`\n\n" + (f"```python\n{name}{of_calls}\n```\n\n" if of_calls else "")
    parts = [head + text_of(inspect.getdoc(thing))]
    if inspect.isclass(thing):
        for key, member in vars(thing).items():
            member = member.__func__ if isinstance(member, (classmethod, staticmethod)) else member
            is_part = inspect.isfunction(member) or isinstance(member, property)
            if not key.startswith("_") and is_part and inspect.getdoc(member):
                parts.append(section(f"{name}.{key}", member, level + 1))
    return "\n".join(parts)


def test_the_page_is_what_the_docstrings_say():
    names = [f"codrive_sim.{name}" for name in codrive_sim.__all__]
    things = [getattr(codrive_sim, name) for name in codrive_sim.__all__]
    is_class = [inspect.isclass(thing) for thing in things]
    functions = [pair for pair, of_class in zip(zip(names, things), is_class) if not of_class]
    classes = [pair for pair, of_class in zip(zip(names, things), is_class) if of_class]
    page = "\n".join([HEAD, *(section(name, thing) for name, thing in [*functions, *classes])])
    if os.environ.get("UPDATE_EXPECT"):
        PAGE.write_text(page, encoding="utf-8")
    there = PAGE.read_text(encoding="utf-8")
    difference = "\n".join(difflib.unified_diff(there.splitlines(), page.splitlines(), str(PAGE), "docstrings", lineterm=""))
    assert there == page, f"{difference}\n  remedy: UPDATE_EXPECT=1 python -m pytest {pathlib.Path(__file__).name}"
