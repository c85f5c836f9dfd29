"""Values of options: read from the command line, or refused with what is allowed."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable
from importlib.metadata import version

NUMBER = r"\d+\.?\d*|\.\d+"
SIZE = re.compile(rf"({NUMBER})\s*([kmgt]?)(i?)b?", re.IGNORECASE)
DURATION = re.compile(rf"({NUMBER})\s*(s|m|min|h)?")
SECONDS = {None: 1, "s": 1, "m": 60, "min": 60, "h": 3600}
POWERS = {"": 0, "k": 1, "m": 2, "g": 3, "t": 4}


class Version(argparse.Action):
    """Print of the version, looked up when it is needed, since that takes as long as parsing."""

    def __call__(self, parser, namespace, values, option=None):
        print(f"fsel {version('fsel')}")
        parser.exit()


class Captures(argparse.Action):
    """Storage of the first path as `capture`, and of the others as `beside`."""

    def __call__(self, parser, namespace, values, option=None):
        namespace.capture, *namespace.beside = values


def whole(least: int, most: int | None = None) -> Callable[[str], int]:
    """Reads a whole number between two bounds, both included."""
    allowed = f"{least} or more" if most is None else f"{least} to {most}"

    def number(text: str) -> int:
        value = _integer(text, f"a whole number, {allowed}")
        if value < least or (most is not None and value > most):
            raise argparse.ArgumentTypeError(f"{text} is out of range; allowed: {allowed}")
        return value

    return number


def number_or_auto(text: str) -> int | str:
    """A whole number, or `auto`."""
    return text if text == "auto" else _integer(text, "a whole number, or auto")


def numbers(text: str) -> list[int]:
    """Whole numbers between commas, each once, ascending."""
    return sorted({_integer(word, "whole numbers, as 10,20,30") for word in text.split(",")})


def words(text: str) -> list[str]:
    """Words between commas, each once; spaces around them do not count."""
    names = list(dict.fromkeys(word.strip() for word in text.split(",") if word.strip()))
    if not names:
        raise argparse.ArgumentTypeError(f"{text!r} names nothing; allowed: words between commas")
    return names


def positive(text: str) -> float:
    """A number above zero."""
    try:
        number = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is no number; allowed: more than 0") from None
    if not number > 0:
        raise argparse.ArgumentTypeError(f"{text!r} is out of range; allowed: more than 0")
    return number


def size_in_bytes(text: str) -> int:
    """8GB, 500M (powers of 1000), 8GiB, 500MiB (powers of 1024), or plain bytes."""
    parts = SIZE.fullmatch(text.strip())
    if parts is None or (parts[3] and not parts[2]) or not float(parts[1]) > 0:
        raise argparse.ArgumentTypeError(
            f"{text!r} is no size; allowed: as 8GB, 500M, 8GiB, or plain bytes, more than 0"
        )
    return int(float(parts[1]) * (1024 if parts[3] else 1000) ** POWERS[parts[2].lower()])


def duration(text: str) -> float:
    """10s, 2m, 2min, 1h, or plain seconds."""
    parts = DURATION.fullmatch(text.strip())
    if parts is None or not float(parts[1]) > 0:
        raise argparse.ArgumentTypeError(
            f"{text!r} is no duration; allowed: as 10s, 2m, 1h, or plain seconds, more than 0"
        )
    return float(parts[1]) * SECONDS[parts[2]]


def duration_or_none(text: str) -> float:
    """Read a duration as `duration` does, or 0."""
    return 0.0 if text.strip() in ("0", "0s") else duration(text)


def _integer(text: str, allowed: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} is no whole number; allowed: {allowed}"
        ) from None
