"""Messages in terms of Python: messages of the engines use the program's options and settings."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable
from types import TracebackType

#: Arguments of ``make`` that are shorter than their settings, with the names of the settings in messages. "action" means the setting only
#: at the beginning of a line.
_LONGER = {"hold": r"\bhold_s\b", "advice": r"^action\b"}
#: Options of ``codrive run`` in messages, and the arguments that they correspond to here.
_OPTIONS = {name: name.replace("-", "_") for name in ("traffic", "other-model", "participant", "path", "path-start", "wave-wait")}
_OPTION = re.compile(rf"(?<![\w-])--({'|'.join(sorted(_OPTIONS, key=len, reverse=True))})(?![\w-])(?: (\w+))?")
_TRAFFIC = re.compile(r"\btraffic (sumo|native)\b")
_COMMAND = re.compile(r"\bcodrive (map|run|policy|train) ?\w*")
_PROGRAM = "; the program codrive has this command: scripts/drive of a checkout builds it"


class InWordsOfPython:
    """Context that converts errors of the engines to terms of Python; ``shorter`` are the arguments of ``_LONGER`` that were given."""

    def __init__(self, shorter: Iterable[str] = ()) -> None:
        self._shorter = shorter

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None) -> None:
        if kind not in (TypeError, ValueError, RuntimeError):
            return
        own = of_python(str(fault), self._shorter)
        if own != str(fault):
            raise kind(own) from None


def of_python(message: str, shorter: Iterable[str] = ()) -> str:
    """Returns a message in terms of Python."""
    for argument in shorter:
        message = re.sub(_LONGER[argument], argument, message, flags=re.MULTILINE)
    message = _OPTION.sub(lambda option: _argument(option[1], option[2]), message)
    message = _TRAFFIC.sub(r"traffic='\1'", message)
    return message + _PROGRAM if _COMMAND.search(message) else message


def did_you_mean(given: object, known: Iterable[str]) -> str:
    """Returns `` (did you mean ...?)`` if a known name is similar, else an empty text."""
    near = difflib.get_close_matches(str(given), list(known), n=1)
    return f" (did you mean {near[0]}?)" if near else ""


def _argument(option: str, value: str | None) -> str:
    name = _OPTIONS[option]
    return name if value is None else f"{name}={value.capitalize() if value in ('true', 'false') else repr(value)}"
