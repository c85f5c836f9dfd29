"""A program that is started once and answers requests: one JSON object a line, both ways."""

from __future__ import annotations

import atexit
import itertools
import json
import logging
import queue
import shutil
import subprocess
import tempfile
import threading
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fsel.core import programs
from fsel.core.programs import FAILED, TIMEOUT, Program, Unfinished, words_of

PROTOCOL = 2
HELPER = Path(__file__).parent / "helper"  # goes on the program's path
LONGEST = 1 << 20  # bytes of an answer
GRACE = 15.0  # seconds to end by itself when its input ends: of torch on a busy machine
NEEDS = ("points", "files")
PIXELS = ("float32", "uint8")

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class ExternalSettings(Program):
    """A program of one's own that reconstructs and renders.

    Attributes:
        serve: the command of a worker, a list of strings: a program that is started once a job and
            answers requests, as docs/reconstructors.md describes.
    """

    serve: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "serve", words_of("serve", self.serve))
        if not self.serve:
            raise ValueError("serve must be the command of a worker, got none")

    @property
    def commands(self) -> Sequence[tuple[str, ...]]:
        """Words of the command."""
        return [self.serve]


class Lost(Unfinished):
    """The program is gone: it crashed, hung, or answered what is no answer. It can be restarted."""


class Worker:
    """One program, started at the first request, and again after it was lost."""

    def __init__(self, settings: ExternalSettings) -> None:
        self.settings, self.program = settings, " ".join(settings.serve)[:80]
        self.stated: dict[str, Any] = {}  # what it said of itself when it started
        self.bound: object = None  # what it was bound to last, since it was started
        self.bindings, self.captures = itertools.count(1), itertools.count()
        # of its log, and of the files it gets
        self.folder = Path(tempfile.mkdtemp(prefix="fsel-")).resolve()
        self._requested_at = 0  # bytes of the log at the last request, or at its start
        self._process: subprocess.Popen[bytes] | None = None
        self._answers: queue.SimpleQueue[bytes] = queue.SimpleQueue()

    def start(self) -> None:
        """Start the program, unless it runs; `Lost` when it does not answer, or states what is not
        allowed."""
        if self._process is not None:
            return
        variables = programs.environment(self.settings.venv)
        variables["PYTHONPATH"] = str(HELPER)
        started = time.perf_counter()
        with (self.folder / programs.LOG).open("ab") as log:
            self._requested_at = log.tell()
            process = subprocess.Popen(
                self.settings.command(self.settings.serve, self.folder),
                env=variables,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log,
                start_new_session=True,
            )
        self._process, self._answers = process, queue.SimpleQueue()
        threading.Thread(target=_read, args=(process, self._answers), daemon=True).start()
        self.stated = self.ask({"do": "hello", "protocol": PROTOCOL})
        if not _is_statement(self.stated):
            allowed = f"protocol {PROTOCOL}, and the rest as `hello` in worker.schema.json"
            raise self.lost(f"stated {self.stated!s:.300}; allowed: {allowed}")
        named = " ".join(str(self.stated[key]) for key in ("name", "version", "device"))
        logger.info("worker %s: ready after %.1f s", named, time.perf_counter() - started)

    def ask(self, request: Mapping[str, Any]) -> dict[str, Any]:
        """Return the answer to a request; `Unfinished` for one that is an error, and `Lost` when
        the program ended, timed out, or answered no JSON object."""
        if request["do"] != "hello":
            self._requested_at = (self.folder / programs.LOG).stat().st_size
        try:
            early = None if self._answers.empty() else self._answers.get()
            self.tell(request)
            line = self._answers.get(timeout=self.settings.timeout) if early is None else early
        except BrokenPipeError:
            line = b""
        except queue.Empty:
            doing = f"took longer than {self.settings.timeout:g} s for {request['do']!r}"
            raise self.lost(doing, TIMEOUT) from None
        except BaseException:
            self.stop()  # interrupted: its answer would be taken for the next one's
            raise
        if not line:
            raise self._ended(str(request["do"]))
        answer = None if early else _parsed(line)
        if answer is None:
            raise self.lost(f"wrote to its standard output what is not an answer: {line!r:.200}")
        if not answer["ok"]:
            said = f"{self.program} failed to {request['do']}: {answer.get('error')}"
            raise Unfinished(str(answer.get("outcome", FAILED)), said, self.log())
        return answer

    def tell(self, request: Mapping[str, Any]) -> None:
        """Send a request, or `close`, which has no answer; BrokenPipeError when the program does
        not read any more."""
        if self._process is None or self._process.stdin is None:
            raise BrokenPipeError
        self._process.stdin.write(json.dumps(request).encode() + b"\n")
        self._process.stdin.flush()

    def log(self) -> str:
        """Return the last lines that the program wrote since the last request."""
        return programs.tail(self.folder, self._requested_at)

    def stop(self) -> int | None:
        """End the program, by force where the end of its input does not; return its exit code."""
        process, self._process = self._process, None
        self.bound = None
        if process is None:
            return None
        assert process.stdin is not None
        assert process.stdout is not None
        with suppress(BrokenPipeError):
            process.stdin.close()
        try:
            process.wait(GRACE)
        except subprocess.TimeoutExpired:
            logger.warning("worker %s: did not end with its input", self.program)
        programs.kill(process.pid)  # it, or what it started and left
        code = process.wait()
        process.stdout.close()
        return code

    def close(self) -> None:
        """End the program, and remove its folder."""
        self.stop()
        shutil.rmtree(self.folder, ignore_errors=True)

    def _ended(self, doing: str) -> Lost:
        process = self._process
        assert process is not None
        try:
            code = process.wait(GRACE)
        except subprocess.TimeoutExpired:
            return self.lost(f"closed its standard output at {doing!r}")
        self.stop()
        log = self.log()
        return Lost(*programs.ended(f"{self.program}, at {doing!r},", code, log), log)

    def lost(self, said: str, outcome: str = FAILED) -> Lost:
        """End the program by force; return the error that says why."""
        if self._process is not None:
            programs.kill(self._process.pid)
        self.stop()
        return Lost(outcome, f"{self.program} {said}", self.log())


