"""Drives in processes of their own, as a process can hold one SUMO, and a crash of SUMO ends the process. ``_worker`` is their program.

Messages are pickled, preceded by their length, and sent over the pipes of standard input and output.
"""

from __future__ import annotations

import builtins
import os
import pickle
import select
import signal
import struct
import subprocess
import sys
import weakref
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, BinaryIO

from codrive_sim._drives import Arguments
from codrive_sim._runtime_folder import runtime_variables

if TYPE_CHECKING:
    from codrive_sim._evaluation_drives import EvaluationArguments

#: Time that a worker has to end by itself, s: SUMO removes its files.
_GRACE_S = 5.0
#: Interval of checks for Ctrl-C during a wait, ms.
_LOOK_MS = 200
_AGAIN = "reset() starts another"
#: Exceptions that are raised here with the same type; others become a RuntimeError.
_KINDS = ("TypeError", "ValueError", "OverflowError", "RuntimeError", "OSError", "FileNotFoundError", "MemoryError")


#: First bytes from a worker; output before them, from the start of Python, is skipped.
READY = b"\0codrive worker\0"


def wait_for_ready(pipe: BinaryIO) -> None:
    """Skips the output before a worker is ready.

    Raises:
        EOFError: The other end is closed.
    """
    seen = b""
    while seen != READY:
        seen = (seen + _read(pipe, 1))[-len(READY) :]


def write_message(pipe: BinaryIO, message: Any) -> None:
    """Writes a message and flushes the pipe."""
    content = pickle.dumps(message, protocol=pickle.HIGHEST_PROTOCOL)
    left = memoryview(struct.pack("<Q", len(content)) + content)
    while left:
        left = left[pipe.write(left) :]
    pipe.flush()


def read_message(pipe: BinaryIO) -> Any:
    """Waits for a message in an unbuffered pipe.

    Raises:
        EOFError: The other end is closed.
    """
    return pickle.loads(_read(pipe, struct.unpack("<Q", _read(pipe, 8))[0]))


def _read(pipe: BinaryIO, size: int) -> bytes:
    content = bytearray()
    poll = select.poll() if hasattr(select, "poll") else None
    if poll is not None:
        poll.register(pipe, select.POLLIN)
    while len(content) < size:
        # Ctrl-C just before the call that waits does not end it, so the wait is short and repeated.
        while poll is not None and not poll.poll(_LOOK_MS):
            pass
        part = pipe.read(size - len(content))
        if not part:
            raise EOFError
        content += part
    return bytes(content)


