"""Videos and photos placed together: frames taken denser, times that are lost, causes named."""

from pathlib import Path

import cv2
import numpy as np
import pycolmap
import pytest
from scipy.spatial.transform import Rotation
from small_captures import ring

from fsel.captures import sampling
from fsel.captures.colmap import failures, mapping, runs, search_time
from fsel.captures.colmap.mapping import Mapped
from fsel.captures.colmap.runs import Part, Work
from fsel.captures.colmap.search_time import SearchTime
from fsel.captures.images import files as image_files
from fsel.captures.images import video
from fsel.captures.images.video import SampledFrame, Sampling
from fsel.captures.poses import placement, sfm
from fsel.captures.sampling import Source


def shots(*indices):
    return [SampledFrame(i, i / 10, 1.0) for i in indices]


def model_of(names, poses=None):
    """A model that has the given images, by default on a ring, and nothing else."""
    model = pycolmap.Reconstruction()
    camera = pycolmap.Camera(model="PINHOLE", width=8, height=8, params=[8, 8, 4, 4], camera_id=1)
    model.add_camera_with_trivial_rig(camera)
    poses = ring(max(3, len(names))) if poses is None else poses
    for at, (name, pose) in enumerate(zip(names, poses, strict=False)):
        rigid = pycolmap.Rigid3d(pycolmap.Rotation3d(pose[:, :3]), pose[:, 3])
        image = pycolmap.Image(image_id=at + 1, name=name, camera_id=1)
        model.add_image_with_trivial_frame(image, rigid)
    return model


@pytest.fixture
def scripted(monkeypatch):
    """No video is read and nothing matched: frames are black, and COLMAP places what the test says.

    Returns:
        A list of the frames that it places, an entry a run, or a cause of failure; and a list that
        receives the frames that it was given.
    """
    placing, given = [], []

    def thin(path, folder, pace, *, within=((0.0, np.inf),), progress=None):
        at = np.arange(0, 10, 1 / pace)
        kept = [t for t in at if any(a <= t <= b for a, b in within)]
        found = shots(*np.unique(np.round(np.array(kept) * 10).astype(int)).tolist())
        for shot in found:
            image_files.write(np.zeros((1, 8, 8, 3), np.uint8), folder, [shot.name])
        return found

    def place(raw, work, start=None):
        assert [n for part in work.parts for n in part.numbers]
        given.append((raw.names, start and start.num_images()))
        keep = placing.pop(0)
        if isinstance(keep, str):
            raise sfm.NotPlaced(Path("first.jpg"), "COLMAP placed 0 frames", keep)
        return Mapped(model_of([name for name in raw.names if keep(name)]))

    monkeypatch.setattr(video, "thin", thin)
    monkeypatch.setattr(Sampling, "pace", lambda self, path: 1.0)
    monkeypatch.setattr(sampling, "duplicates", lambda small: np.ones(len(small), bool))
    monkeypatch.setattr(sfm, "place", place)
    return placing, given


def number(name):
    return int(name.removesuffix(".jpg").rpartition("_")[2])


def test_where_frames_in_a_row_are_not_placed_they_are_taken_denser(scripted, tmp_path):
    """Ten frames at 0, 1, ... 9 s. Two in a row are lost, and one alone, which is left at that."""
    placing, given = scripted
    placing += [lambda name: number(name) not in (20, 50, 60), lambda name: number(name) != 20]
    sources, said = [Source(tmp_path / "walk.mp4")], []

    def say(*line):
        said.append(line)

    found = placement.place(sources, Sampling(), tmp_path, Work(), say)
    assert [len(names) for names, _ in given] == [10, 16]
    assert [start for _, start in given] == [None, 7]
    added = sorted(number(name) for name in set(given[1][0]) - set(given[0][0]))
    assert added == [43, 47, 53, 57, 63, 67]  # thrice as many a second, from 4 to 7 s
    assert found["not_placed"] == ["frame_00020.jpg"]
    assert found["lost"] == [{"video": "walk.mp4", "from": 1.0, "to": 3.0, "frames": 1}]
    assert len(pycolmap.Reconstruction(str(tmp_path / "sparse" / "0")).images) == 15
    assert any(what == "video" and "not placed" in line for what, line in said)


