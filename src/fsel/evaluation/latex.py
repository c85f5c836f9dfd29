"""LaTeX tables, such as the paper's of the budget sweep (Appendix E.1), and what captions tell.

The document needs `booktabs` and `graphicx`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from fsel.evaluation.summary import ALL_FRAMES
from fsel.metrics import REGISTERED

MISSING = "--"
STAND_IN = "GMSD in the place of LPIPS, whose weights could not be fetched"
BLOCKS = 3  # of two datasets each, on a page
APART = r"\setlength{\belowcaptionskip}{4pt}"  # a table follows its caption; LaTeX leaves no room
# to the page where it is wider, never enlarged
SHRUNK = r"\resizebox{\ifdim\width>\textwidth\textwidth\else\width\fi}{!}{%"


def tex(text: str) -> str:
    """Escape LaTeX's special characters in plain text."""
    return re.sub(r"([&%$#_{}])", r"\\\1", text)


def number(value: float, metric: str) -> str:
    """Format a metric's value; without a unit, as in the paper, no leading zero."""
    own = REGISTERED[metric]
    text = own.printed(value)
    return text if own.unit else text.replace("0.", ".", 1)


def bold_if(leads: bool, text: str) -> str:
    """Set text in bold where it leads."""
    return rf"\textbf{{{text}}}" if leads else text


def difference(value: float, low: float, high: float) -> str:
    """Format a difference in dB with its 95% interval, bold where that excludes zero; NaN bounds
    are not printed, and a NaN difference is empty."""
    if np.isnan(value):
        return ""
    sure = low > 0 or high < 0
    text = rf"$\mathbf{{{value:+.2f}}}$" if sure else f"${value:+.2f}$"
    if np.isnan(low):
        return text
    return rf"{text} {{\tiny$[{low:+.2f},{high:+.2f}]$}}"


def sweep_table(
    summary: pd.DataFrame,
    *,
    datasets: Mapping[str, str],
    groups: Sequence[Mapping[str, str]],
    ranked: Sequence[str],
    budgets: Sequence[int],
    higher_is_better: Mapping[str, bool],
    caption: str,
    label: str,
) -> str:
    """Set two datasets (name -> LaTeX label) side by side, one row a method (label by name, in
    groups that a rule sets apart), one cell a budget, the best of a column of the `ranked` in
    bold."""
    keyed = summary.set_index(["dataset", "method", "k", "metric"])
    scenes = summary.groupby("dataset")["n"].max().to_dict()
    sheet = _Sheet(keyed["mean"].to_dict(), scenes, budgets, higher_is_better, ranked)
    sheet.ended = keyed["outcome"].to_dict() if "outcome" in keyed else {}
    titles = list(datasets.items())
    blocks = [sheet.block(dict(titles[i : i + 2]), groups) for i in range(0, len(titles), 2)]
    pages = [blocks[i : i + BLOCKS] for i in range(0, len(blocks), BLOCKS)]
    heads = [[rf"\caption{{{caption}}}", rf"\label{{{label}}}"]]
    heads += [[rf"\caption{{Table~\ref{{{label}}}, continued.}}"] for _ in pages[1:]]
    return "\n".join(map(_page, pages, heads))


def _page(blocks: Sequence[str], head: Sequence[str]) -> str:
    """Stack blocks, as many as a page holds."""
    begin = [r"\begin{table*}[t]", r"\centering", APART, *head]
    begin += [r"\scriptsize", r"\setlength{\tabcolsep}{2.5pt}"]
    return "\n".join([*begin, "\n\\vspace{6pt}\n\n".join(blocks), r"\end{table*}", ""])


def plain_table(
    header: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    caption: str,
    label: str,
    columns: str | None = None,
    groups: Sequence[tuple[str, int]] = (),
) -> str:
    """Write a table of ready cells in LaTeX; `columns` are LaTeX's, by default the first to the
    left, and `groups` headings over the columns after it, with how many each spans."""
    over = "".join(rf" & \multicolumn{{{width}}}{{c}}{{{title}}}" for title, width in groups)
    lines = [
        r"\begin{table}[t]",
        r"\centering",
        APART,
        rf"\caption{{{caption}}}",
        rf"\label{{{label}}}",
        r"\scriptsize",
        SHRUNK,
        rf"\begin{{tabular}}{{{columns or 'l' + 'r' * (len(header) - 1)}}}",
        r"\toprule",
        *([over + r" \\"] if groups else []),
        " & ".join(header) + r" \\",
        r"\midrule",
        *(" & ".join(row) + r" \\" for row in rows),
        r"\bottomrule",
        r"\end{tabular}}",
        r"\end{table}",
        "",
    ]
    return "\n".join(lines)


