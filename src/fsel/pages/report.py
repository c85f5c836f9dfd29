"""Page report.html: every frame of a capture and what a selection makes of it, in one file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import astuple
from html import escape

import cv2
import numpy as np

from fsel.captures.images.previews import MOST_SHOWN
from fsel.core.geometry import viewing_angles
from fsel.core.subsets import evenly
from fsel.core.wording import counted
from fsel.features.conditioned import look_depth
from fsel.pages.drawings import Line, line_chart, timeline
from fsel.pages.shell import choices, data, document, source
from fsel.pages.shown import Card, ReportContent, adds, cards_of, frames_shown, scene_data
from fsel.selection.budget import Budget
from fsel.selection.export.record import closeness, reason, summary, trials
from fsel.selection.outcome import Outcome
from fsel.selection.validation import ValidationResult

TICKS = 6  # times below the timeline of a video
CELL = 84  # pixels of a frame's place on the page, were it square
NOTE = "A point is seen well if two picks see it, which fixes its depth."

REPORT = "report.html"
KINDS = {"all": "all", "pick": "picks", "left": "left out", "held": "held out", "bad": "bad"}
KINDS |= {"keep": "kept by you", "drop": "dropped by you"}
WORLD, END = '<figure class="world" id="world">', "</figure>"
FLYING = (
    "<script>window.mountView = (element, data, chosen) => view.beside(data.names, chosen);"
    "</script><figcaption>Click a camera to fly to it and its photo; drag to turn, shift and drag "
    "to move, scroll or pinch to zoom.</figcaption>"
)
DETAIL = (
    '<aside id="detail"><img id="picture" alt="" hidden><h3 id="name">No frame chosen</h3>'
    '<p id="why">Click a camera, a frame or the timeline.</p><p id="faults"></p>'
    '<p><button id="keep" disabled>Keep <kbd>k</kbd></button> '
    '<button id="drop" disabled>Drop <kbd>d</kbd></button></p>'
    '<section id="wishes" hidden><p id="marked"></p><div id="changes"><pre id="command"></pre>'
    '<button id="copy">Copy</button> <button id="clear">Clear</button><p><small>Run this where the '
    "selection was made. A kept frame, or else the nearest free one, replaces a dropped pick; all "
    "other picks stay.</small></p></div></section></aside>"
)


def page(shown: ReportContent) -> str:
    """Return the whole page."""
    outcome, cards = shown.outcome, cards_of(shown)
    selection, source_name = outcome.selection, outcome.capture.source
    sentences = [
        f"{source_name}. Views to render: {outcome.targets.kind}, "
        f"{counted(len(outcome.targets.views), 'view')}. {closeness(outcome)}."
    ]
    sentences += [] if selection.budget is None else [f"{reason(selection.budget)}."]
    heading = f"{len(shown.picked)} of {len(outcome.capture)} frames"
    body = [
        f"<h1>{heading}</h1>",
        f'<p class="lead">{escape(summary(outcome))}</p>',
        *(f"<p>{escape(sentence)}</p>" for sentence in sentences),
        *(f'<p class="warning">{escape(note)}.</p>' for note in shown.notes),
        *_gap(shown),
        *_tried(selection.tried),
        '<div class="stage"><div>',
        *_world(outcome, shown.commands.viewing),
        *_over_time(outcome, frames_shown(outcome), shown.pictures, shown.times),
        *_strip(shown, cards),
        *_how_many(selection.budget),
        *_tables(shown),
        "</div>",
        DETAIL,
        "</div>",
        data("data", _content(shown, cards)),
    ]
    return document(f"{heading}: {source_name}", ("report.css", "scene.js", "report.js"), body)


def _gap(shown: ReportContent) -> list[str]:
    """Return a wide gap between the picks in words, with the picture of a frame in it."""
    gap = shown.outcome.gap
    if gap is None or not gap.wide:
        return []
    picture = shown.pictures.get(gap.frame)
    image = f'<br><img alt="{escape(gap.name)}" src="{source(picture)}">' if picture else ""
    return [f'<p class="warning">{escape(str(gap))}.{image}</p>']


def with_view(text: str, view: str) -> str:
    """Return a report with a `fsel.pages.viewer.component` in the place of its drawing."""
    before, found, rest = text.partition(WORLD)
    _, end, after = rest.partition(END)
    if not (found and end) or WORLD in after:
        raise ValueError("is no report of this version of fsel. Hint: select again")
    return f"{before}{WORLD}{view}{FLYING}{END}{after}"


def _tried(tried: ValidationResult | None) -> list[str]:
    """Return what was tried and the rule that decided, to be unfolded."""
    if tried is None:
        return []
    first = "the rule" if tried.on_targets else "uniform sampling"
    sure = " beyond chance, by two reconstructors that agree" if tried.rule.sure else ""
    margin = f"if it is {tried.rule.margin} dB ahead{sure}"
    said = f"{trials(tried)}. A selection replaces {first} {margin}."
    return ["<details><summary>What was tried</summary>", f"<p>{escape(said)}</p></details>"]


def _world(outcome: Outcome, viewing: str) -> list[str]:
    far = int(outcome.targets.far.sum())
    note = f" {counted(far, 'target')} too far away to draw." if far else ""
    if len(outcome.capture) > MOST_SHOWN:
        note += f" {MOST_SHOWN:,} of {len(outcome.capture):,} frames, evenly spread, and the picks."
    known = len(outcome.targets.frames) > 0
    bad = '<span class="key bad">bad frames</span>, ' if len(outcome.targets.bad) else ""
    views = ("held", "held-out frames") if known else ("target", "target views")
    return [
        f'{WORLD}<button class="above">From above</button><figcaption>'
        '<span class="key pick">picks in order</span>, '
        f'<span class="key {views[0]}">{views[1]}</span>, '
        f'{bad}<span class="key">other frames</span>. '
        "Click a camera to see its frame; drag to turn, shift and drag to move, scroll or pinch to "
        f"zoom.{note} To fly to a camera and its photo: <code>{escape(viewing)}</code>"
        f"</figcaption>{END}"
    ]


def _over_time(
    outcome: Outcome, frames: np.ndarray, pictures: Mapping[int, bytes], times: Mapping[str, float]
) -> list[str]:
    """Draw the timeline of (n,) frames; their JPEGs, where there are any, tell the exposure."""
    rows = {"speed of the camera (degrees a frame)": speeds(outcome)[frames]}
    if outcome.sharpness is not None:
        rows["sharpness"] = np.asarray(outcome.sharpness)[frames]
    if pictures:
        rows["exposure (mean grey level, %)"] = brightness(pictures, len(outcome.capture))[frames]
    targets = outcome.targets
    kinds = {"held": targets.frames, "pick": outcome.selection.indices, "bad": targets.bad}
    marks = {kind: np.flatnonzero(np.isin(frames, of)).tolist() for kind, of in kinds.items()}
    labels = "".join(
        f'<span style="top:{100 * at / len(rows):.1f}%">{escape(name)}: up to '
        f"{np.nanmax(values, initial=0):.3g}</span>"
        for at, (name, values) in enumerate(rows.items())
    )
    names = [outcome.capture.names[frames[at]] for at in evenly(len(frames), TICKS)]
    seconds = "".join(f"<span>{times[name]:.1f} s</span>" for name in names if name in times)
    return [
        "<h2>Over time</h2>",
        f'<figure><div class="lanes">{timeline(rows, marks)}{labels}</div>'
        f'<div class="times">{seconds}</div><figcaption>Frames in '
        "the order of their names; picks in orange, held-out frames in blue, bad ones in dashed "
        "red. Click to see a frame.</figcaption></figure>",
    ]


def speeds(outcome: Outcome) -> np.ndarray:
    """Return (N,) degrees that the view moved since the frame before; NaN at a sequence's first.

    The turn of the optical axis, and the angle of the centre's way at the depth of the scene.
    """
    capture = outcome.capture
    way = np.linalg.norm(np.diff(capture.centers, axis=0), axis=1)
    turn = viewing_angles(capture.axes[1:], capture.axes[:-1])
    moved = np.degrees(turn + np.arctan(way / look_depth(capture.centers)))
    label = np.array(capture.sequences)
    return np.concatenate([[np.nan], np.where(label[1:] == label[:-1], moved, np.nan)])


def brightness(pictures: Mapping[int, bytes], count: int) -> np.ndarray:
    """Return (N,) mean grey level of each picture in per cent, NaN without one."""
    out = np.full(count, np.nan)
    for frame, jpeg in pictures.items():
        reduced = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_REDUCED_GRAYSCALE_4)
        out[frame] = np.asarray(reduced).mean() / 2.55
    return out


def _strip(shown: ReportContent, cards: Sequence[Card]) -> list[str]:
    """Return every frame as a picture that can be chosen, in the order of the capture."""
    width, height = shown.outcome.capture.size
    wide, high = CELL * np.sqrt([width / height, height / width])
    there = {"all", "keep", "drop", *(card.kind for card in cards)}
    options = [(kind, text) for kind, text in KINDS.items() if kind in there]
    parts = [
        "<h2>Every frame</h2>",
        choices("filter", "Show", options),
        "<p><small>Click a frame, or go from one to the next with <kbd>←</kbd> and <kbd>→</kbd>; "
        "<kbd>k</kbd> keeps it, <kbd>d</kbd> drops it. Picks are orange, numbered in their order; "
        "held-out frames blue; bad ones red; ! marks a fault.</small></p>",
        f'<div class="frames" style="--wide:{wide:.0f}px;--high:{high:.0f}px">',
    ]
    for card in cards:
        inside, name = escape(card.name), escape(card.name)
        if card.frame in shown.pictures:
            address = source(shown.pictures[card.frame])
            inside = f'<img loading="lazy" decoding="async" alt="{name}" src="{address}">'
        order = f"<i>{card.order}</i>" if card.order else ""
        order += "<em>!</em>" if card.faults else ""
        parts.append(
            f'<button class="frame {card.kind}" title="{name}: '
            f'{escape(card.text)} {escape(card.faults)}">{inside}'
            f"{order}</button>"
        )
    return [*parts, "</div>"]


def _how_many(budget: Budget | None) -> list[str]:
    """Draw what numbers of frames lose against all, with the interval, where one was found."""
    if budget is None or not budget.table.rows:
        return []
    values = np.array([astuple(row) for row in budget.table.rows]).T
    chart = line_chart({"PSNR": Line(*values[:4])}, "frames", "+.1f", "PSNR against all frames")
    said = f"PSNR (dB) against all {budget.table.total} frames, with its 90 % interval."
    return [
        "<h2>How many frames are needed</h2>",
        f"<figure>{chart}<figcaption>{said}</figcaption></figure>",
    ]


def _tables(shown: ReportContent) -> list[str]:
    """Return the picks in order, and every frame left out, in words."""
    rows = evenly(len(shown.left), MOST_SHOWN)
    thinned = len(shown.left) > MOST_SHOWN
    note = f"{MOST_SHOWN:,} of {len(shown.left):,}, evenly spread; selection.json has all."
    points = any(entry["sees_new"] is not None for entry in shown.picked)
    return [
        "<details open><summary>Picks, in order</summary>",
        *([f"<p><small>{NOTE}</small></p>"] if points else []),
        "<table><thead><tr><th></th><th>frame</th><th>what it adds</th></tr></thead>"
        '<tbody id="picked">',
        *(
            f"<tr><td>{entry['order']}</td><td>{escape(entry['name'])}</td>"
            f"<td>{escape(adds(entry))}</td></tr>"
            for entry in shown.picked
        ),
        "</tbody></table></details>",
        "<details><summary>Frames left out, and why</summary>",
        *([f"<p>{note}</p>"] if thinned else []),
        '<table><thead><tr><th>frame</th><th>reason</th></tr></thead><tbody id="left">',
        *(
            f"<tr><td>{escape(entry['name'])}</td><td>{escape(entry['reason'])}</td></tr>"
            for entry in (shown.left[at] for at in rows)
        ),
        "</tbody></table></details>",
    ]


def _content(shown: ReportContent, cards: Sequence[Card]) -> dict:
    """Return the content that the page's scripts read."""
    outcome, targets = shown.outcome, shown.outcome.targets
    never = set(targets.never.tolist())
    frames = np.array([card.frame for card in cards])
    return {
        **scene_data(outcome, frames, outcome.seen),
        "editing": shown.commands.editing,
        "list": shown.commands.picks,
        "names": [card.name for card in cards],
        "kinds": [card.kind for card in cards],
        "orders": [card.order for card in cards],
        "texts": [card.text for card in cards],
        "faults": [card.faults for card in cards],
        "marks": ["drop" if card.frame in never else None for card in cards],
        "k": len(shown.picked),
    }
