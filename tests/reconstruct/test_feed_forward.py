"""Feed-forward models through `ffgs`, on the CPU: placement, order, frames, refusals."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation
from selection_problems import around, numbered
from small_captures import ring

try:
    import ffgs
except (ImportError, RuntimeError) as error:  # a torchvision for another torch raises the latter
    pytest.skip(
        f"ffgs does not work here ({error}); pip install 'fsel[feed_forward]'",
        allow_module_level=True,
    )

from feed_forward_toy import Toy, ToyProcessor

from fsel.core.geometry import invert_pose
from fsel.core.programs.outcome import FAILED, Unfinished
from fsel.reconstruct import check_needs, reconstructor_of
from fsel.reconstruct.external import External
from fsel.reconstruct.external.worker import close_all
from fsel.reconstruct.feed_forward import FeedForward
from fsel.reconstruct.gaussians.model import GaussianModel
from fsel.reconstruct.normalisation import Frame

FRAMES, SIZE = 8, (24, 18)
# from the world to the toy's frame
TURN = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix()
SCALE, SHIFT = 0.37, np.array([5.0, -2, 1])


def ring_capture(poses=None):
    """Frames that carry their number in the top left pixel."""
    return numbered(around(ring(FRAMES) if poses is None else poses, size=SIZE))


def world_gaussians(degree, count=30):
    rng = np.random.default_rng(degree)
    opacity = rng.uniform(0.3, 0.9, count)
    return {
        "means": rng.uniform(-1, 1, (count, 3)),
        "scales": rng.uniform(0.05, 0.4, (count, 3)),
        "quats": Rotation.random(count, rng=rng).as_quat(scalar_first=True),
        "opacities": opacity,
        "colors": rng.normal(0, 0.3, (count, (degree + 1) ** 2, 3)),
    }


def rendered_truth(gaussians, views):
    """What the rasteriser makes of Gaussians where they are in the world."""
    table = np.column_stack(
        [
            gaussians["means"],
            np.log(gaussians["scales"]),
            gaussians["quats"],
            np.log(gaussians["opacities"] / (1 - gaussians["opacities"])),
            gaussians["colors"].reshape(len(gaussians["means"]), -1),
        ]
    )
    frame = Frame(np.zeros(3), 1.0)
    return GaussianModel(frame, table.astype(np.float32), np.zeros(3, np.float32)).render(views)


def save_toy(folder, capture, gaussians, noise=0.0, sign=1):
    """A toy that has learned the capture's cameras, in a frame of its own; mirrored: sign -1."""
    c2w = invert_pose(capture.world_to_camera)
    model = Toy(len(capture), len(gaussians["means"]), gaussians["colors"].shape[1])
    poses = np.tile(np.eye(4), (len(capture), 1, 1))
    poses[:, :3, :3] = TURN @ c2w[:, :, :3]
    poses[:, :3, 3] = sign * SCALE * c2w[:, :, 3] @ TURN.T + SHIFT
    poses[:, :3, 3] += noise * np.random.default_rng(0).normal(size=(len(capture), 3))
    turned = Rotation.from_matrix(TURN) * Rotation.from_quat(gaussians["quats"], scalar_first=True)
    colors = torch.from_numpy(gaussians["colors"])
    degree = round(colors.shape[1] ** 0.5) - 1
    learned = {
        "poses": poses,
        "means": SCALE * gaussians["means"] @ TURN.T + SHIFT,
        "scales": SCALE * gaussians["scales"],
        "quats": turned.as_quat(scalar_first=True),
        "opacities": gaussians["opacities"],
        "colors": ffgs.geometry.rotate_sh(colors[None], torch.from_numpy(TURN)[None], degree)[0],
    }
    for name, value in learned.items():
        getattr(model, name).copy_(torch.as_tensor(value))
    ffgs.GSPipeline(model, ToyProcessor()).save_pretrained(folder)
    return str(folder)


@pytest.mark.parametrize("degree", [0, 3, 4])
def test_a_pose_free_model_is_placed_among_the_given_cameras(tmp_path, degree):
    capture, gaussians = ring_capture(), world_gaussians(degree)
    model = save_toy(tmp_path, capture, gaussians)
    frames, target = np.array([6, 0, 3]), np.array([4, 7])
    fitted = FeedForward(capture, model=model, device="cpu").fit(frames)
    assert (fitted.primitives, fitted.device) == (30, "cpu")
    images, truth = (
        fitted.render(capture.view(target)),
        rendered_truth(gaussians, capture.view(target)),
    )
    assert truth.std() > 0.1
    np.testing.assert_allclose(images, truth, atol=2e-3)


def test_far_from_the_origin_nothing_is_lost(tmp_path):
    poses = ring(FRAMES)
    poses[:, :, 3] -= np.einsum("nij,j->ni", poses[:, :, :3], np.array([2e6, -3e6, 1e6]))
    capture, near, gaussians = ring_capture(poses), ring_capture(), world_gaussians(1)
    model = save_toy(tmp_path, near, gaussians)
    fitted = FeedForward(capture, model=model, device="cpu").fit(np.arange(4))
    truth = rendered_truth(gaussians, near.view(np.array([5])))
    np.testing.assert_allclose(fitted.render(capture.view(np.array([5]))), truth, atol=2e-3)