def shared(settings: ExternalSettings) -> Worker:
    """Return the one worker of this process with some settings, for all captures of a job."""
    key = repr(settings)
    if key not in _WORKERS:
        _WORKERS[key] = Worker(settings)
    return _WORKERS[key]


@atexit.register
def close_all() -> None:
    """End the workers of this process."""
    while _WORKERS:
        _WORKERS.popitem()[1].close()


_WORKERS: dict[str, Worker] = {}


def _read(process: subprocess.Popen[bytes], answers: queue.SimpleQueue[bytes]) -> None:
    """Queue the lines that a program writes, and an empty one when it writes no more."""
    assert process.stdout is not None
    try:
        while line := process.stdout.readline(LONGEST):
            answers.put(line)
    except (OSError, ValueError):
        pass  # closed under this thread
    answers.put(b"")


def _parsed(line: bytes) -> dict[str, Any] | None:
    """Return an answer, or None where a line is none."""
    try:
        found = json.loads(line)
    except ValueError:
        return None
    return found if isinstance(found, dict) and isinstance(found.get("ok"), bool) else None


def _is_statement(stated: Mapping[str, Any]) -> bool:
    """Say whether a program states its protocol, names, needs and pixels as the schema has them."""
    needs = stated.get("needs")
    return (
        stated.get("protocol") == PROTOCOL
        and all(isinstance(stated.get(key), str) for key in ("name", "version", "device"))
        and isinstance(needs, list)
        and all(need in NEEDS for need in needs)
        and stated.get("pixels") in PIXELS
    )
