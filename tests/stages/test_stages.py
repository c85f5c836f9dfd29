"""Stages: tables on disk, the journal, and small captures through every adapter."""

import numpy as np
import pandas as pd
import pytest

from fsel.baselines import METHODS
from fsel.capture import Capture
from fsel.files import atomic, digest, fingerprint, table_metadata, write_table
from fsel.problem import Problem
from fsel.report.numbers import read_csv
from fsel.split import Split
from fsel.stages.describe import describe
from fsel.stages.ingest import ingest
from fsel.stages.ksweep import Sweep, caption, ksweep
from fsel.stages.label import label, trajectories
from fsel.stages.select import evaluate, search_oracle, select
from fsel.stages.split import split
from fsel.stages.train import clone, refined
from fsel.synthesis import record
from fsel.training.journal import Journal

SEARCH = {
    "labeller": "genetic",
    "k": 4,
    "population": 6,
    "farthest": 2,
    "uniform": 2,
    "generations": 1,
    "elites": 1,
    "tournament": 2,
    "crossover": 0.8,
    "mutation": 0.3,
    "evaluations": 5,
    "stored": 5,
    "kept": 2,
}
FACTS = {
    "embedded": ["Tanks & Temples"],
    "real": ["fox"],
    "reconstructor": "splats",
    "long_side": 64,
    "descriptor": "lab_hog",
    "search_k": 20,
    "draws": 3,
    "oracle_draws": 1,
}
RECONSTRUCTION = {"name": "splats", "long_side": 32, "settings": {}}