def test_the_end_of_a_video_that_stays_unplaced_is_told(scripted, tmp_path):
    placing, given = scripted
    sources = [Source(tmp_path / "walk.mp4")]
    placing += [lambda name, last=last: number(name) < last for last in (65, 70, 70)]
    found = placement.place(sources, Sampling(), tmp_path / "a", Work(), lambda *_: None)
    assert len(given) == 3  # twice denser, at most
    assert found["lost"] == [{"video": "walk.mp4", "from": 6.9, "to": 9.0, "frames": 19}]
    placing += [lambda name: number(name) < 61] * 2
    found = placement.place(sources, Sampling(), tmp_path / "b", Work(), lambda *_: None)
    assert len(given) == 5  # denser frames were not placed either
    assert found["lost"] == [{"video": "walk.mp4", "from": 6.0, "to": 9.0, "frames": 3}]


def test_what_was_placed_first_is_kept_where_denser_frames_are_not_or_time_is_over(
    scripted, tmp_path
):
    placing, given = scripted
    sources = [Source(tmp_path / "walk.mp4")]
    placing += [lambda name: number(name) < 65, failures.ROTATES]
    found = placement.place(sources, Sampling(), tmp_path / "a", Work(), lambda *_: None)
    assert (len(given), found["frames"], len(found["placed"])) == (2, 10, 7)
    placing += [lambda name: number(name) < 65]
    work = Work(time=SearchTime(0.0))
    found = placement.place(sources, Sampling(), tmp_path / "b", work, lambda *_: None)
    assert (len(given), len(found["placed"]), found["stopped"]) == (3, 7, True)
    assert "--pose-time" in placement.notes(found)[0]


def test_the_search_for_more_ends_some_time_after_the_first_try(monkeypatch):
    now = iter([100.0, 150.0, 150.0, 299.0, 150.0, 110.0, 115.0])
    monkeypatch.setattr(search_time.time, "monotonic", lambda: next(now))
    limit = SearchTime(began=100.0)
    assert limit.left == np.inf  # the first try is not cut
    assert limit.stop == 300  # but its global mapper is, which starts after 50 s
    limit.tried()
    assert (limit.left, limit.stop) == (1, 300)
    stated = SearchTime(500.0, began=100.0)
    assert stated.stop == 600
    assert SearchTime(20.0, began=100.0).stop == 170  # it has a minute
    stated.tried()
    assert (stated.left, stated.stop) == (485, 600)


def test_of_frames_that_overlap_the_sharpest_are_taken(tmp_path):
    """Forty frames, of which the first twenty hardly move, and each next one by 5 %."""
    wall = np.random.default_rng(0).integers(0, 255, (12, 120, 3), np.uint8)
    wall = cv2.resize(wall, (960, 96), interpolation=cv2.INTER_CUBIC)
    at = [*range(20), *range(20, 180, 8)]
    image_files.write(
        np.array([wall[:, left : left + 160] for left in at]),
        tmp_path,
        [shot.name for shot in shots(*range(40))],
    )
    taken = [SampledFrame(i, i / 10, float(i == 7)) for i in range(40)]
    kept = [shot.index for shot in sampling._overlapping(taken, tmp_path, 20)]
    assert 20 <= len(kept) < 30
    assert 7 in kept
    assert set(range(22, 39)) <= set(kept)
    assert len(list(tmp_path.iterdir())) == len(kept)
    assert sampling._overlapping(taken[:9], tmp_path, 20) == taken[:9]


def test_what_is_like_the_last_frame_is_lost_with_it(scripted, tmp_path, monkeypatch):
    """The end is black: of its frames, at 7, 8 and 9 s, the first alone is taken."""
    placing, _ = scripted
    monkeypatch.setattr(sampling, "duplicates", lambda small: np.arange(len(small)) < 8)
    placing += [lambda name: number(name) < 70]
    sources = [Source(tmp_path / "walk.mp4")]
    found = placement.place(sources, Sampling(), tmp_path, Work(), lambda *_: None)
    assert found["lost"] == [{"video": "walk.mp4", "from": 6.0, "to": 9.0, "frames": 1}]
    placing += [lambda name: number(name) < 70]  # and as an earlier run kept it
    again = placement.place(sources, Sampling(), tmp_path, Work(), lambda *_: None)
    assert again["lost"] == found["lost"]


