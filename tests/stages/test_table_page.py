"""A table's page for the report: cells as LaTeX sets them, by hand."""

import re

import pytest

from fsel.evaluation.latex import plain_table
from fsel.experiments.paper.ablation.tables import SYMBOLS
from fsel.stages.table_page import plain, table_page


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        (r"\textbf{.545}/.205", "<b>.545</b>/.205"),
        (r"$\mathbf{+0.92}$ {\tiny$[+0.52,+1.61]$}", "<b>+0.92</b> [+0.52,+1.61]"),
        (r"$K{=}5$, PSNR$\uparrow$~/~a--b", "K=5, PSNR↑\u00a0/\u00a0a–b"),
        (r"$\gamma_{\min}^{\mathcal{O}}$", "γ<sub>min</sub><sup>O</sup>"),
        (r"\shortstack{w/o appear.\\\& sharp.}", "w/o appear. &amp; sharp."),
        (r"\texttt{lab\_hog} < 5\%", "<code>lab_hog</code> &lt; 5%"),
        (r"$\Delta$PSNR", "ΔPSNR"),
    ],
)
def test_what_latex_sets(text, shown):
    assert plain(text) == shown


def test_every_symbol_of_the_paper_is_shown():
    for symbol in SYMBOLS.values():
        assert not re.search(r"[\\{}$]", plain(symbol))


def test_a_page_has_the_table_row_by_row(tmp_path):
    rows, told = [["A \\& B", "1"], [r"\textbf{C}", "--"]], {"caption": r"One \textbf{two}."}
    text = plain_table(["Method", "dB"], rows, **told, label="t", groups=[("PSNR", 1)])
    (tmp_path / "t.tex").write_text(text)
    table_page(tmp_path / "t.tex", tmp_path / "t.html")
    page = (tmp_path / "t.html").read_text()
    assert "<p>One <b>two</b>.</p>" in page
    assert re.findall(r"</?t.*>", page.partition("<table>")[2]) == [
        "<thead>",
        '<tr><th></th><th colspan="1">PSNR</th></tr>',
        "<tr><th>Method</th><th>dB</th></tr>",
        "</thead>",
        "<tbody>",
        "<tr><td>A &amp; B</td><td>1</td></tr>",
        "<tr><td><b>C</b></td><td>–</td></tr>",
        "</tbody>",
        "</table></div>",
    ]
