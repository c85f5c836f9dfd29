"""Pages of docs/results hold the numbers of their csv files."""

import os

import pandas as pd
import pytest
import yaml

from result_pages import FOLDER, markdown, write

TABLE = pd.DataFrame(
    {
        "method": ["a", "a", "b", "b"],
        "k": [10, 0, 10, 0],
        "mean": [1.25, 2.0, -0.5, 0.125],
        "low": [1.0, float("nan"), -1.0, 0.0],
    }
)
NAMES = {"a": "A", "0": "all"}


@pytest.mark.parametrize(
    ("table", "lines"),
    [
        (
            {"down": ["method"], "across": ["k"], "cell": "{mean:.2f}"},
            [
                "|  | 10 | all |",
                "| --- | --- | --- |",
                "| A | 1.25 | 2.00 |",
                "| b | -0.50 | 0.12 |",
            ],
        ),
        (
            {"down": ["method", "k"], "rows": "k == 10", "cells": {"mean": "{mean:+.1f}"}},
            ["|  |  | mean |", "| --- | --- | --- |", "| A | 10 | +1.2 |", "| b | 10 | -0.5 |"],
        ),
        (
            {"down": ["method"], "count": {"ahead": "mean > 0", "far": "mean > 1.5"}},
            ["|  | ahead | far |", "| --- | --- | --- |", "| A | 2 | 1 |", "| b | 1 | 0 |"],
        ),
    ],
)
def test_a_table_by_hand(table, lines):
    assert markdown(TABLE, table, NAMES).splitlines() == lines


def test_what_has_no_number_is_left_out():
    table = {"down": ["method"], "across": ["k"], "cell": "{mean:.2f} (from {low:.2f})"}
    assert markdown(TABLE, table, {}).splitlines()[2] == "| a | 1.25 (from 1.00) | 2.00 |"
    table["cell"] = "{low:.2f}"
    assert markdown(TABLE, table, {}).splitlines()[2] == "| a | 1.00 |  |"


def test_a_table_that_is_not_full_keeps_its_order():
    rows = TABLE[(TABLE["method"] == "b") | (TABLE["k"] == 0)]
    table = {"down": ["method"], "across": ["k"], "cell": "{mean:.1f}"}
    lines = markdown(rows, table, {}).splitlines()
    assert [lines[0], lines[2]] == ["|  | 0 | 10 |", "| a | 2.0 |  |"]


@pytest.fixture
def checkout(tmp_path):
    """A checkout of one page and its csv file, of a known day."""
    (tmp_path / FOLDER).mkdir(parents=True)
    (tmp_path / "docs" / "figures").mkdir()
    table = {"caption": "Gains", "csv": "t.csv", "down": ["method"], "cell": "{mean:.1f}"}
    page = {"title": "T", "command": "make it", "text": "Of x.", "tables": [table]}
    contents = {"names": {}, "pages": {"gain": page}}
    (tmp_path / FOLDER / "pages.yaml").write_text(yaml.safe_dump(contents))
    (tmp_path / "t.csv").write_text("method,k,mean\na,all,3\n")
    os.utime(tmp_path / "t.csv", (86400, 86400))
    return tmp_path


def test_a_page_says_what_made_it_and_when(checkout):
    assert write(checkout) == []
    lines = (checkout / FOLDER / "gain.md").read_text().split("\n\n")
    assert lines[:4] == ["# T", "`make it`, 1970-01-02.", "Of x.", "**Gains**"]
    assert lines[4] == "|  |  |\n| --- | --- |\n| a | 3.0 |"
    assert lines[5].startswith("sha256 of `t.csv`: `")


def test_a_page_without_its_numbers_stays(checkout):
    write(checkout)
    before = (checkout / FOLDER / "gain.md").read_bytes()
    (checkout / "t.csv").unlink()
    assert write(checkout) == ["gain"]
    assert (checkout / FOLDER / "gain.md").read_bytes() == before


def test_a_table_that_does_not_fit_is_named(checkout):
    (checkout / "t.csv").write_text("method,gain\na,3\n")
    with pytest.raises(ValueError, match=r"t\.csv: Gains: 'mean'"):
        write(checkout)
