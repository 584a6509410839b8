"""Choice of the library for tables."""

from __future__ import annotations

from typing import Any, Literal

Frames = Literal["pandas", "polars"]


def library(as_: str) -> Any:
    """Returns the library of this name.

    Raises:
        ValueError: The name is neither of the two.
        ImportError: The library is not installed.
    """
    if as_ not in ("pandas", "polars"):
        raise ValueError(f"as_ is {as_!r}; allowed: 'pandas', 'polars'")
    if as_ == "pandas":
        import pandas

        return pandas
    try:
        import polars
    except ImportError:
        raise ImportError("as_='polars' needs polars: pip install polars") from None
    return polars
