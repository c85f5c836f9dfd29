"""`fsel train`: the paper's selector, trained on captures of one's own."""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fsel.captures.images.previews import sharpness_of_files
from fsel.captures.lazy import LONG_SIDE, open_capture
from fsel.cli.console import Console
from fsel.cli.optimising import checked
from fsel.cli.posing import warn_of
from fsel.core.columns import by_row
from fsel.core.files import digest
from fsel.core.outputs import refuse_overlap
from fsel.core.registry import unknown
from fsel.core.wording import counted
from fsel.reconstruct import reconstructor_of
from fsel.selection import api
from fsel.selectors import pretrained
from fsel.selectors.policies import POLICIES, RENAMED, Policy
from fsel.selectors.scorer import Network

if TYPE_CHECKING:
    from fsel.training.imitation import Trajectory
    from fsel.training.journal import Journal
    from fsel.training.offline import Described, Labelling, Task

NEEDED = ("torch",)
MADE_BY = "fsel train: behaviour cloning"
RATE = 1e-3  # of Adam (paper, Appendix A.3)


def run(args: argparse.Namespace, console: Console) -> None:
    """Carry the command out."""
    policy = _checked(args)
    from fsel.training.journal import Journal
    from fsel.training.offline import Labelling, label, tasks

    labelling = Labelling(coverages=tuple(args.coverages), seed=args.seed)
    captures = [_described(args, console, path, labelling) for path in args.capture]
    problems = tasks(captures, labelling)
    key = _key(args, captures, labelling)
    trajectories: list[Trajectory] = []
    with Journal(args.out, key) as journal:
        _announce(console, problems, labelling, journal)
        started = time.perf_counter()
        for at, task in enumerate(problems, start=1):
            trajectories += label(task, labelling, policy, journal)
            left = (time.perf_counter() - started) / at * (len(problems) - at)
            what = f"{task.described.name} at {task.coverage} %, {at} of {len(problems)}"
            console.say("labelled", f"{what}; about {_in_words(left)} left")
        record = _train(args, console, trajectories, policy, key)
    console.say("written", f"{args.out}; fsel select --weights {args.out} uses it")
    console.give(record)


def _checked(args: argparse.Namespace) -> Policy:
    """The policy to train; what would fail after hours of work is refused."""
    if missing := [name for name in NEEDED if find_spec(name) is None]:
        raise ValueError(
            f"fsel train needs {', '.join(missing)}. Hint: pip install 'fsel[workflow]'"
        )
    trained = {name: policy for name, policy in POLICIES.items() if policy.kind is Network}
    if args.method not in trained:
        raise unknown("--method", args.method, trained, RENAMED)
    if args.out.suffix != ".safetensors":
        raise ValueError(f"{args.out}: a scorer is written as .safetensors")
    refuse_overlap(args.out, args.capture)
    if len({path.resolve() for path in args.capture}) < len(args.capture):
        raise ValueError(f"{args.capture[0]}: a capture is given twice; each counts once")
    checked(args)
    if args.out.exists():
        if not args.force:
            raise FileExistsError(f"{args.out}: exists already. Hint: --force replaces it")
        if not pretrained.own(args.out).scorer.provenance["made by"].startswith(MADE_BY):
            raise FileExistsError(f"{args.out}: --force replaces only what fsel train wrote")
    return trained[args.method]


def _described(
    args: argparse.Namespace, console: Console, path: Path, labelling: Labelling
) -> Described:
    """A capture with its descriptors, its sharpness and a reconstructor."""
    from fsel.training.offline import Described

    opened = open_capture(
        path, args.layout, LONG_SIDE, args.max_error, skip_unreadable=args.skip_unreadable
    )
    warn_of(opened.skipped, console)
    count = len(opened.capture)
    if count < labelling.frames_needed:
        raise ValueError(
            f"{path}: {counted(count, 'frame')}, at least {labelling.frames_needed} are needed: "
            f"targets, as many proxies, and {labelling.k} to select. Hint: more frames, or "
            "lower --coverages"
        )
    sharpness = sharpness_of_files(opened.raw.images, opened.longest, console.bar("sharpness"))
    capture = opened.loaded(np.arange(count), console.bar("images"))
    console.say("capture", f"{path}: {count} frames, {opened.layout}")
    named = {"name": args.reconstructor, "long_side": args.long_side, "settings": checked(args)}
    reconstructor = reconstructor_of(capture, named)
    return Described(str(path), capture, api.described(capture), sharpness, reconstructor)


def _key(args: argparse.Namespace, captures: Sequence[Described], labelling: Labelling) -> str:
    """Key of all that an evaluation depends on: with another one, searches start anew."""
    return digest(
        {
            "captures": {described.name: described.digest() for described in captures},
            "labelling": asdict(labelling),
            "reconstruction": [args.reconstructor, args.long_side, args.steps],
        }
    )


def _announce(
    console: Console, problems: Sequence[Task], labelling: Labelling, journal: Journal
) -> None:
    """Say beforehand how long it takes."""
    from fsel.training.offline import seconds_needed

    with console.clock("timing a few reconstructions"):
        seconds = seconds_needed(problems[0], labelling) * len(problems)
    share = max(0.0, 1 - journal.known / (len(problems) * labelling.evaluations))
    console.say(
        "labels",
        f"{counted(len(problems), 'problem')} of up to {labelling.evaluations} reconstructions: "
        f"about {_in_words(seconds * share)}, less where subsets share work",
    )
    if journal.known:
        console.say("resumed", f"after {journal.known} reconstructions of an earlier run")


def _in_words(seconds: float) -> str:
    return f"{seconds / 3600:.1f} hours" if seconds > 3600 else f"{seconds / 60:.0f} minutes"


def _train(
    args: argparse.Namespace,
    console: Console,
    trajectories: Sequence[Trajectory],
    policy: Policy,
    key: str,
) -> dict:
    """Imitate the labels and write the scorer."""
    from fsel.training import imitation
    from fsel.training.scorers import save_scorer

    settings = {"seed": args.seed, "epochs": args.epochs, "learning_rate": RATE}
    made = (
        f"{MADE_BY} of {counted(len(trajectories), 'searched subset')} of "
        f"{counted(len(args.capture), 'capture')}, {counted(args.epochs, 'epoch')}, "
        f"labels by {args.reconstructor} at {args.long_side} pixels"
    )
    with console.clock("training"):
        weights, log = imitation.train(trajectories, [], **settings)
    save_scorer(Network(weights), policy.name, made, args.seed, key, args.out)
    epochs = by_row({name: log[name] for name in ("epoch", "loss", "agreement")})
    first, last = epochs[0], epochs[-1]
    console.say(
        "trained",
        f"{policy.name}: loss {first['loss']:.2f} to {last['loss']:.2f} nats, agreement with the "
        f"labels {first['agreement']:.1%} to {last['agreement']:.1%}",
    )
    return {"out": str(args.out), "made by": made, "epochs": epochs}
