"""Page compare.html: held-out frames beside what each method's picks render, in one file."""

from __future__ import annotations

import base64
from html import escape
from importlib.resources import files

import numpy as np

from fsel.export.compared import Cell, Compared, differences
from fsel.utils.wording import counted

ROOM = files("fsel.export")
LABELS = {"psnr": "PSNR", "ssim": "SSIM", "gmsd": "GMSD", "lpips": "LPIPS"}
NOTE = (
    "Intervals are Student's t over the held-out frames of this capture alone. Frames that "
    "resemble each other make them too narrow, and they say nothing about other captures. "
    "More PSNR and SSIM is better, and less GMSD or LPIPS."
)


def comparison(compared: Compared) -> str:
    """The whole page."""
    style = "".join((ROOM / name).read_text(encoding="utf-8") for name in ("page.css", "pair.css"))
    script = (ROOM / "pair.js").read_text(encoding="utf-8")
    said = [escape(entry["verdict"]) for entry in differences(compared)]
    parts = [
        '<!doctype html><html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>Selections of {escape(compared.source)}</title>",
        f"<style>{style}</style></head><body>",
        f"<h1>{escape(', '.join(compared.methods))}</h1>",
        f"<p>{escape(compared.source)}, {counted(len(compared.names), 'held-out frame')}. "
        f"{escape(compared.how)}</p>",
        *(f"<p class='verdict'>{sentence}</p>" for sentence in said),
        *_table(compared),
        f"<p><small>{escape(NOTE)}</small></p>",
        "<h2>Held-out frames and renderings</h2>",
        "<p>Drag a slider, or use the arrow keys: the held-out frame on the left, the rendering on "
        "the right.</p>",
        *_budgets(compared),
        *(_row(compared, at) for at in range(len(compared.shown))),
        f"<script>{script}</script></body></html>",
    ]
    return "\n".join(parts)


def _table(compared: Compared) -> list[str]:
    first = compared.methods[0]
    labels = [LABELS.get(name, name) for name in compared.metrics]
    units = [f"{label} (dB)" if label == "PSNR" else label for label in labels]
    head = "".join(f"<th>{escape(text)}</th>" for text in ("K", "method", *units))
    lines = [f"<div class='wide'><table><thead><tr>{head}<th>{escape(first)} is ahead by</th>"]
    lines.append("</tr></thead><tbody>")
    for (k, name), scores in compared.scores.items():
        means = scores.mean(axis=0)
        cells = [str(compared.used[k, name]), escape(name), _with_interval(compared, (k, name))]
        cells += [f"{value:.4f}" for value in means[1:]]
        gap = "" if name == first else _gap(compared, k, name)
        lines.append(f"<tr>{''.join(f'<td>{cell}</td>' for cell in (*cells, gap))}</tr>")
    return [*lines, "</tbody></table></div>"]


def _with_interval(compared: Compared, cell: Cell) -> str:
    psnr = compared.interval(cell)
    if np.isnan(psnr.low):
        return f"{psnr.mean:.2f}"
    return f"{psnr.mean:.2f} <small>({psnr.low:.2f} to {psnr.high:.2f})</small>"


def _gap(compared: Compared, k: int, other: str) -> str:
    gain = compared.ahead(k, other)
    if np.isnan(gain.low):
        return f"{gain.mean:+.2f} dB"
    text = f"{gain.mean:+.2f} dB <small>({gain.low:+.2f} to {gain.high:+.2f})</small>"
    return f"<b>{text}</b>" if gain.excludes_zero else text


def _budgets(compared: Compared) -> list[str]:
    """One button for each number of frames; all are shown where no script runs."""
    if len(compared.budgets) < 2:
        return []
    buttons = [
        f'<label><input type="radio" name="k" value="{k}"{" checked" if not at else ""}> K = {k}'
        "</label>"
        for at, k in enumerate(compared.budgets)
    ]
    return ["<fieldset id='budgets' hidden><legend>Frames picked</legend>", *buttons, "</fieldset>"]


def _row(compared: Compared, at: int) -> str:
    """A held-out frame and what every method renders of it."""
    frame = compared.shown[at]
    name = escape(compared.names[frame])
    picture = _source(compared.truth[at])
    unsharp = ", blurred" if compared.blurred[frame] else ""
    cards = [
        f'<section class="versus"><h3>{name}</h3><div class="cards">'
        f'<figure><img class="truth" alt="held-out frame {name}" src="{picture}">'
        f"<figcaption>held-out frame{unsharp}</figcaption></figure>"
    ]
    for (k, method), scores in compared.scores.items():
        values = ", ".join(
            f"{LABELS.get(metric, metric)} {value:.2f} dB"
            if metric == "psnr"
            else f"{LABELS.get(metric, metric)} {value:.3f}"
            for metric, value in zip(compared.metrics, scores[frame], strict=True)
        )
        label = f"{escape(method)}, K = {compared.used[k, method]}"
        picture = _source(compared.renders[k, method][at])
        cards.append(
            f'<figure class="card" data-k="{k}"><div class="pair">'
            f'<img alt="{label} renders {name}" src="{picture}"></div>'
            f'<input type="range" min="0" max="100" value="50" hidden '
            f'aria-label="share of the held-out frame beside {label}">'
            f"<figcaption><b>{label}</b><br>{values}</figcaption></figure>"
        )
    return "".join([*cards, "</div></section>"])


def _source(picture: bytes) -> str:
    return f"data:image/jpeg;base64,{base64.b64encode(picture).decode('ascii')}"
