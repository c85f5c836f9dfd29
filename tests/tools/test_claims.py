"""The page of the paper's claims counts and compares what a run measured."""

from shutil import copytree

import pandas as pd
import pytest

from claims import page, scene_means

# by method and K, of two scenes: the selector leads by 1 and 3 dB at K = 30, trails at K = 40
PSNR = {
    ("less_is_more", 30): (21.0, 23.0),
    ("less_is_more", 40): (21.0, 21.0),
    ("less_is_more_no_appearance", 30): (21.0, 23.0),
    ("random", 30): (20.0, 20.0),
    ("random", 40): (24.0, 24.0),
    ("untrained", 30): (19.0, 19.0),
    ("untrained", 40): (19.0, 19.0),
    ("all", 50): (20.0, 22.0),
}


@pytest.fixture
def results(tmp_path):
    for scene in (0, 1):
        folder = tmp_path / "dl3dv" / f"evaluation{scene}" / "draw0"
        folder.mkdir(parents=True)
        rows = [
            {"method": method, "k": k, "seed": seed, "target": target, "psnr": means[scene] + off}
            for (method, k), means in PSNR.items()
            for seed in (0, 1)
            for target, off in ((3, -1.0), (4, 1.0))
        ]
        pd.DataFrame(rows).to_parquet(folder / "evaluation.parquet")
    return tmp_path


def test_scenes_are_means_over_targets_and_seeds(results):
    cells = scene_means(results)
    assert cells["less_is_more", 30].tolist() == [21.0, 23.0]
    assert cells["all", 0].tolist() == [20.0, 22.0]


def test_claims_by_hand(results):
    lines = [line.split(" | ") for line in page(results).splitlines() if " | " in line]
    found = {claim.removeprefix("| "): (ours, verdict) for claim, _, ours, _, verdict, *_ in lines}
    ahead = next(claim for claim in found if "nine baselines" in claim)
    assert found[ahead] == ("1 of 2", "not here")
    ours, verdict = found["over the strongest baseline of each dataset, K = 30"]
    assert ours.startswith("+2.00 dB")
    assert verdict == "level"  # two scenes, 1 and 3 dB: the interval holds zero
    assert found["over the strongest baseline of each dataset, K = 40"][1] == "not here"
    assert found["over all frames on DL3DV, K = 30"] == ("+1.00 dB (+1.00 to +1.00)", "holds")


def test_the_strongest_baseline_of_a_table_is_compared_scene_by_scene(results):
    """1 and 3 dB over random, which is stronger than 19 dB of another."""
    (results / "tables").mkdir()
    (results / "tables" / "crosscapture.csv").touch()
    for scene, ours in enumerate((21.0, 23.0)):
        means = {"less_is_more": ours, "random": 20.0, "uniform": 19.0}
        rows = [{"method": name, "k": 30, "seed": 0, "psnr": psnr} for name, psnr in means.items()]
        folder = results / "seven_scenes" / f"evaluation{scene}"
        folder.mkdir(parents=True)
        pd.DataFrame(rows).to_parquet(folder / "crosscapture.parquet")
    table = pd.DataFrame({"reconstructor": ["splats", "gaussians"], "k": ["30", "all"]})
    table = table.assign(outcome="", device="")
    table.to_csv(results / "tables" / "reconchoice.csv", index=False)
    for scene, ours in enumerate((31.0, 31.2)):
        folder = results / "dl3dv" / f"evaluation{scene}" / "draw0" / "gaussians"
        folder.mkdir()
        rows = {"k": [30, 40, 0], "psnr": [ours, 29.0, 30.0]}
        pd.DataFrame(rows).to_parquet(folder / "reconchoice.parquet")
    assert "`gaussians`, K = 40 | +1.68 dB | -1.00 dB (-1.00 to -1.00) | 2 scenes" in page(results)
    row = next(line for line in page(results).splitlines() if "across captures" in line)
    assert "| +2.00 dB (-10.71 to +14.71) | 2 scenes | level |" in row


def test_captures_from_disk_are_rows_of_their_own(results):
    alone = page(results).splitlines()
    copytree(results / "dl3dv", results / "fox")  # neither a scene nor a cell of the sweep
    (results / "tables" / "captures").mkdir(parents=True)
    path = results / "tables" / "captures" / "ksweep_differences.csv"
    pd.DataFrame({"dataset": ["fox", "all"]}).to_csv(path, index=False)
    copytree(results / "dl3dv", results / "real" / "real")
    *others, best, _, untrained, _ = page(results).splitlines()
    assert others == alone
    assert "real captures, K = 30 | ahead | +2.00 dB (-10.71 to +14.71) | 2 captures" in best
    assert best.endswith("worst +1.00 dB | level | over `random` |")
    assert "over the untrained sum on real captures, K = 30 | ahead | +3.00 dB" in untrained


def test_a_folder_without_a_run_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=str(tmp_path)):
        page(tmp_path)