class _Sheet:
    """Formats cells of one summary."""

    def __init__(self, means, scenes, budgets, higher_is_better, ranked) -> None:
        self.means, self.scenes, self.budgets = means, scenes, budgets
        self.higher_is_better, self.ranked = higher_is_better, ranked
        self.ended: Mapping[tuple, str] = {}  # dataset, method, budget, metric -> outcome

    def block(self, datasets: Mapping[str, str], groups: Sequence[Mapping[str, str]]) -> str:
        """Write one tabular: the given datasets side by side."""
        width = len(self.budgets)
        heads, rules = [], []
        for i, (name, title) in enumerate(datasets.items()):
            head = rf"\textbf{{{title}}} ($n{{=}}{self.scenes[name]}$)"
            heads.append(rf"& \multicolumn{{{width}}}{{c}}{{{head}}}")
            rules.append(rf"\cmidrule(lr){{{2 + i * width}-{1 + (i + 1) * width}}}")
        budgets = " ".join(f"& $K{{=}}{k}$" for k in self.budgets)
        lines = [
            SHRUNK,
            rf"\begin{{tabular}}{{l{'|'.join(['c' * width] * len(datasets))}}}",
            r"\toprule",
            " ".join(heads) + r" \\",
            " ".join(rules),
            f"Selection {' '.join([budgets] * len(datasets))} \\\\",
        ]
        known = {method for dataset, method, *_ in self.means if dataset in datasets}
        for group in groups:
            rows = [self.row(datasets, m, title) for m, title in group.items() if m in known]
            lines += [r"\midrule", *rows] if rows else []
        return "\n".join([*lines, r"\bottomrule", r"\end{tabular}}"])

    def row(self, datasets: Mapping[str, str], method: str, title: str) -> str:
        """Write a method's row; one wide cell where it takes every frame."""
        parts = [title]
        last = list(datasets)[-1]
        for dataset in datasets:
            if (dataset, method, ALL_FRAMES, "psnr") in self.means:
                cell = self.cell(dataset, method, ALL_FRAMES)
                form = "c" if dataset == last else "c|"
                parts.append(rf"\multicolumn{{{len(self.budgets)}}}{{{form}}}{{{cell}}}")
            else:
                parts += [self.cell(dataset, method, k) for k in self.budgets]
        return " & ".join(parts) + r" \\"

    def cell(self, dataset: str, method: str, k: int) -> str:
        """Write all metrics of a cell, those that lead their column in bold."""
        if (dataset, method, k, "psnr") not in self.means:
            return MISSING
        if ended := self.ended.get((dataset, method, k, "psnr")):
            return rf"\textit{{{ended}}}"
        texts = []
        for metric in self.higher_is_better:
            text = number(self.means[dataset, method, k, metric], metric)
            leads = method in self.ranked and text == self.best(dataset, k, metric)
            texts.append(bold_if(leads, text))
        return "/".join(texts)

    def best(self, dataset: str, k: int, metric: str) -> str | None:
        """Return the leading number of a column as printed, so that equal prints share the lead."""
        column = [self.means.get((dataset, method, k, metric), np.nan) for method in self.ranked]
        values = [value for value in column if np.isfinite(value)]
        best = max if self.higher_is_better[metric] else min
        return number(best(values), metric) if values else None


def captures_of(facts: Mapping) -> str:
    """Say where the captures come from, in LaTeX: `facts` has embedded, real and missing labels of
    datasets, and without_lpips; the last two may lack."""
    captures = []
    if facts["embedded"]:
        names = tex(", ".join(facts["embedded"]))
        captures.append(
            f"generated stand-ins that imitate how each corpus is filmed ({names}), "
            "not the corpora themselves"
        )
    if facts["real"]:
        captures.append(f"read from disk ({tex(', '.join(facts['real']))})")
    if facts.get("missing"):
        captures.append(f"missing, since not on disk: {tex(', '.join(facts['missing']))}")
    if facts.get("without_lpips"):
        captures.append(STAND_IN)
    return "; ".join(captures)


def made_by(facts: Mapping) -> str:
    """Say which captures, reconstructor and appearance descriptor made the numbers, in LaTeX;
    beside those of `captures_of`, `facts` has reconstructor, long_side and descriptor."""
    return (
        f"Captures: {captures_of(facts)}. Reconstructor: {printed(facts)}; appearance "
        rf"descriptor: \texttt{{{tex(facts['descriptor'])}}}."
    )


def printed(reconstruction: Mapping) -> str:
    """Name a `reconstructor` and its image size, `long_side` in pixels, in LaTeX."""
    name = tex(reconstruction["reconstructor"])
    return rf"\texttt{{{name}}} at {reconstruction['long_side']} pixels"


def note(facts: Mapping) -> str:
    """Say in one plain line which captures and reconstructor made a figure; see `made_by`."""
    embedded, real = (", ".join(facts[key]) for key in ("embedded", "real"))
    captures = [f"generated stand-ins for {embedded}"] if embedded else []
    captures += [f"{real}, read from disk"] if real else []
    if facts.get("missing"):
        captures.append(f"missing: {', '.join(facts['missing'])}")
    if facts.get("without_lpips"):
        captures.append(STAND_IN)
    where = f"{facts['reconstructor']} at {facts['long_side']} pixels"
    return f"Captures: {'; '.join(captures)}. Reconstructor: {where}"
