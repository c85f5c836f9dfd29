"""What a command made of its input: done, refused in words, or wrong."""

import contextlib
import io
import signal
import time
import warnings

from fsel.cli import main, with_options
from fsel.reconstruct.configured import Peak

LONGEST = 20  # seconds of the processor; by the clock twenty times as long
MEMORY = 500_000_000  # bytes that a command may take, beside what the process held
# of commands alone, whose business goes beyond reading
OWN = (
    "no counterpart in transforms.json", "too few to select from", "allowed: 1 to",
    "frames are targets; at least two must remain", "not in the capture, the first",
    "bytes cannot be decoded",  # of an image that the others do not look at
)  # fmt: skip


class Hang(Exception):
    """A command took too long."""


def command(line):
    """Raises what the command refused, in its words; an odd command line is no refusal."""
    said = io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
        try:
            code = main(line)
        except SystemExit as stop:
            code = 0 if stop.code == 2 else 3
    if code:
        raise ValueError(said.getvalue().removeprefix("fsel: ").rstrip("\n"))


def outcome(work):
    """(kind, text): done, refused in words, or wrong."""
    started, peak = time.process_time(), Peak()
    previous = signal.signal(signal.SIGALRM, _hang)
    signal.alarm(20 * LONGEST)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            work()
        found = "done", ""
    except OSError as error:  # in the words of the commands
        said = f"{error.filename}: {error.strerror}" if error.strerror else str(error)
        found = "refused", with_options(said)
    except ValueError as error:
        found = "refused", with_options(str(error))
    except Exception as error:
        found = "wrong", f"{type(error).__name__}: {error}"
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, previous)
    if time.process_time() - started >= LONGEST:
        found = "wrong", "slow"
    if peak.bytes > MEMORY:
        found = "wrong", f"{peak.bytes / 1e9:.1f} GB of memory"
    return found


def _hang(number, frame):
    raise Hang(f"more than {20 * LONGEST} seconds")


def faults(outcomes, folder, alike):
    """What is wrong with the outcomes of several commands on one input, in words."""
    wrong = [f"{name}: {text}" for name, (kind, text) in outcomes.items() if kind == "wrong"]
    refused = {text for kind, text in outcomes.values() if kind == "refused"}
    wrong += [f"names no file: {text}" for text in refused if str(folder) not in text]
    wrong += [f"of several lines: {text}" for text in refused if "\n" in text]
    if alike and not wrong and not _alike(outcomes):
        wrong.append(f"not alike: {outcomes}")
    return wrong


def _alike(outcomes):
    """Whether all say the same, those left aside that refuse what is their own business."""
    shared = {found for found in outcomes.values() if not any(text in found[1] for text in OWN)}
    return len(shared) <= 1