class WorkerDrive:
    """Drive in a process of its own. ``begin`` starts the process, also after it was lost.

    A call is ``ask`` and then ``answer``, so that many drives can run at once.
    """

    def __init__(
        self, arguments: Arguments | EvaluationArguments, variables: dict[str, str], folder: str, again: str = _AGAIN
    ) -> None:
        """Stores the arguments. ``variables`` are changes of the process's environment, ``folder`` is the base of relative paths, and
        ``again`` says how to replace a process that has ended."""
        self._again = again
        self._arguments = arguments
        self._variables = variables
        self._folder = folder
        self._process: subprocess.Popen[bytes] | None = None
        self._end: weakref.finalize[..., Any] | None = None
        self._owner = os.getpid()
        self._is_new = False

    @property
    def pid(self) -> int | None:
        """Returns the id of the process, if there is one."""
        return None if self._process is None else self._process.pid

    def call(self, name: str, *arguments: Any) -> Any:
        """Calls the method of ``LocalDrive`` with this name in the process."""
        self.ask(name, *arguments)
        return self.answer()

    def ask(self, call: str, *arguments: Any) -> None:
        """Begins a call.

        Raises:
            RuntimeError: The process has ended.
        """
        if self._process is not None and os.getpid() != self._owner:
            # The pipes belong to the process that this one was forked from.
            self._process = None
        try:
            if self._process is None and call in ("begin", "restore"):
                self._start()
            if self._process is None:
                raise RuntimeError(f"the drive has no process; {self._again}")
            write_message(self._process.stdin, (call, arguments))
        except OSError:
            raise self._lost() from None
        except BaseException:
            self.kill()
            raise

    def answer(self) -> Any:
        """Waits for the result of the call.

        Raises:
            RuntimeError: The process has ended, or the drive has failed.
            Exception: The exception of the call, with the same type.
        """
        if self._process is None:
            raise RuntimeError(f"the drive has no process; {self._again}")
        try:
            answers = self._process.stdout
            if self._is_new:
                wait_for_ready(answers)
            fault, value = read_message(answers)
            if self._is_new and fault is None:
                # The first message was the result of the settings.
                fault, value = read_message(answers)
            self._is_new = False
        except EOFError:
            raise self._lost() from None
        except BaseException:
            # Ctrl-C: a later read would get the response to an earlier call.
            self.kill()
            raise
        if fault is None:
            return value
        if fault in _KINDS:
            raise getattr(builtins, fault)(value)
        raise RuntimeError(f"{fault}: {value}")

    def reply(self, value: Any) -> None:
        """Answers a question of the process.

        Raises:
            RuntimeError: The process has ended.
        """
        try:
            write_message(self._process.stdin, value)
        except OSError:
            raise self._lost() from None

    def hang_up(self) -> None:
        """Lets the process end by itself; ``close`` waits for it."""
        if self._process is not None and os.getpid() == self._owner:
            _close(self._process.stdin)

    def close(self) -> None:
        """Ends the process."""
        self._process = None
        if self._end is not None:
            self._end()

    def kill(self) -> None:
        """Ends the process at once."""
        if self._process is not None and os.getpid() == self._owner:
            self._process.kill()
        self.close()

    def _start(self) -> None:
        if not sys.executable:
            raise RuntimeError("sys.executable is empty, so no Python process can be started; set it to the interpreter's path")
        # The process finds modules in the same places and order as this one.
        variables = {
            **os.environ,
            **runtime_variables(),
            **self._variables,
            "PYTHONPATH": os.pathsep.join(path for path in sys.path if isinstance(path, str) and path),
            "PYTHONSAFEPATH": "1",
        }
        try:
            process = subprocess.Popen(
                [sys.executable, "-m", "codrive_sim._worker"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                bufsize=0,
                cwd=self._folder,
                env=variables,
            )
        except OSError as why:
            raise RuntimeError(f"no process can be started for the drive: {why}") from None
        self._owner = os.getpid()
        self._process = process
        self._end = weakref.finalize(self, _finish, process)
        self._is_new = True
        write_message(process.stdin, self._arguments)

    def _lost(self) -> RuntimeError:
        """Returns the error for a process that has ended, with its exit status and the remedy."""
        process = self._process
        # Reports the end of the process itself, not that it was killed here.
        self.close()
        how = "" if process is None else f" ({_ending(process.returncode)})"
        return RuntimeError(f"the drive's process has ended{how}; {self._again}")


def close_all(drives: Iterable[WorkerDrive]) -> None:
    """Ends the processes of all drives in parallel."""
    drives = list(drives)
    for drive in drives:
        drive.hang_up()
    for drive in drives:
        drive.close()


def _ending(status: int) -> str:
    """Returns the meaning of an exit status."""
    if status < 0:
        try:
            return signal.Signals(-status).name
        except ValueError:
            return f"signal {-status}"
    return f"exit status {status}"


def _close(pipe: BinaryIO | None) -> None:
    try:
        if pipe is not None:
            pipe.close()
    except OSError:
        pass  # The other end is closed; unsent data is lost.


def _finish(process: subprocess.Popen[bytes]) -> None:
    """Ends a process and waits for it, so that none is left as a zombie. A fork, which is not its parent, only closes the pipes."""
    _close(process.stdin)
    try:
        process.wait(_GRACE_S)
    except BaseException as why:
        process.kill()
        process.wait()
        if not isinstance(why, subprocess.TimeoutExpired):
            raise
    finally:
        _close(process.stdout)