def test_a_known_cause_ends_it_at_once_and_an_unknown_one_after_denser_frames(scripted, tmp_path):
    placing, given = scripted
    walk = tmp_path / "walk.mp4"
    placing += [failures.STANDS]
    with pytest.raises(ValueError, match=r"walk\.mp4: COLMAP placed 0 frames: .*does not move"):
        placement.place([Source(walk)], Sampling(), tmp_path / "a", Work(), lambda *_: None)
    assert len(given) == 1
    placing += ["", "", ""]
    with pytest.raises(ValueError, match=r"too little in common.*as of a slower walk"):
        placement.place([Source(walk)], Sampling(), tmp_path / "b", Work(), lambda *_: None)
    assert [len(names) for names, _ in given] == [10, 10, 28, 82]


def test_what_was_taken_before_an_interruption_is_not_taken_again(scripted, tmp_path, monkeypatch):
    placing, given = scripted
    sources = [Source(tmp_path / "walk.mp4")]
    placing += [lambda name: number(name) < 70]
    with pytest.raises(IndexError):  # in the second run of COLMAP
        placement.place(sources, Sampling(), tmp_path, Work(), lambda *_: None)
    placing += [lambda name: True]
    monkeypatch.setattr(video, "thin", lambda *_, **__: pytest.fail("was taken again"))
    placement.place(sources, Sampling(), tmp_path, Work(), lambda *_: None)
    assert given[-1][0] == given[-2][0]
    assert len(given[-1][0]) > 10


def test_a_pause_is_thinned_and_a_film_that_stands_is_refused(scripted, tmp_path, monkeypatch):
    placing, given = scripted
    placing += [lambda name: True]
    sources = [Source(tmp_path / "walk.mp4")]
    monkeypatch.setattr(sampling, "duplicates", lambda small: np.arange(len(small)) % 10 < 4)
    found = placement.place(sources, Sampling(), tmp_path / "a", Work(), lambda *_: None)
    assert found["still"] == 6
    assert [number(name) for name in given[0][0]] == [0, 10, 20, 30]
    assert len(list((tmp_path / "a" / "images").iterdir())) == 4
    monkeypatch.setattr(sampling, "duplicates", lambda small: np.arange(len(small)) < 1)
    with pytest.raises(ValueError, match=r"9 of 10 frames repeat.*camera does not move"):
        placement.place(sources, Sampling(), tmp_path / "b", Work(), lambda *_: None)


def database(path, keypoints, shift, config, parallax=0.0):
    """Five images, all pairs verified, matches `shift` pixels apart and the near ones farther."""
    size = {"width": 480, "height": 270}
    with pycolmap.Database.open(str(path)) as stored:
        camera = pycolmap.Camera(model="SIMPLE_PINHOLE", **size, params=[400, 240, 135])
        camera.camera_id = stored.write_camera(camera)
        rng, ids = np.random.default_rng(0), []
        xy = rng.uniform(0, 270, (keypoints, 2)).astype(np.float32)
        near = parallax * rng.uniform(0, 1, keypoints)
        for at in range(5):
            image = pycolmap.Image(name=f"{at}.jpg", camera_id=camera.camera_id)
            ids.append(stored.write_image(image))
            moved = at * np.stack([shift + near, np.zeros(keypoints)], axis=1)
            stored.write_keypoints(ids[-1], (xy + moved).astype(np.float32))
        for i in ids:
            for j in (j for j in ids if j > i):
                geometry = pycolmap.TwoViewGeometry()
                geometry.config = config
                rows = np.arange(keypoints, dtype=np.uint32)
                geometry.inlier_matches = np.stack([rows, rows], axis=1)
                stored.write_two_view_geometry(i, j, geometry)
    return path