def test_other_frames_are_not_looked_at(tmp_path):
    capture = ring_capture()
    model = save_toy(tmp_path, capture, world_gaussians(1), noise=0.05)
    black = np.asarray(capture.images).copy()
    black[4:] = 0
    reconstruct = [
        FeedForward(seen, model=model, device="cpu").fit(np.arange(4)).render(capture.view([6]))
        for seen in (capture, replace(capture, images=black))
    ]
    np.testing.assert_array_equal(*reconstruct)


def test_cameras_that_no_similarity_places_are_an_outcome(tmp_path):
    capture = ring_capture()
    model = save_toy(tmp_path, capture, world_gaussians(0), sign=-1)
    with pytest.raises(Unfinished, match="do not fit the predicted cameras") as failure:
        FeedForward(capture, model=model, device="cpu").fit(np.arange(4))
    assert failure.value.outcome == FAILED


def tokengs(folder):
    """A small TokenGS with random weights: it takes the given cameras."""
    from ffgs.models.tokengs.modeling import TokenGS
    from ffgs.models.tokengs.processing import TokenGSProcessor

    torch.manual_seed(0)
    model = TokenGS(
        enc_depth=1,
        dec_depth=1,
        enc_embed_dim=32,
        enc_num_heads=2,
        token_dim=32,
        num_gs_tokens=5,
        opacity_bias=-1,
        clip_head_readout_std=0.3,
        gs_token_std=1,
    )
    processor = TokenGSProcessor(image_shape=[16, 24])
    ffgs.GSPipeline(model, processor).save_pretrained(folder)
    return str(folder)


def moved(capture, turn, scale, shift):
    """The same capture in a world that is turned, scaled and shifted."""
    rotation = capture.world_to_camera[:, :, :3] @ turn.T
    offset = scale * capture.world_to_camera[:, :, 3] - rotation @ shift
    return replace(capture, world_to_camera=np.concatenate([rotation, offset[..., None]], axis=2))


def test_a_real_architecture_moves_with_the_world(tmp_path):
    capture = ring_capture()
    settings = {"model": tokengs(tmp_path), "device": "cpu"}
    frames, target = np.array([1, 5, 2]), np.array([0, 3])
    fitted = FeedForward(capture, **settings).fit(frames)
    assert fitted.primitives == 5 * 8 * 8
    images = fitted.render(capture.view(target))
    assert images.shape == (2, 18, 24, 3)
    assert images.std() > 0.01
    np.testing.assert_array_equal(
        FeedForward(capture, **settings).fit(frames[::-1]).render(capture.view(target)), images
    )
    other = moved(capture, TURN, 40.0, np.array([3.0, 900, -20]))
    again = FeedForward(other, **settings).fit(frames).render(other.view(target))
    np.testing.assert_allclose(again, images, atol=5e-3)


def test_what_is_missing_is_refused_before_work(tmp_path, monkeypatch):
    monkeypatch.setenv("HF_HUB_CACHE", str(tmp_path))
    section = {"name": "feed_forward"}
    with pytest.raises(
        ValueError, match=r"weights of anysplat/default are not in the cache.*hf down"
    ):
        check_needs({**section, "settings": {"device": "cpu"}})
    absent = {"model": "tokengs/dl3dv-2v", "weights": "w.pt", "device": "cpu"}
    with pytest.raises(ValueError, match=r"no file w.pt. Hint: `hf download jiaweir/tokengs"):
        check_needs({**section, "settings": absent})
    with pytest.raises(
        ValueError, match=r"neither a folder nor in the zoo of ffgs; allowed: anysp"
    ):
        check_needs({**section, "settings": {"model": "nobody/nothing"}})
    with pytest.raises(ValueError, match=r"model: .*config.json is missing"):
        check_needs({**section, "settings": {"model": str(tmp_path)}})


def test_weights_of_another_file_are_refused(tmp_path):
    wrong = tmp_path / "weights.safetensors"
    wrong.write_bytes(b"nothing")
    settings = {"model": "tokengs/dl3dv-base", "weights": str(wrong), "device": "cpu"}
    reconstructor = reconstructor_of(
        ring_capture(), {"name": "feed_forward", "long_side": 24, "settings": settings}
    )
    with pytest.raises(ValueError, match=r"sha256 is .*; the zoo of ffgs states ac6cb611"):
        reconstructor.fit(np.arange(3))


@pytest.mark.skipif(torch.cuda.is_available(), reason="asks what is said where no GPU is")
def test_a_gpu_that_is_not_there_is_refused(tmp_path):
    settings = {"model": save_toy(tmp_path, ring_capture(), world_gaussians(0))}
    with pytest.raises(
        ValueError, match=r"device is cuda, and torch .* finds no GPU. Hint: device"
    ):
        check_needs({"name": "feed_forward", "settings": settings})


# runs a recipe where the toy is registered
REGISTERED = """
import runpy, sys
sys.path.append({here!r})
import feed_forward_toy
sys.argv = sys.argv[1:]
runpy.run_path(sys.argv[0], run_name="__main__")
"""


def test_a_model_in_a_worker_renders_the_same(tmp_path):
    capture = ring_capture()
    model = save_toy(tmp_path, capture, world_gaussians(3))
    text = REGISTERED.format(here=str(Path(__file__).parents[1]))
    words = ["{python}", "-c", text, "{recipes}/registered.py", "feed_forward", f"model={model}"]
    served, own = (
        External(capture, serve=[*words, "device=cpu"]),
        FeedForward(capture, model=model, device="cpu"),
    )
    views, frames = capture.view([4, 7]), np.array([0, 3, 6])
    images = served.fit(frames).render(views)
    close_all()
    np.testing.assert_array_equal(images, own.fit(frames).render(views))
