"""Page report.html: a selection to look at, in one file that needs no other."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape
from importlib.resources import files

from fsel.data.points import SparsePoints
from fsel.export.drawings import SHOWN, service_chart, sharpness_chart, shown, top_view
from fsel.export.record import Outcome, covered, reason, trials
from fsel.export.scene import turning_view
from fsel.request.targets import ALL
from fsel.utils.wording import counted

STYLE = files("fsel.export") / "page.css"
NOTE = (
    "A frame is left out where others were better by the method, which need not weigh service "
    "alone: one that would add more of it than a pick did may be among them."
)


def page(
    outcome: Outcome,
    picked: Sequence[dict],
    left: Sequence[dict],
    pictures: Sequence[bytes],
    points: SparsePoints | None = None,
) -> str:
    """The whole page.

    Args:
        outcome: the selection.
        picked: see `fsel.export.record.picked`.
        left: see `fsel.export.record.left`.
        pictures: JPEG files of the picks, in pick order; none where no image was opened.
        points: sparse points of the scene, where there are any.
    """
    name = escape(outcome.capture.source)
    budget, tried = outcome.selection.budget, outcome.selection.tried
    cover = outcome.selection.cover
    parts = [
        '<!doctype html><html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{counted(len(picked), 'frame')} of {name}</title>",
        f"<style>{STYLE.read_text(encoding='utf-8')}</style></head><body>",
        f"<h1>{len(picked)} of {len(outcome.capture)} frames</h1>",
        f"<p>{name}. To be rendered: {escape(outcome.targets.kind)}, "
        f"{counted(len(outcome.targets.views), 'view')}.</p>",
        *([] if budget is None else [f"<p>{escape(reason(budget))}.</p>"]),
        *([] if tried is None else [f"<p>Tried {escape(trials(tried))}.</p>"]),
        *([] if cover is None else [f"<p>{escape(covered(cover))}.</p>"]),
        *_figures(outcome, points),
        "<h2>Picks, in order</h2>",
        '<ol class="sheet">',
        *_cards(picked, pictures),
        "</ol><h2>Frames left out, and why</h2>",
        f"<p>{NOTE}</p>",
        *_thinned(len(left)),
        "<table><thead><tr><th>frame</th><th>reason</th></tr></thead><tbody>",
        *(_row(left[at]) for at in shown(len(left))),
        "</tbody></table></body></html>",
    ]
    return "\n".join(parts)


def _figures(outcome: Outcome, points: SparsePoints | None) -> list[str]:
    """Cameras in space and from above, the service, the sharpness."""
    curve = outcome.service.curve
    return [
        f"<figure>{turning_view(outcome, points)}<figcaption>Drag to turn, shift and drag to move, "
        "scroll or pinch to zoom; or use the arrow keys, + and -.</figcaption></figure>",
        '<div class="row">',
        f"<figure>{top_view(outcome)}<figcaption>{_legend(outcome)}</figcaption></figure>",
        f"<figure>{service_chart(curve)}"
        f"<figcaption>{_served(outcome)}: {curve[-1]:.1%}; all frames together give "
        "100%.</figcaption></figure></div>",
        *_timeline(outcome),
    ]


def _timeline(outcome: Outcome) -> list[str]:
    """The sharpness of every frame, where it was measured."""
    if outcome.sharpness is None:
        return []
    drawing = sharpness_chart(outcome.sharpness, outcome.selection.indices)
    return [
        f"<h2>Sharpness</h2><figure>{drawing}<figcaption>Every frame's sharpness as a share of the "
        "sharpest one's, in the order of their names; picks in orange.</figcaption></figure>"
    ]


def _served(outcome: Outcome) -> str:
    """Views that service is measured at: without stated ones, frames of the capture."""
    if outcome.targets.kind != ALL:
        return "Service of the target views"
    return f"Service of the whole capture, at {len(outcome.served)} of its frames"


def _legend(outcome: Outcome) -> str:
    far = int(outcome.targets.far.sum())
    note = f" {counted(far, 'target')} too far away to be drawn." if far else ""
    if max(len(outcome.capture), len(outcome.targets.views)) > SHOWN:
        note += f" At most {SHOWN:,} of each are drawn."
    return (
        'From above: <span class="key pick">picks in order</span>, <span class="key target">target '
        f'views</span>, <span class="key frame">other frames</span>.{note}'
    )


def _cards(picked: Sequence[dict], pictures: Sequence[bytes]) -> list[str]:
    cards = []
    for at, entry in enumerate(picked):
        name, image = escape(entry["name"]), ""
        if pictures:
            data = base64.b64encode(pictures[at]).decode("ascii")
            image = f'<img alt="{name}" src="data:image/jpeg;base64,{data}">'
        facts = [f"adds {entry['adds']:.1%}"]
        if entry["sharpness_rank"] is not None:
            facts.append(f"sharpness rank {entry['sharpness_rank']}")
        if entry.get("blurred"):
            facts.append('<span class="badge">blurred</span>')
        cards.append(
            f"<li>{image}<b>{entry['order']}</b> {name}<br><small>{', '.join(facts)}</small></li>"
        )
    return cards


def _thinned(count: int) -> list[str]:
    if count <= SHOWN:
        return []
    return [f"<p>{SHOWN:,} of {count:,}, evenly spread; selection.json has all.</p>"]


def _row(entry: dict) -> str:
    return f"<tr><td>{escape(entry['name'])}</td><td>{escape(entry['reason'])}</td></tr>"