@pytest.mark.parametrize(
    ("keypoints", "shift", "config", "said"),
    [
        (200, 0.5, "UNCALIBRATED", failures.STANDS),
        (200, 30.0, "PANORAMIC", failures.ROTATES),
        (200, 30.0, "UNCALIBRATED", ""),
        (20, 30.0, "UNCALIBRATED", failures.DARK.format(count=20)),
    ],
)
def test_causes_are_told_by_features_and_matches(keypoints, shift, config, said, tmp_path):
    kind = getattr(pycolmap.TwoViewGeometryConfiguration, config)
    assert failures.cause(database(tmp_path / "d.db", keypoints, shift, kind)) == said


@pytest.mark.parametrize(
    ("shift", "parallax", "expected"), [(30.0, 0.0, True), (30.0, 8.0, False), (0.5, 0.0, False)]
)
def test_a_picture_that_slides_is_not_placed(shift, parallax, expected, tmp_path):
    """Under a drone near things move by some per cent more than far ones; one picture has none."""
    kind = pycolmap.TwoViewGeometryConfiguration.PLANAR_OR_PANORAMIC
    made = database(tmp_path / "d.db", 200, shift, kind, parallax)
    assert failures.slides(made) is expected


def test_a_second_lap_is_found_though_frames_beside_look_more_alike(monkeypatch):
    from fsel.captures.colmap import pairs

    turn = np.append(np.arange(60) * 0.02, np.arange(60) * 0.02 + 0.11)
    vectors = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    monkeypatch.setattr(pairs, "described", lambda *_: vectors)
    names = [str(i) for i in range(120)]
    chosen = runs._chosen(Path("unused"), names, [Part(range(120), True)])
    ahead = [*pairs.STEPS, 16, 32, 60, 61, 62, 63, 64]
    assert [j for i, j in chosen if i == 0] == ahead


def test_pairs_of_several_parts_are_near_in_each_and_alike_between_them(monkeypatch):
    """Two walks of 60 frames along the same 60 places: a frame's likeness is its place."""
    from fsel.captures.colmap import pairs

    turn = np.tile(np.arange(60) * 0.02, 2)
    vectors = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    monkeypatch.setattr(pairs, "described", lambda *_: vectors)
    parts = [Part(range(60), True), Part(range(60), True)]
    names = [str(i) for i in range(120)]
    chosen = set(runs._chosen(Path("unused"), names, parts))
    assert {(0, 1), (60, 61), (0, 60), (20, 80), (59, 119)} <= chosen
    assert (0, 40) not in chosen
    across = [(i, j) for i, j in chosen if i < 60 <= j]
    assert max(abs(j - 60 - i) for i, j in across) <= 8


def test_sets_are_apart_by_their_turns_in_any_worlds():
    first = Rotation.random(9, random_state=0)
    world = Rotation.random(random_state=1)
    assert placement.apart(first.as_matrix(), (first * world).as_matrix()) == pytest.approx(
        0, abs=1e-5
    )
    halves = Rotation.from_euler("z", np.repeat([[0], [20]], [5, 4], axis=0), degrees=True)
    found = placement.apart(first.as_matrix(), (first * halves * world).as_matrix())
    assert found == pytest.approx(20)  # 20 of 36 pairs are of one frame of each


@pytest.mark.parametrize("unfolds", [True, False])
def test_a_folded_path_is_placed_again_and_its_jumps_are_named(
    unfolds, scripted, tmp_path, monkeypatch
):
    """A frame a second, 9 degrees apart, of which the last five look as from the other side."""
    asked = []

    def place(raw, work, start=None):
        asked.append(list(work.breaks))
        path = ring(40)[:10]
        if not (unfolds and work.breaks):
            path[5:, :, :3] = path[5:, :, :3] @ np.diag([-1.0, 1, -1])
        return Mapped(model_of(raw.names, path))

    monkeypatch.setattr(sfm, "place", place)
    walk = [Source(tmp_path / "walk.mp4")]
    found = placement.place(walk, Sampling(), tmp_path, Work(), lambda *_: None)
    assert asked == [[], [5]]
    said = placement.doubts(found)
    if unfolds:
        assert (found["jumps"], said) == ([], [])
    else:
        assert [jump["name"] for jump in found["jumps"]] == ["frame_00050.jpg"]
        assert found["jumps"][0]["degrees"] > 140
        assert "4.0 to 5.0 s" in said[0]


