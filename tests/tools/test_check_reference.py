"""The tables of a run beside those of docs/results."""

import pytest

from check_reference import compare, main, sha256_of, stale, write

SWEEP = """dataset,method,k,metric,mean,n
a,fsel,5,psnr,20.000000,3
a,fsel,10,psnr,21.500000,3
"""
HEATMAP = """dataset,k,reference,gain,significant,method,rivals
a,5,random,0.5,False,fsel,paper
"""
TURNED = "\n".join([SWEEP.splitlines()[i] for i in (0, 2, 1)] + [""])


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


@pytest.mark.parametrize(
    ("sweep", "heatmap", "part"),
    [
        (
            SWEEP.replace("20.000000", "20.000001").replace("21.5", "21.4"),
            HEATMAP,
            "2 cells differ, the most: mean of a, fsel, 10, psnr is 21.400000, not 21.500000",
        ),
        # a word counts more than a number
        (
            SWEEP,
            HEATMAP.replace("False", "True").replace("0.5", "0.7"),
            "2 cells differ, the most: significant of a, fsel, 5, random, paper is",
        ),
        (SWEEP + "a,uniform,5,psnr,19.0,3\n", HEATMAP, "1 rows are in only one of the two"),
        (TURNED, HEATMAP, "the rows are equal, their order is not"),
    ],
)
def test_the_largest_difference_is_named(folders, sweep, heatmap, part):
    put(folders, sweep, heatmap)
    (sentence,) = compare(folders / "tables", folders / "reference")
    assert part in sentence


def test_a_difference_ends_the_command_with_one(folders, capsys):
    places = ["--tables", str(folders / "tables"), "--reference", str(folders / "reference")]
    assert main(places) == 0
    put(folders, SWEEP.replace("20.0", "20.5"), HEATMAP)
    assert main(places) == 1
    assert "20.500000, not 20.000000" in capsys.readouterr().out
    assert main([*places, "--write"]) == 0
    assert main(places) == 0


def test_pages_of_another_table_are_named_but_for_those_of_seconds(tmp_path):
    for name, head in (("same", "k,mean"), ("other", "k,mean"), ("time", "k,fit_seconds")):
        table = tmp_path / f"{name}.csv"
        table.write_text(f"{head}\n5,1.0\n")
        digest = sha256_of(table) if name == "same" else "0" * 64
        (tmp_path / f"{name}.md").write_text(f"# {name}\n\nsha256 of `{name}.csv`: `{digest}`\n")
    (sentence,) = stale(tmp_path, tmp_path)
    assert "other.md" in sentence
