"""Page compare.html: held-out frames beside what each method's picks render, in one file."""

from __future__ import annotations

import json
from html import escape

import numpy as np

from fsel.core.wording import counted
from fsel.metrics import REGISTERED
from fsel.pages.compared import Cell, Compared, verdict
from fsel.pages.drawings import Line, legend, line_chart
from fsel.pages.shell import choices, document, source

NOTE = (
    "Intervals are Student's t over the held-out frames of this capture alone. Frames that "
    "resemble each other make them too narrow, and they say nothing about other captures. "
    "More PSNR and SSIM is better, and less GMSD or LPIPS."
)
HINT = (
    "Drag over a picture, or move the slider with the arrow keys: the held-out frame on the left, "
    "the rendering on the right, in all pictures alike. Differences are grey, twice as bright."
)


def comparison(compared: Compared) -> str:
    """The whole page."""
    held, drawn = len(compared.names), len(compared.shown)
    part = f" {drawn} of {held}, evenly spread, are shown." if drawn < held else ""
    body = [
        f"<h1>{escape(', '.join(compared.methods))}</h1>",
        f"<p>{escape(compared.source)}, {counted(held, 'held-out frame')}. "
        f"{escape(compared.how)}</p>",
        f"<p class='verdict'>{escape(verdict(compared))}</p>",
        *_table(compared),
        f"<p><small>{escape(NOTE)}</small></p>",
        *_curves(compared),
        "<h2>Held-out frames and renderings</h2>",
        f"<p>{HINT}{part}</p>",
        *_bar(compared),
        f'<div id="rows" style="--shape:{compared.shape:.4f}">',
        *(_row(compared, at) for at in range(drawn)),
        "</div>",
    ]
    title = f"Selections of {compared.source}"
    return document(title, ("compare.css", "compare.js"), body)


def _table(compared: Compared) -> list[str]:
    first = compared.methods[0]
    named = [REGISTERED[name] for name in compared.metrics]
    units = [f"{own.label} ({own.unit})" if own.unit else own.label for own in named]
    head = "".join(f"<th>{escape(text)}</th>" for text in ("K", "method", *units))
    lines = [f"<div class='wide'><table><thead><tr>{head}<th>{escape(first)} is ahead by</th>"]
    lines.append("</tr></thead><tbody>")
    for (used, name), budgets in compared.rows.items():
        cell = (budgets[0], name)
        means = zip(named, compared.means(cell), strict=True)
        values = [own.printed(mean) for own, mean in means]
        values[0] += _interval(compared, cell)
        gaps = [] if name == first else [_gap(compared, k, name, len(budgets)) for k in budgets]
        cells = [str(used), escape(name), *values, "<br>".join(gaps)]
        lines.append(f"<tr>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>")
    return [*lines, "</tbody></table></div>"]


def _interval(compared: Compared, cell: Cell) -> str:
    psnr = compared.interval(cell)
    return "" if np.isnan(psnr.low) else f" <small>({psnr.low:.2f} to {psnr.high:.2f})</small>"


def _gap(compared: Compared, k: int, other: str, rows: int) -> str:
    """The lead of the first method over another; of one that no k bounds, at which k."""
    gain, at = compared.ahead(k, other), f"K = {k}: " if rows > 1 else ""
    text = f"{at}{gain.mean:+.2f} dB"
    if np.isnan(gain.low):
        return text
    text += f" <small>({gain.low:+.2f} to {gain.high:+.2f})</small>"
    return f"<b>{text}</b>" if gain.excludes_zero else text


def _curves(compared: Compared) -> list[str]:
    """PSNR over the number of frames with its intervals, where several numbers were asked for."""
    if len(compared.budgets) < 2:
        return []
    lines = {}
    for method in compared.methods:
        at = [compared.interval((k, method)) for k in compared.budgets]
        mean, low, high = np.array([(found.mean, found.low, found.high) for found in at]).T
        lines[method] = Line(np.array(compared.budgets), mean, low, high)
    return [
        "<h2>PSNR over the number of frames</h2>",
        f"<figure>{line_chart(lines, 'frames picked', '.4g', 'PSNR against K')}"
        f"<figcaption>{legend(lines)}PSNR in dB, with 95 % intervals over the held-out frames."
        "</figcaption></figure>",
    ]


def _bar(compared: Compared) -> list[str]:
    """Choices of what is shown and in which order, for all pictures together."""
    first = escape(compared.methods[0])
    budgets = [(str(k), f"K = {k}") for k in compared.budgets]
    return [
        '<div class="bar">',
        *([choices("budget", "Frames picked", budgets)] if len(budgets) > 1 else []),
        choices("view", "Show", [("slider", "both"), ("difference", "difference")]),
        choices("order", "Order", [("time", "time"), ("worst", f"worst of {first} first")]),
        '<fieldset id="share" hidden><legend>Held-out frame</legend><input type="range" '
        'id="slider" min="0" max="100" step="any" value="50" aria-label="share of the held-out '
        'frame beside the renderings"></fieldset></div>',
    ]


def _row(compared: Compared, at: int) -> str:
    """A held-out frame and what every method renders of it."""
    frame = compared.shown[at]
    name = escape(compared.names[frame])
    unsharp = ", blurred" if compared.blurred[frame] else ""
    first = compared.methods[0]
    psnr = {k: round(float(compared.scores[k, first][frame, 0]), 4) for k in compared.budgets}
    named = [REGISTERED[name] for name in compared.metrics]
    cards = [
        f"<section class=\"versus\" data-psnr='{json.dumps(psnr)}'><h3>{name}{unsharp}</h3>"
        f'<div class="cards"><figure class="truth"><img alt="held-out frame {name}" '
        f'loading="lazy" src="{source(compared.truth[at])}">'
        f"<figcaption>held-out frame</figcaption></figure>"
    ]
    for (k, method), scores in compared.scores.items():
        values = ", ".join(
            f"{own.label} {own.printed(value)} {own.unit}".rstrip()
            for own, value in zip(named, scores[frame], strict=True)
        )
        label = f"{escape(method)}, K = {compared.used[k, method]}"
        cards.append(
            f'<figure class="card" data-k="{k}"><div class="pair"><img alt="{label} renders '
            f'{name}" loading="lazy" src="{source(compared.renders[k, method][at])}"></div>'
            f"<figcaption><b>{label}</b><br>{values}</figcaption></figure>"
        )
    return "".join([*cards, "</div></section>"])
