"""A short run of the fuzzer, and the cases that went wrong once; the long run is by hand."""

from pathlib import Path

import pytest
from small_captures import damage_pixels

from fuzz import cases, originals, outcomes

STORED = cases.stored(Path(__file__).with_name("cases.json"))
SHORT = cases.drawn(36, seed=1)


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    folder = tmp_path_factory.mktemp("originals")
    originals.write(folder)
    cases.warm_up(["ring"], folder, folder / "work")
    return folder


@pytest.mark.parametrize("case", [*SHORT, *STORED], ids=lambda case: f"{case.kind}-{case.seed}")
@pytest.mark.usefixtures("capfd")
def test_damage_is_refused_in_words_that_name_it(case, original, tmp_path):
    assert cases.run(case, original, tmp_path / "work") == []


def test_images_are_judged_by_the_commands_that_decode_them(original, tmp_path, monkeypatch):
    """And nothing else that one command alone refuses is passed over."""
    case, work = cases.Case("ring", 0), tmp_path / "work"
    monkeypatch.setattr(
        cases.Case, "damage", lambda *_: damage_pixels(work / "capture/images/frame_001.jpg")
    )
    assert cases.run(case, original, work) == []
    found = {"select": ("done", ""), "info": ("refused", f"{work}: its 9 bytes cannot be decoded")}
    assert outcomes.faults(found, work, alike=True) == []
    found["compare"] = "refused", f"{work}: not a readable image"
    assert outcomes.faults(found, work, alike=True)[0].startswith("not alike")


def test_memory_is_what_the_command_took_and_not_what_the_process_held():
    held = bytearray(b"x" * outcomes.MEMORY)
    assert outcomes.outcome(lambda: None) == ("done", "")
    assert outcomes.outcome(lambda: len(held + held)) == ("wrong", "1.0 GB of memory")


def test_undamaged_captures_are_accepted(original, tmp_path):
    for layout in ("ring", "nerfstudio", "co3d"):
        assert cases.run(cases.Case(layout, 0, {}), original, tmp_path / "work") == []
