"""A LaTeX table as a page for Snakemake's report, which a browser shows."""

from __future__ import annotations

import re
from html import escape
from pathlib import Path
from unicodedata import lookup

from fsel.core.files import write_text
from fsel.pages.shell import document

TAGS = {"textbf": "b", "mathbf": "b", "textit": "i", "texttt": "code", "_": "sub", "^": "sup"}
SIGNS = {"uparrow": "↑", "downarrow": "↓", "bullet": "•", "perp": "⊥", "parallel": "∥"}
SIGNS |= {"min": "min", "max": "max", "tiny": ""}
GROUP = re.compile(r"(?:\\([a-z]+)|([_^]))?\{([^{}]*)\}")  # the innermost ones
SPAN = re.compile(r"\\multicolumn\{(\d+)\}\{[^{}]*\}(.*)", re.DOTALL)


def table_page(table: str, page: str) -> None:
    """Write the page of what `fsel.evaluation.latex` wrote, its caption and every tabular."""
    text = Path(table).read_text(encoding="utf-8")
    caption = re.search(r"^\\caption\{(.*)\}$", text, re.MULTILINE)
    parts = [f"<p>{plain(caption[1])}</p>"] if caption else []
    for block in re.findall(r"\\toprule\n(.*?)\\bottomrule", text, re.DOTALL):
        parts += ['<div class="wide"><table>', *_rows(block), "</table></div>"]
    write_text(document(Path(table).stem, (), parts), page)


def _rows(block: str) -> list[str]:
    """Return the rows of a tabular between its outer rules: headings, and groups between rules."""
    parts = []
    for at, group in enumerate(block.split("\\midrule\n")):
        room, kind = ("tbody", "td") if at else ("thead", "th")
        parts.append(f"<{room}>")
        for line in group.splitlines():
            if line.endswith(r"\\"):
                cells = re.split(r"(?<!\\)&", line.removesuffix(r"\\"))
                parts.append(f"<tr>{''.join(_cell(cell.strip(), kind) for cell in cells)}</tr>")
        parts.append(f"</{room}>")
    return parts


def _cell(text: str, kind: str) -> str:
    wide = SPAN.fullmatch(text)
    span, text = (f' colspan="{wide[1]}"', wide[2]) if wide else ("", text)
    return f"<{kind}{span}>{plain(text)}</{kind}>"


def plain(text: str) -> str:
    """Return HTML of LaTeX text: bold, italics, sub- and superscripts, Greek letters and arrows."""
    text = escape(text.replace(r"\\", " "), quote=False)

    def group(found: re.Match[str]) -> str:
        tag = TAGS.get(found[1] or found[2])
        return f"<{tag}>{found[3]}</{tag}>" if tag else found[3]

    while (shorter := GROUP.sub(group, text)) != text:
        text = shorter
    text = re.sub(r"\\([A-Za-z]+)", _sign, text)
    text = re.sub(r"(?<!\\)\$", "", text)
    return re.sub(r"\\(.)", r"\1", text).replace("~", "\u00a0").replace("--", "\u2013")


def _sign(command: re.Match[str]) -> str:
    name = command[1]
    if name in SIGNS:
        return SIGNS[name]
    case = "SMALL" if name.islower() else "CAPITAL"
    return lookup(f"GREEK {case} LETTER {name.upper()}")
