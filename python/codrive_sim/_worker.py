"""``python -m codrive_sim._worker``: process of one drive; ``_workers`` starts it and defines its messages."""

from __future__ import annotations

import os
import signal

import numpy as np
from numpy.typing import NDArray

from codrive_sim._drives import LocalDrive
from codrive_sim._evaluation_drives import EvaluationArguments, LocalEvaluation, Question
from codrive_sim._workers import READY, read_message, write_message


def main() -> None:
    """Handles calls until the other end is closed."""
    # Ctrl-C reaches all processes of a terminal; the process that started this one decides.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    requests, replies = os.fdopen(os.dup(0), "rb", buffering=0), os.fdopen(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 0)
    # SUMO and native code print, which would mix with the replies.
    try:
        os.dup2(2, 1)
    except OSError:
        os.dup2(nothing, 1)

    def ask(policy: int, seen: NDArray[np.float32]) -> float:
        try:
            write_message(replies, (None, Question(policy, seen)))
            return read_message(requests)
        except (EOFError, BrokenPipeError):
            # The process that answers has ended, in the middle of a drive.
            os._exit(0)

    drive = None
    try:
        replies.write(READY)
        arguments = read_message(requests)
        while True:
            try:
                if drive is None:
                    is_evaluation = isinstance(arguments, EvaluationArguments)
                    drive, value = LocalEvaluation(arguments, ask) if is_evaluation else LocalDrive(arguments), None
                else:
                    call, given = read_message(requests)
                    value = getattr(drive, call)(*given)
                reply = (None, value)
            except EOFError:
                return
            except Exception as fault:
                reply = (type(fault).__name__, str(fault))
            write_message(replies, reply)
            if drive is None:
                return
    except (EOFError, BrokenPipeError):
        return


if __name__ == "__main__":
    main()
