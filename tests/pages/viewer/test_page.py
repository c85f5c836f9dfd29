"""The page of a splat: its content, its script, and what a real browser draws of it."""

import base64
import gzip
import io

import cv2
import numpy as np
import pytest
from browsing import acted, needs_a_browser
from plyfile import PlyData
from small_captures import ring

import viewer_bundle
from fsel.core.capture import Capture
from fsel.pages import viewer
from fsel.reconstruct import ply
from fsel.reconstruct.gaussians import GaussianModel

SIZE = (200, 120)
FAR = np.array([3e5, -2e5, 1e5])  # of the world's origin: float32 has 0.03 left there
USED = """
await view.ready;
const tick = () => new Promise(requestAnimationFrame);
const text = (query) => document.querySelector(query).innerText;
const shown = (query) => document.querySelector(query).getBoundingClientRect().width > 0;
const canvas = view.renderer.domElement;
const place = view.cameras.corners[1]
  .reduce((sum, corner) => sum.add(corner), view.camera.position.clone().set(0, 0, 0))
  .divideScalar(5).project(view.camera);
const box = canvas.getBoundingClientRect();
const clientX = box.left + (place.x + 1) / 2 * box.width;
const clientY = box.top + (1 - place.y) / 2 * box.height;
const point = (kind) => canvas.dispatchEvent(new PointerEvent(kind, { clientX, clientY }));
point('pointermove');
await document.querySelector('.tip img').decode();
const hovered = { named: text('.tip b'), picture: document.querySelector('.tip img').naturalWidth };
point('pointerdown');
point('pointerup');
const land = async () => { do await tick(); while (view.flight); };
await land();
const flown = { at: view.at, caption: text('.caption'), photo: shown('.photo img') };
const slider = document.querySelector('.bar input');
slider.value = 25;
slider.dispatchEvent(new Event('input'));
const cut = document.querySelector('.photo img').style.clipPath;
const press = (key) => view.element.dispatchEvent(new KeyboardEvent('keydown', { key }));
press('ArrowRight');
await land();
const next = view.at;
press('Escape');
const left = { at: view.at, photo: shown('.photo') };
document.querySelector('.legend input').click();
return {
  legend: text('.legend'), hovered, flown, cut, next, left,
  hidden: Object.values(view.cameras.lines).filter((lines) => !lines.visible).length,
  wide: document.documentElement.scrollWidth - document.documentElement.clientWidth,
  fetched: performance.getEntriesByType('resource').map((entry) => entry.name)
    .filter((name) => !/^(data|blob):/.test(name)),
};
"""

DRAWN = """
await view.ready;
const drawn = async (frames) => {{
  for (let quiet = 0; quiet < frames;) {{
    await new Promise(requestAnimationFrame);
    quiet = view.spark.sorting || view.spark.dirty || view.asked ? 0 : quiet + 1;
  }}
}};
await drawn(1);
const shots = [];
for (const at of {frames}) {{
  view.fly(at, 0);
  await drawn(4);
  view.renderer.render(view.scene, view.camera);
  shots.push(view.renderer.domElement.toDataURL());
}}
return shots;
"""


def drawn(page, frames, folder):
    """What a browser draws at some cameras themselves, (n, height, width, 3) uint8."""
    shown = f"#view {{ width: {SIZE[0]}px; height: {SIZE[1]}px;"
    exact = page.replace("html, body, #view { height: 100%;", shown)
    window = (500, SIZE[1] + 200)
    shots = acted(exact, window, DRAWN.format(frames=list(map(int, frames))), folder)
    files = [base64.b64decode(shot.partition(",")[2]) for shot in shots]
    images = [cv2.imdecode(np.frombuffer(file, np.uint8), cv2.IMREAD_COLOR) for file in files]
    return np.stack(images)[..., ::-1]


@pytest.fixture(scope="module")
def capture():
    """Six frames around the origin, principal point aside, far from the world's origin."""
    poses = ring(6)
    poses[:, :, 3] -= poses[:, :, :3] @ FAR
    rng = np.random.default_rng(0)
    return Capture(
        world_to_camera=poses,
        intrinsics=np.tile([170.0, 160.0, 120.0, 50.0], (6, 1)),
        names=tuple(f"<{i}>.jpg" for i in range(6)),
        images=rng.integers(0, 256, (6, SIZE[1], SIZE[0], 3), np.uint8),
        sequences=("",) * 6,
    )


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    """A .ply of flat and round Gaussians, faint and opaque, some behind and beside the cameras.

    Their colours lie in 0..1, as trained ones do mostly: a screen cuts each layer off there.
    """
    rng, n = np.random.default_rng(1), 600
    cloud = ply.Cloud(
        xyz=FAR + rng.normal(0, 1, (n, 3)) * np.where(rng.random((n, 1)) < 0.1, 5, 1),
        harmonics=np.concatenate(
            [rng.uniform(-1, 1, (n, 1, 3)), rng.normal(0, 0.06, (n, 15, 3))], axis=1
        ),
        logit=rng.normal(0, 2.5, n),
        log_scale=np.log(rng.uniform(0.01, 0.4, (n, 3))),
        turn=rng.normal(0, 1, (n, 4)),
        background=np.array([0.2, 0.5, 0.3], np.float32),
    )
    file = tmp_path_factory.mktemp("model") / "model.ply"
    ply.write(file, cloud)
    return file


