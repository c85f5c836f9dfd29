"""Targets that an option of Snakemake's would take for its value."""

import sys

import pytest

from fsel.workflow.command_line import check, misplaced


@pytest.mark.parametrize(
    ("command", "found"),
    [
        ("results/t.tex --configfile a.yaml", None),
        ("--configfile a.yaml b.yml results/t.tex", ("--configfile", "results/t.tex")),
        ("--configfile a.yaml --cores 2 results/t.tex", None),
        ("--configfile a.yaml -- results/t.tex", None),
        ("-n --config draws=1 paper", ("--config", "paper")),
        ("-C draws=1 k=2 --quiet all", None),
        ("", None),
    ],
)
def test_words_that_an_option_does_not_know(command, found):
    assert misplaced(command.split()) == found


def test_the_hint_names_target_and_option(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["snakemake", "--configfile", "a.yaml", "paper"])
    with pytest.raises(SystemExit, match=r"'paper' stands after --configfile.*\nHint: .*-- paper"):
        check()
    monkeypatch.setattr(sys, "argv", ["snakemake", "paper", "--configfile", "a.yaml"])
    check()
