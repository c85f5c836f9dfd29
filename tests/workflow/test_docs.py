"""Numbers quoted in the README and docs/ are those of their csv files."""

import json
import re
from itertools import pairwise
from pathlib import Path

import pandas as pd
import pytest
import yaml

from fsel.workflow import docs

ROOT = Path(__file__).parents[2]
TABLE = pd.DataFrame(
    {
        "method": ["a", "a", "b", "b"],
        "k": [10, 20, 10, 20],
        "mean": [1.25, 2.0, -0.5, 0.125],
        "n": 4,
    }
)


@pytest.mark.parametrize(
    ("definition", "text"),
    [
        ({"rows": "method == 'a'", "value": "mean", "format": ".2f"}, "1.25 / 2.00"),
        ({"rows": "method == 'b'", "value": "mean of mean", "format": "+.3f"}, "-0.188"),
        ({"rows": "mean > 1", "value": "count"}, "2"),
        ({"rows": "mean > 9", "value": "count"}, "0"),
        ({"value": "min of mean"}, "-0.5"),
        (
            {"value": "mean", "down": "method", "across": "k", "names": {"a": "A", "20": "all"}},
            "\n|  | 10 | all |\n| --- | --- | --- |\n| A | 1.25 | 2.0 |\n| b | -0.5 | 0.125 |\n",
        ),
        (
            {"value": ["mean", "n"], "down": ["method", "k"], "rows": "k == 20", "format": ".1f"},
            "\n|  |  | mean | n |\n| --- | --- | --- | --- |\n"
            "| a | 20 | 2.0 | 4.0 |\n| b | 20 | 0.1 | 4.0 |\n",
        ),
        (
            {"value": "mean", "down": ["method"], "across": "k", "rows": "method == 'b'"},
            "\n|  | 10 | 20 |\n| --- | --- | --- |\n| b | -0.5 | 0.125 |\n",
        ),
    ],
)
def test_a_result_by_hand(definition, text):
    assert docs.quoted(TABLE, definition) == text


def test_budgets_are_whole_numbers_beside_rows_that_are_about_none():
    mixed = TABLE.assign(k=TABLE["k"].astype(float).where(TABLE["method"] == "a"))
    found = {"rows": "k == k", "value": "mean", "down": "method", "across": "k"}
    assert (
        docs.quoted(mixed, found) == "\n|  | 10 | 20 |\n| --- | --- | --- |\n| a | 1.25 | 2.0 |\n"
    )


def test_a_query_without_rows_is_refused():
    with pytest.raises(ValueError, match="no row with method == 'c'"):
        docs.quoted(TABLE, {"rows": "method == 'c'", "value": "mean"})


@pytest.fixture
def checkout(tmp_path):
    """A checkout of one page, one definition and one table."""
    (tmp_path / "docs").mkdir()
    definition = {"gain": {"table": "t.csv", "rows": "k == 20", "value": "mean", "format": ".1f"}}
    (tmp_path / docs.DEFINITIONS).write_text(yaml.safe_dump(definition))
    page = "By <!-- result: gain -->old<!-- end --> dB.\n"
    (tmp_path / "README.md").write_text(page)
    (tmp_path / "t.csv").write_text("k,mean\n10,3\n20,4.26\n")
    return tmp_path


def test_pages_are_rewritten_and_keep_their_text_without_the_table(checkout):
    assert docs.write(checkout) == []
    written = (checkout / "README.md").read_text()
    assert written == "By <!-- result: gain -->4.3<!-- end --> dB.\n"
    (checkout / "t.csv").unlink()
    assert docs.write(checkout) == ["gain"]
    assert (checkout / "README.md").read_text() == written


def test_a_result_that_was_never_made_is_refused(checkout):
    (checkout / "t.csv").unlink()
    with pytest.raises(ValueError, match=r"gain: .*t\.csv is missing"):
        docs.write(checkout)


def test_a_wrong_definition_names_its_result_and_file(checkout):
    (checkout / docs.DEFINITIONS).write_text("gain: {table: t.csv, rows: j == 1, value: mean}\n")
    with pytest.raises(ValueError, match=r"gain, .*t\.csv: .*'j'"):
        docs.write(checkout)


def test_pages_snapshot_and_definitions_agree():
    definitions = yaml.safe_load((ROOT / docs.DEFINITIONS).read_text(encoding="utf-8"))
    snapshot = json.loads((ROOT / docs.SNAPSHOT).read_text(encoding="utf-8"))
    assert list(snapshot) == list(definitions)
    used = set()
    for page in docs.pages(ROOT):
        text = page.read_text(encoding="utf-8")
        assert docs.with_results(text, snapshot) == text, page
        used |= {found[2] for found in docs.MARKED.finditer(text)}
    assert used == set(definitions)


@pytest.mark.parametrize("page", docs.pages(ROOT), ids=lambda page: page.name)
def test_no_comment_breaks_a_paragraph(page):
    """In Markdown a line that begins with a comment ends the paragraph above it."""
    lines = page.read_text(encoding="utf-8").splitlines()
    lone = re.compile(r"<!-- (result: \w+|end) -->")
    broken = [
        line
        for above, line in pairwise(lines)
        if line.startswith("<!--") and above.strip() and not lone.fullmatch(line)
    ]
    assert not broken