@pytest.fixture(scope="module")
def cloud(model):
    return ply.read(model)


@pytest.fixture(scope="module")
def cameras(capture):
    states = ("pick", "held", "left", "bad", "left", "pick")
    return [
        viewer.ViewerCamera(name, state, f"is {state}", cv2.imencode(".jpg", image)[1].tobytes())
        for name, state, image in zip(capture.names, states, capture.images, strict=True)
    ]


@pytest.fixture(scope="module")
def page(capture, cameras, cloud):
    return viewer.page("<splat>", viewer.scene(capture, cameras, cloud))


def test_the_cloud_in_a_page_is_the_model_around_the_middle_of_the_scene(capture, cameras, cloud):
    content = viewer.scene(capture, cameras, cloud)
    data = gzip.decompress(base64.b64decode(content["model"]))
    vertices = PlyData.read(io.BytesIO(data))["vertex"].data
    xyz = np.stack([vertices[name] for name in "xyz"], axis=1)
    np.testing.assert_allclose(xyz + content["origin"], cloud.xyz, atol=1e-5)
    np.testing.assert_allclose(vertices["opacity"], cloud.logit, rtol=3e-4)
    np.testing.assert_allclose(vertices["f_rest_1"], cloud.harmonics[:, 2, 0], rtol=3e-4)


def test_cameras_see_the_same_pixels_from_around_the_origin(capture, cameras, cloud):
    content = viewer.scene(capture, cameras, cloud)
    point = FAR + [0.3, 0.2, -0.1]
    for pose, entry in zip(capture.world_to_camera, content["cameras"], strict=True):
        moved = np.reshape(entry["pose"], (3, 4))
        seen = moved[:, :3] @ (point - content["origin"]) + moved[:, 3]
        np.testing.assert_allclose(seen, pose[:, :3] @ point + pose[:, 3], atol=1e-4)
    assert content["extent"] == pytest.approx(np.hypot(4, 1), rel=1e-3)


def test_points_are_shown_where_there_is_no_model(capture, cameras):
    points = viewer.SparsePoints(
        capture.centers, np.full((6, 3), 200, np.uint8), np.arange(0), np.arange(0)
    )
    content = viewer.scene(capture, cameras, None, points)
    assert content["model"] is None
    shown = np.add(content["points"]["xyz"], content["origin"])
    np.testing.assert_allclose(shown, capture.centers, atol=1e-4)


def test_the_script_is_of_these_sources_and_has_its_packages_licences():
    head, _, _ = viewer.SCRIPT.read_text(encoding="utf-8").partition("*/")
    assert head.split()[1] == viewer_bundle.mark()
    assert head.count("Permission is hereby granted, free of charge") == len(viewer_bundle.LICENSED)


@needs_a_browser
def test_a_browser_draws_what_the_library_renders(page, capture, model, tmp_path):
    frames = np.array([0, 2, 4])
    pictures = drawn(page, frames, tmp_path)
    rendered = GaussianModel.read_ply(model).render(capture.view(frames))
    errors = np.mean((pictures / 255 - rendered) ** 2, axis=(1, 2, 3))
    assert (-10 * np.log10(errors) >= 38).all()


@needs_a_browser
@pytest.mark.parametrize("width", [1280, 500])
def test_cameras_are_named_flown_to_and_compared_with_their_photos(page, width, tmp_path):
    seen = acted(page, (width, 800), USED, tmp_path)
    assert [line.strip() for line in seen["legend"].split("\n")][:4] == [
        "picked 2",
        "held out 1",
        "left out 2",
        "bad 1",
    ]
    assert seen["hovered"] == {"named": "<1>.jpg", "picture": SIZE[0]}
    assert seen["flown"] == {"at": 1, "caption": "<1>.jpg: is held", "photo": True}
    assert (seen["cut"], seen["next"]) == ("inset(0px 75% 0px 0px)", 2)
    assert seen["left"] == {"at": None, "photo": False}
    assert (seen["hidden"], seen["wide"], seen["fetched"]) == (1, 0, [])
