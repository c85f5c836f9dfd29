"""Scores of methods' picks on held-out frames, and compare.html, the page that shows them."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from html import escape

import numpy as np

from fsel.core.wording import counted
from fsel.evaluation.statistics import Interval, of_places
from fsel.metrics import REGISTERED
from fsel.pages.drawings import Line, legend, line_chart
from fsel.pages.shell import choices, document, source
from fsel.selection.request import ALL_FRAMES

LEAST = 3  # frames of an interval: of two it is thirteen times as wide as their difference
LEVEL = 0.005  # dB below which no lead is printed
LISTED = 3  # comparisons at most that have a line each

NOTE = (
    "Intervals are Student's t over the held-out frames of this capture. They are too narrow if "
    "frames resemble each other, and do not generalise to other captures. "
    "Higher PSNR and SSIM are better, lower GMSD and LPIPS; the best with as many frames is marked."
)
HINT = (
    "Drag over a picture, or move the slider with the arrow keys, to compare the held-out frame "
    "(left) with the rendering (right) in all pictures. Differences are shown in grey, doubled."
)

Cell = tuple[int, str]  # k as it was requested, and the method


@dataclass(frozen=True)
class Compared:
    """Scores of a comparison, and pictures of a few of its frames.

    Attributes:
        source, how: what was compared; the reconstructor and the size of the images, in words.
        names: T held-out frames.
        metrics: M names of metrics, PSNR first.
        scores: (T, M) for each k and method, averaged over seeds.
        used: number of frames that each reconstruction was made from.
        shown: numbers of the held-out frames that have pictures.
        truth, renders: JPEG of each of them; of each k and method, its first seed's renderings.
        blurred: (T,) bool, held-out frames that motion blurred, whose scores favour blur.
        shape: width of the pictures over their height.
        labels: of methods, what a person runs, where that is not `--method` with its name.
    """

    source: str
    how: str
    names: tuple[str, ...]
    metrics: tuple[str, ...]
    scores: dict[Cell, np.ndarray]
    used: dict[Cell, int]
    shown: tuple[int, ...]
    truth: list[bytes]
    renders: dict[Cell, list[bytes]]
    blurred: np.ndarray
    shape: float = 1.0
    labels: Mapping[str, str] = field(default_factory=dict)

    def label(self, method: str) -> str:
        """Return the name of a method for people."""
        return self.labels.get(method, method)

    @property
    def budgets(self) -> list[int]:
        """Budgets k, in order."""
        return list(dict.fromkeys(k for k, _ in self.scores))

    @property
    def methods(self) -> list[str]:
        """Methods in order; the first one is compared with the others."""
        return list(dict.fromkeys(name for _, name in self.scores))

    @property
    def rows(self) -> dict[Cell, list[int]]:
        """Frames used and method -> the budgets k of that row; every frame, one row, is last."""
        rows: dict[Cell, list[int]] = {}
        for k, name in self.scores:
            rows.setdefault((self.used[k, name], name), []).append(k)
        return dict(sorted(rows.items(), key=lambda row: row[0][1] == ALL_FRAMES))

    def means(self, cell: Cell) -> list[float]:
        """Mean of each metric, over held-out frames."""
        return self.scores[cell].mean(axis=0).round(5).tolist()

    def is_best(self, cell: Cell, at: int) -> bool:
        """Return whether no other method with as many frames has a better mean of a metric."""
        sign = 1 if REGISTERED[self.metrics[at]].higher_is_better else -1
        others = [self.means((cell[0], name))[at] for name in self.methods]
        return len(others) > 1 and sign * self.means(cell)[at] == max(sign * v for v in others)

    @property
    def pairs(self) -> list[Cell]:
        """Each k and method that the first one is compared with."""
        return [(k, name) for k, name in self.scores if name != self.methods[0]]

    def interval(self, cell: Cell) -> Interval:
        """Return the interval of mean PSNR, over held-out frames."""
        return _interval(self.scores[cell][:, 0])

    def ahead(self, k: int, other: str) -> Interval:
        """Interval of the PSNR by which the first method is ahead, over held-out frames."""
        return _interval(self._gaps(k, other))

    def ahead_on_sharp(self, k: int, other: str) -> Interval | None:
        """The same on the frames that are not blurred; None unless some are, and enough are not."""
        if not self.blurred.any() or (~self.blurred).sum() < LEAST:
            return None
        return _interval(self._gaps(k, other)[~self.blurred])

    def _gaps(self, k: int, other: str) -> np.ndarray:
        return self.scores[k, self.methods[0]][:, 0] - self.scores[k, other][:, 0]


def differences(compared: Compared) -> list[dict]:
    """Return the rows of k, method (the first), than (another), psnr in dB, ci_low, ci_high, n, and
    `sharp`, the same of frames that are not blurred, where some are."""
    entries = []
    for k, other in compared.pairs:
        sharp = compared.ahead_on_sharp(k, other)
        entry = {"k": k, "method": compared.methods[0], "than": other}
        entry |= _numbers(compared.ahead(k, other))
        entries.append(entry if sharp is None else entry | {"sharp": _numbers(sharp)})
    return entries


def _interval(values: np.ndarray) -> Interval:
    """Return the interval of a mean without bounds where they would say nothing."""
    found = of_places(values)
    return found if len(values) >= LEAST else found._replace(low=np.nan, high=np.nan)


def _numbers(gap: Interval) -> dict:
    low, high = (None if np.isnan(end) else round(end, 5) for end in (gap.low, gap.high))
    return {"psnr": round(gap.mean, 5), "ci_low": low, "ci_high": high, "n": gap.n}


def verdict(compared: Compared) -> str:
    """Say in a sentence by how much the first method is ahead of others, or how often."""
    pairs, first = compared.pairs, compared.label(compared.methods[0])
    if not pairs:
        return f"{first} has no other method to compare with."
    gaps = [compared.ahead(k, other) for k, other in pairs]
    frames = counted(gaps[0].n, "held-out frame")
    if gaps[0].n < LEAST:
        ahead = sum(gap.mean > 0 for gap in gaps)
        few = f"over {frames}: too few for an interval"
        return f"{first} is ahead in {ahead} of {counted(len(gaps), 'comparison')}, {few}."
    said = f"{first} is {_found(compared, gaps)} (95 % intervals over {frames})"
    sharp = [compared.ahead_on_sharp(k, other) for k, other in pairs]
    kept = [gap for gap in sharp if gap is not None]
    if not kept:
        return f"{said}."
    return f"{said}; over the {kept[0].n} sharp ones, {_found(compared, kept)}."


def _found(compared: Compared, gaps: Sequence[Interval]) -> str:
    """Return the lead over each other method with its interval; of many, how often it is one."""
    if len(gaps) <= LISTED:
        leads = zip(compared.pairs, gaps, strict=True)
        return ", ".join(_lead(compared, k, other, gap) for (k, other), gap in leads)
    ahead, behind = sum(gap.low > 0 for gap in gaps), sum(gap.high < 0 for gap in gaps)
    if not ahead and not behind:
        return "neither significantly better nor worse than any other"
    return f"significantly better in {ahead} and worse in {behind} of {len(gaps)} comparisons"


def _lead(compared: Compared, k: int, other: str, gap: Interval) -> str:
    sign, side = (1, "ahead of") if gap.mean >= 0 else (-1, "behind")
    low, high = sorted((sign * gap.low, sign * gap.high))
    at = f" at K = {k}" if len(compared.budgets) > 1 else ""
    lead = f"{abs(gap.mean):.2f} dB {side}" if abs(gap.mean) >= LEVEL else "level with"
    return f"{lead} {compared.label(other)}{at} ({low:+.2f} to {high:+.2f})"


def comparison(compared: Compared) -> str:
    """Return the whole page."""
    total, drawn = len(compared.names), len(compared.shown)
    part = f" {drawn} of {total}, evenly spread, are shown." if drawn < total else ""
    names = ", ".join(map(compared.label, compared.methods))
    body = [
        f"<h1>Which frames render held-out views best: {escape(names)}</h1>",
        f"<p>{escape(compared.source)}, {counted(total, 'held-out frame')}. "
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
    titles = ("K", "method", *units, f"{compared.label(first)} is ahead by")
    head = "".join(f"<th>{escape(text)}</th>" for text in titles)
    lines = [f"<div class='wide'><table><thead><tr>{head}</tr></thead><tbody>"]
    for (used, name), budgets in compared.rows.items():
        cell = (budgets[0], name)
        values = [own.printed(mean) for own, mean in zip(named, compared.means(cell), strict=True)]
        for at in filter(partial(compared.is_best, cell), range(len(named))):
            values[at] = f"<mark>{values[at]}</mark>"
        psnr = compared.interval(cell)
        if np.isfinite(psnr.low):
            values[0] += f" <small>({psnr.low:.2f} to {psnr.high:.2f})</small>"
        gaps = [] if name == first else [_gap(compared, k, name, len(budgets)) for k in budgets]
        cells = [str(used), escape(compared.label(name)), *values, "<br>".join(gaps)]
        lines.append(f"<tr>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>")
    return [*lines, "</tbody></table></div>"]


def _gap(compared: Compared, k: int, other: str, rows: int) -> str:
    """Return the lead of the first method over another; where no k bounds it, at which k."""
    gain, at = compared.ahead(k, other), f"K = {k}: " if rows > 1 else ""
    text = f"{at}{gain.mean:+.2f} dB"
    if np.isnan(gain.low):
        return text
    text += f" <small>({gain.low:+.2f} to {gain.high:+.2f})</small>"
    return f"<b>{text}</b>" if gain.excludes_zero else text


def _curves(compared: Compared) -> list[str]:
    """Return the chart of PSNR over the number of frames, where there are several numbers."""
    if len(compared.budgets) < 2:
        return []
    lines = {}
    for method in compared.methods:
        at = [compared.interval((k, method)) for k in compared.budgets]
        mean, low, high = np.array([(found.mean, found.low, found.high) for found in at]).T
        lines[compared.label(method)] = Line(np.array(compared.budgets), mean, low, high)
    return [
        "<h2>PSNR over the number of frames</h2>",
        f"<figure>{line_chart(lines, 'frames picked', '.4g', 'PSNR against K')}"
        f"<figcaption>{legend(lines)}PSNR in dB, with 95 % intervals over the held-out frames."
        "</figcaption></figure>",
    ]


def _bar(compared: Compared) -> list[str]:
    """Return the choices of what is shown and in which order, for all pictures together."""
    first = escape(compared.label(compared.methods[0]))
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
    """Return a held-out frame and what every method renders of it."""
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
        label = f"{escape(compared.label(method))}, K = {compared.used[k, method]}"
        cards.append(
            f'<figure class="card" data-k="{k}"><div class="pair"><img alt="{label} renders '
            f'{name}" loading="lazy" src="{source(compared.renders[k, method][at])}"></div>'
            f"<figcaption><b>{label}</b><br>{values}</figcaption></figure>"
        )
    return "".join([*cards, "</div></section>"])
