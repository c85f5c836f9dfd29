from fsel.core.names import natural


def test_digits_that_are_no_numbers_sort_as_letters():
    names = ["frame10", "frame2", "frame1²", "frame²"]
    assert sorted(names, key=natural) == ["frame1²", "frame2", "frame10", "frame²"]
