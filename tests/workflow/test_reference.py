"""The tables of a run beside those that the documentation quotes."""

import pytest

from fsel.workflow.reference import compare, main, write

SWEEP = """dataset,method,k,metric,mean,n
a,fsel,5,psnr,20.000000,3
a,fsel,10,psnr,21.500000,3
"""
HEATMAP = """dataset,k,reference,gain,significant,method,rivals
a,5,random,0.5,False,fsel,paper
"""


@pytest.fixture
def folders(tmp_path):
    for name in ("tables", "reference"):
        (tmp_path / name).mkdir()
    put(tmp_path, SWEEP, HEATMAP)
    write(tmp_path / "tables", tmp_path / "reference")
    return tmp_path


def put(folder, sweep, heatmap):
    (folder / "tables/ksweep.csv").write_text(sweep)
    (folder / "tables/heatmap.csv").write_text(heatmap)


def told(folder):
    return compare(folder / "tables", folder / "reference")


def test_equal_tables_are_told_nothing(folders, capsys):
    assert told(folders) == []
    places = ["--tables", str(folders / "tables"), "--reference", str(folders / "reference")]
    assert main(places) == 0
    assert "equal" in capsys.readouterr().out


def test_the_cell_that_differs_most_is_named(folders):
    put(folders, SWEEP.replace("20.000000", "20.000001").replace("21.5", "21.4"), HEATMAP)
    (sentence,) = told(folders)
    assert sentence == (
        "ksweep.csv: 2 cells differ, the most: mean of a, fsel, 10, psnr is 21.400000, "
        "not 21.500000"
    )


def test_a_word_counts_more_than_a_number(folders):
    put(folders, SWEEP, HEATMAP.replace("False", "True").replace("0.5", "0.7"))
    (sentence,) = told(folders)
    assert "2 cells differ, the most: significant of a, fsel, 5, random, paper is" in sentence


def test_other_rows_are_named(folders):
    put(folders, SWEEP + "a,uniform,5,psnr,19.0,3\n", HEATMAP)
    (sentence,) = told(folders)
    assert sentence == (
        "ksweep.csv: 1 rows are in one of the two alone, such as a, uniform, 5, psnr"
    )


def test_another_order_is_said(folders):
    head, first, second = SWEEP.splitlines()
    put(folders, "\n".join([head, second, first, ""]), HEATMAP)
    assert told(folders) == ["ksweep.csv: the rows are equal, their order is not"]


def test_a_table_that_is_not_there_is_named(folders):
    (folders / "tables/heatmap.csv").unlink()
    with pytest.raises(FileNotFoundError, match=r"heatmap.csv. Hint: make ksweep"):
        told(folders)


def test_a_difference_ends_the_command_with_one(folders, capsys):
    put(folders, SWEEP.replace("20.0", "20.5"), HEATMAP)
    places = ["--tables", str(folders / "tables"), "--reference", str(folders / "reference")]
    assert main(places) == 1
    assert "20.500000, not 20.000000" in capsys.readouterr().out
    assert main([*places, "--write"]) == 0
    assert main(places) == 0