def test_a_failed_write_leaves_the_old_file(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")

    def cut_off() -> None:
        with atomic(path) as temporary:
            temporary.write_text("half")
            raise RuntimeError("cut off")

    with pytest.raises(RuntimeError, match="cut off"):
        cut_off()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_tables_carry_units_and_digest(tmp_path):
    path = tmp_path / "t.parquet"
    write_table(pd.DataFrame({"d": [1.0]}), path, units={"d": "m"}, config="abc")
    assert table_metadata(path) == ({"d": "m"}, "abc")
    assert pd.read_parquet(path)["d"].tolist() == [1.0]
    with pytest.raises(ValueError, match="units for \\['e'\\]"):
        write_table(pd.DataFrame({"d": [1.0]}), path, units={"e": "m"}, config="")


def test_equal_tables_are_equal_bytes(tmp_path):
    for name in "ab":
        frame = pd.DataFrame({"x": np.arange(5), "s": [[1, 2]] * 5})
        write_table(frame, tmp_path / name, units={}, config="")
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_digests_follow_content_not_order(tmp_path):
    assert digest({"a": 1, "b": 2}) == digest({"b": 2, "a": 1}) != digest({"a": 1, "b": 3})
    path = tmp_path / "f"
    path.write_text("1")
    first = fingerprint([path], {})
    path.write_text("2")
    assert fingerprint([path], {}) != first


class Counting:
    """An evaluator that fails at its n-th call, as a kill would."""

    def __init__(self, stop: int = 10**9) -> None:
        self.calls, self.stop = 0, stop

    def __call__(self, subset: np.ndarray) -> np.ndarray:
        self.calls += 1
        if self.calls == self.stop:
            raise KeyboardInterrupt
        return np.array([subset.sum() / 3, 1 / 7, 0.1])


def test_a_journal_answers_what_a_killed_job_had_evaluated(tmp_path):
    output = tmp_path / "out.parquet"
    subsets = [np.array([i, i + 1]) for i in range(6)]

    def run(counting: Counting) -> list[np.ndarray]:
        with Journal(output, "key") as journal:
            remembered = journal.remember("p", counting)
            return [remembered(subset) for subset in subsets]

    with pytest.raises(KeyboardInterrupt):
        run(Counting(stop=4))
    (path,) = tmp_path.iterdir()
    path.write_text(path.read_text() + '["p:9,10", [1.0, 2')  # cut short by the kill
    second = Counting()
    values = run(second)
    assert second.calls == 3
    np.testing.assert_array_equal(values, [Counting()(s) for s in subsets])
    assert list(tmp_path.iterdir()) == []


def test_a_journal_of_other_inputs_is_not_read(tmp_path):
    other = Journal(tmp_path / "o", "one").path
    other.write_text('["p:1", [1.0, 2.0, 3.0]]\n')
    counting = Counting()
    with Journal(tmp_path / "o", "two") as journal:
        journal.remember("p", counting)(np.array([1]))
    assert counting.calls == 1


def test_split_survives_its_table():
    parts = Split(np.array([1, 4]), np.array([5, 0]), np.array([2, 3]), np.array([3]))
    table = parts.table(list("abcdef"))
    assert table["role"].tolist() == [
        "proxy",
        "target",
        "candidate",
        "candidate",
        "target",
        "proxy",
    ]
    assert table["proxy_of"].tolist() == [4, -1, -1, -1, -1, 1]
    again = Split.from_table(table.sample(frac=1, random_state=0))
    for name in ("targets", "proxies", "candidates", "region"):
        np.testing.assert_array_equal(getattr(again, name), getattr(parts, name))


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """A small canonical capture with descriptors."""
    folder = tmp_path_factory.mktemp("scene")
    recording = record("dl3dv", 3, frames=40, width=32, height=24)
    camera = recording.camera
    focal = camera.params[0]
    Capture(
        names=recording.names,
        world_to_camera=recording.world_to_camera,
        intrinsics=np.tile([focal, focal, 16.0, 12.0], (40, 1)),
        images=recording.images,
        sequences=recording.sequences,
    ).save(folder)
    describe(folder, folder / "descriptors.parquet", kind="lab_hog", weights=None, config="c")
    return folder


@pytest.fixture(scope="module")
def labelled(scene, tmp_path_factory):
    """One coverage level of one scene, searched and ordered."""
    folder = tmp_path_factory.mktemp("labelled")
    item = {
        "scene": "s",
        "role": "train",
        "folder": scene,
        "splits": folder / "splits.parquet",
        "labels": {25: folder / "p25.parquet"},
    }
    label(
        scene,
        item["labels"],
        item["splits"],
        seed=5,
        search=SEARCH,
        reconstruction=RECONSTRUCTION,
        inputs=[],
        config="c",
    )
    trajectories([item], folder / "trajectories.parquet", kept=2, config="c")
    return folder


def test_labels_rank_subsets_and_trajectories_order_the_best(labelled):
    labels = pd.read_parquet(labelled / "p25.parquet")
    assert sorted(labels["rank"].unique()) == [-1, 0, 1, 2, 3, 4]
    assert labels.loc[labels["rank"] == 0, "fitness"].item() == labels["fitness"].max()
    assert all(len(set(subset)) == 4 for subset in labels["subset"])
    table = pd.read_parquet(labelled / "trajectories.parquet")
    assert table["rank"].tolist() == [0, 1]
    assert table["weight"].mean() == pytest.approx(1)
    assert sorted(table["picks"][0]) == sorted(labels.set_index("rank").loc[0, "subset"])


def test_equal_trainings_write_equal_files_and_other_seeds_others(scene, labelled, tmp_path):
    scenes = {"s": (scene, labelled / "splits.parquet")}
    for name, seeds in (("a", 2), ("b", 1)):
        clone(
            scenes,
            labelled / "trajectories.parquet",
            [tmp_path / f"{name}{seed}.safetensors" for seed in range(seeds)],
            [tmp_path / f"{name}{seed}.parquet" for seed in range(seeds)],
            policy="ours",
            epochs=1,
            learning_rate=1e-3,
            config="c",
        )
    written = {path.stem: path.read_bytes() for path in tmp_path.glob("*.safetensors")}
    assert written["a0"] == written["b0"]
    assert written["a0"] != written["a1"]
    assert pd.read_parquet(tmp_path / "a1.parquet")["epoch"].tolist() == [0, 1]


def test_refinement_continues_after_a_kill(scene, tmp_path, monkeypatch):
    settings = {
        "generations": 2,
        "population": 3,
        "step": 30.0,
        "batch": 1,
        "draws": 2,
        "targets": 4,
        "budgets": [3, 5],
        "seed": 0,
    }

    def run(name: str) -> bytes:
        refined(
            {"s": scene},
            tmp_path / f"{name}.safetensors",
            tmp_path / "log.parquet",
            seed=0,
            settings=settings,
            reconstruction=RECONSTRUCTION,
            inputs=[],
            config="c",
        )
        return (tmp_path / f"{name}.safetensors").read_bytes()

    whole = run("whole")
    calls = []
    add = Journal._add

    def killed(self, key, values):
        add(self, key, values)
        calls.append(key)
        if len(calls) == 4:
            raise KeyboardInterrupt

    monkeypatch.setattr(Journal, "_add", killed)
    with pytest.raises(KeyboardInterrupt):
        run("killed")
    monkeypatch.setattr(Journal, "_add", add)
    assert run("killed") == whole


@pytest.fixture(scope="module")
def swept(scene, tmp_path_factory):
    """Two draws of one scene, selected and evaluated by every method without weights."""
    folder = tmp_path_factory.mktemp("swept")
    draws = [folder / f"draw{d}" for d in range(2)]
    splits, picks, outputs = (
        [draw / f"{name}.parquet" for draw in draws]
        for name in ("split", "selections", "evaluation")
    )
    split(scene, splits, targets=4, seed=1, config="c")
    select(scene, splits, [], picks, budgets=[3, 5], seeds=[2, 2], config="c")
    evaluate(scene, splits, picks, outputs, reconstruction=RECONSTRUCTION, config="c")
    return draws


def test_selections_nest_and_spare_the_targets(scene, swept):
    problem = Problem.load(scene, swept[0] / "split.parquet")
    assert len(problem.candidates) == 32
    picks = pd.read_parquet(swept[0] / "selections.parquet").sort_values("order")
    nearest = picks[picks["method"] == "nearest"].groupby("k")["frame"].agg(list)
    assert nearest[3] == nearest[5][:3]
    assert picks.loc[picks["method"] == "all", "k"].unique().tolist() == [36]
    pools = picks.groupby("method")["pool"].unique().map(list).to_dict()
    assert pools == {name: [method.pool] for name, method in METHODS.items()}
    proxies = set(problem.proxies)
    assert proxies & set(picks.loc[picks["pool"] == "observed", "frame"]) == proxies
    assert not proxies & set(picks.loc[picks["pool"] == "candidates", "frame"])
    assert picks.loc[picks["method"] == "random", "seed"].nunique() == 3
    targets = Split.load(swept[0] / "split.parquet").targets
    assert not set(targets.tolist()) & set(picks["frame"])
    evaluation = pd.read_parquet(swept[0] / "evaluation.parquet")
    assert len(evaluation) == 4 * len(picks[["method", "seed", "k"]].drop_duplicates())


def test_the_sweep_table_prints_means_of_the_evaluations(swept, tmp_path):
    items = [
        {"dataset": "d", "scene": "s", "draw": draw.name, "path": draw / "evaluation.parquet"}
        for draw in swept
    ]
    paths = [tmp_path / name for name in ("k.tex", "k.csv", "d.csv")]
    sweep = Sweep(items, {"d": "D"}, [3, 5], {"resamples": 100, "seed": 0}, FACTS)
    ksweep(sweep, *paths)
    tables = [pd.read_parquet(item["path"]) for item in items]
    expected = np.mean([t.query("method == 'fvs' and k == 5")["psnr"].mean() for t in tables])
    found = read_csv(paths[1]).query("method == 'fvs' and k == 5 and metric == 'psnr'")
    assert found["mean"].item() == pytest.approx(expected, abs=1e-6)
    text = paths[0].read_text()
    for method in METHODS.values():
        assert f"\n{method.label} & " in text
    # a rule between the paper's baselines, the further ones, and the references
    assert text.count(r"\midrule") == 3
    assert "search" not in text


def test_oracle_beats_its_own_first_subset(scene, tmp_path):
    split(scene, [tmp_path / "split.parquet"], targets=4, seed=1, config="c")
    search_oracle(
        scene,
        tmp_path / "split.parquet",
        tmp_path / "subsets.parquet",
        tmp_path / "oracle.parquet",
        search=SEARCH,
        reconstruction=RECONSTRUCTION,
        seed=0,
        inputs=[],
        config="c",
    )
    subsets = pd.read_parquet(tmp_path / "subsets.parquet")
    counts = subsets["method"].value_counts()
    assert counts["search"] == counts["random_search"]
    oracle = pd.read_parquet(tmp_path / "oracle.parquet")
    assert set(oracle["method"]) == {"search", "random_search"}
    assert oracle["k"].unique().tolist() == [4]
    assert list(tmp_path.glob(".*journal")) == []


def test_the_caption_names_what_made_the_table():
    text = caption(FACTS | {"searched": True})
    for part in (r"Tanks \& Temples", "stand-ins", "fox", r"lab\_hog", "GMSD", "1 of 3 target"):
        assert part in text


def test_a_capture_with_too_few_frames_is_refused(tmp_path, monkeypatch):
    few = type("Few", (), {"__len__": lambda self: 3})()
    found = type("Found", (), {"capture": few})()
    monkeypatch.setattr("fsel.stages.ingest.read_folder", lambda *a, **k: found)
    with pytest.raises(ValueError, match=r"scene: 3 usable frames, at least 50.*Hint: "):
        ingest("scene", tmp_path, layout="colmap", long_side=64, at_least=50)
