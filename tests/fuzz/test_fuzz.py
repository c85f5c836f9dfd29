"""A short run of the fuzzer, and the cases that went wrong once; the long run is by hand."""

from pathlib import Path

import pytest

from fuzz import cases, originals

STORED = cases.stored(Path(__file__).with_name("cases.json"))
SHORT = cases.drawn(36, seed=1)


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    folder = tmp_path_factory.mktemp("originals")
    originals.write(folder)
    return folder


@pytest.mark.parametrize("case", [*SHORT, *STORED], ids=lambda case: f"{case.kind}-{case.seed}")
@pytest.mark.usefixtures("capfd")
def test_damage_is_refused_in_words_that_name_it(case, original, tmp_path):
    assert cases.run(case, original, tmp_path / "work") == []


def test_undamaged_captures_are_accepted(original, tmp_path):
    for layout in ("ring", "nerfstudio", "co3d"):
        assert cases.run(cases.Case(layout, 0, ()), original, tmp_path / "work") == []