def test_matches_across_a_break_are_removed_but_those_of_neighbours(tmp_path, monkeypatch):
    made = database(tmp_path / "d.db", 20, 30.0, pycolmap.TwoViewGeometryConfiguration.CALIBRATED)
    monkeypatch.setattr(mapping, "OVERLAP", 1)
    mapping.separate(made, [f"{i}.jpg" for i in range(5)], [2])
    left = {pair.images for pair in failures.verified_pairs(made)}
    assert left == {(1, 2), (2, 3), (3, 4), (3, 5), (4, 5)}  # numbers begin at 1


def pairs_of_three():
    """Poses of three frames, and 50 matches of each pair of them."""
    poses, points = ring(12)[:3], np.random.default_rng(0).uniform(-1, 1, (50, 3))
    local = [points @ pose[:, :3].T + pose[:, 3] for pose in poses]
    places = [xyz[:, :2] / xyz[:, 2:] + 0.5 for xyz in local]  # the focal length is the side
    pairs = [
        failures.VerifiedPair((i + 1, j + 1), (places[i], places[j]), False)
        for i, j in ((0, 1), (0, 2), (1, 2))
    ]
    return poses, pairs


def test_matches_agree_with_the_poses_that_they_were_seen_from():
    poses, pairs = pairs_of_three()
    assert mapping.agreeing(model_of("abc", poses), pairs) == 150
    assert mapping.agreeing(model_of("ab", poses), pairs) == 50  # the third was not placed
    poses[2, 1, 3] += 1
    assert 50 <= mapping.agreeing(model_of("abc", poses), pairs) < 70


def test_steps_of_the_global_mapper_are_read_from_its_log(tmp_path, monkeypatch):
    log, said = tmp_path / "log.txt", iter(["", "one done in 1 s\n", "two done in 2 s\nthe third"])

    class Process:
        def poll(self):
            if (text := next(said, None)) is None:
                return 0
            with log.open("a") as file:
                file.write(text)

    monkeypatch.setattr(mapping, "WAIT", 0)
    assert list(mapping._steps(Process(), log, np.inf)) == [0, 1]


@pytest.mark.parametrize(
    ("frames", "globally", "incrementally", "kept", "other"),
    [
        (3, "abc", None, "global", None),  # nothing is left to explain: the other one is not asked
        (4, "abc", "abc", "global", 3),  # one of four is not placed
        (3, "ab", "abc", "incremental", 2),
        (3, "ab", "a", "global", 1),
        (3, "ab", "", "global", 0),
        (3, "", "ab", "incremental", 0),
        (3, "", "", None, None),
    ],
)
def test_what_one_mapper_leaves_unexplained_is_given_to_the_other(
    frames, globally, incrementally, kept, other, tmp_path, monkeypatch
):
    poses, pairs = pairs_of_three()

    def made(names):
        return [model_of(names, poses[: len(names)])] if names else []

    monkeypatch.setattr(mapping, "verified_pairs", lambda _: pairs)
    monkeypatch.setattr(mapping, "_globally", lambda *_: made(globally))
    monkeypatch.setattr(mapping, "_incrementally", lambda *_: made(incrementally))
    found = mapping.build(tmp_path / "database.db", tmp_path, frames, Work())
    assert (found and found.by) == kept
    assert (found and found.other and found.other.num_reg_images()) == other


@pytest.mark.parametrize(
    ("other", "said"),
    [
        (None, []),
        ({"placed": 10, "degrees": 0.3}, []),
        ({"placed": 5, "degrees": 2.9}, []),
        ({"placed": 9, "degrees": 36.7}, ["poses differ by 37 degrees"]),
        ({"placed": 0, "degrees": None}, ["one places 0 frames, the other 10"]),
    ],
)
def test_doubts_are_of_mappers_that_differ(other, said):
    found = placement.doubts({"placed": ["a.jpg"] * 10, "other": other})
    assert [part in doubt for part, doubt in zip(said, found, strict=True)] == [True] * len(said)
