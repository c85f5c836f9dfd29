from fsel.core.wording import counted


def test_one_thing_is_one():
    assert [counted(n, "frame") for n in (0, 1, 2)] == ["0 frames", "1 frame", "2 frames"]
    assert counted(1, "held-out frame") == "1 held-out frame"
