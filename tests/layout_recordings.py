"""A small recording made by hand, as each layout's writer takes it."""

import json
import shutil

import cv2
import numpy as np
from scipy.spatial.transform import Rotation
from small_captures import write_video

from fsel.captures.colmap.camera import Camera
from fsel.captures.images import files as image_files
from fsel.captures.layouts import LAYOUTS, colmap
from fsel.captures.layouts.contract import Recording
from fsel.core.geometry import invert_pose
from fsel.core.names import natural
from fsel.synthetic.record import project

PINHOLE = Camera("PINHOLE", 64, 48, (60.0, 60.0, 32.0, 24.0))
OPENCV = Camera("OPENCV", 64, 48, (60.0, 60.5, 32.4, 23.8, -0.05, 0.01, 3e-4, -4e-4))
FISHEYE = Camera("OPENCV_FISHEYE", 64, 48, (35.0, 35.0, 32.2, 23.9, -0.03, 0.006, -0.002, 2e-4))
SEVEN = Camera("PINHOLE", 64, 48, (58.5, 58.5, 32.0, 24.0))
WRITERS = {
    "dl3dv": OPENCV,
    "tanks_and_temples": PINHOLE,
    "mipnerf360": PINHOLE,
    "scannetpp_iphone": OPENCV,
    "scannetpp_dslr": FISHEYE,
    "seven_scenes": SEVEN,
    "scannet": PINHOLE,
    "co3d": PINHOLE,
    "colmap": OPENCV,
    "nerfstudio": FISHEYE,
}
DROPPED = {
    "colmap": [4],
    "tanks_and_temples": [4],
    "scannetpp_iphone": [4],
    "scannetpp_dslr": [7, 19],
    "scannet": [4],
    "co3d": [4],
}
MASKED = ("scannetpp_dslr", "scannet", "co3d")
READING = {"scannet": {"instance": 1}}


def recording(layout, frames=22, seed=0):
    """Cameras around a cloud of points, smooth images, one lost and one bad frame."""
    rng = np.random.default_rng(seed)
    camera = WRITERS[layout]
    xyz = rng.uniform(-1, 1, (60, 3))
    rotation = Rotation.random(frames, rng=rng).as_matrix()
    poses = np.concatenate([rotation, np.tile([[0.0], [0.0], [4.0]], (frames, 1, 1))], axis=2)
    point, frame, xy = [], [], []
    for i, pose in enumerate(poses):
        uv = project(camera, xyz @ pose[:, :3].T + pose[:, 3])
        seen = np.flatnonzero(((uv > 1) & (uv < [63, 47])).all(axis=1))
        point += seen.tolist()
        frame += [i] * len(seen)
        xy.append(uv[seen])
    small = rng.integers(0, 255, (frames, 6, 8, 3), dtype=np.uint8)
    images = np.stack([cv2.resize(s, (64, 48), interpolation=cv2.INTER_CUBIC) for s in small])
    several = layout == "seven_scenes"
    names = [
        f"seq-0{1 + i % 2}/frame-{i // 2:06d}" if several else f"f{i + 7}" for i in range(frames)
    ]
    order = sorted(range(frames), key=lambda i: natural(names[i]))
    flags = np.zeros((2, frames), bool)
    flags[0, 7], flags[1, 4] = True, True
    return Recording(
        names=tuple(names[i] for i in order),
        world_to_camera=poses,
        camera=camera,
        images=images,
        depth=np.full((frames, 48, 64), 4, np.float32),
        xyz=xyz,
        rgb=rng.integers(0, 255, (60, 3), dtype=np.uint8),
        track_point=np.array(point),
        track_frame=np.array(frame),
        track_xy=np.concatenate(xy),
        sequences=tuple(names[i].split("/")[0] if several else "a" for i in order),
        bad=flags[0],
        lost=flags[1],
        objects=discs(frames) if layout in MASKED else None,
    )


def write_recording(layout, folder, frames=22):
    """Write a recording in a layout, and return it."""
    made = recording(layout, frames)
    LAYOUTS[layout].write(made, folder)
    return made


def write_film(made, folder):
    """An iPhone capture of ScanNet++ whose frames were not extracted from their video."""
    LAYOUTS["scannetpp_iphone"].write(made, folder)
    root = folder / "iphone"
    rename = {name: f"frame_{i:06d}" for i, name in enumerate(made.names)}
    metric = json.loads((root / "pose_intrinsic_imu.json").read_text())
    renamed = {rename[name]: entry for name, entry in metric.items()}
    (root / "pose_intrinsic_imu.json").write_text(json.dumps(renamed))
    path = root / "nerfstudio" / "transforms.json"
    content = json.loads(path.read_text())
    for frame in content["frames"]:
        stem = frame["file_path"].removesuffix(".jpg")
        frame["file_path"] = f"video/{rename[stem]}.jpg"
    path.write_text(json.dumps(content))
    shutil.rmtree(root / "rgb")
    shutil.rmtree(root / "colmap")
    write_video(root / "rgb.mkv", made.images, 60, "FFV1")


def discs(frames):
    """A disc that wanders over the frames, before another object above it."""
    rows, columns = np.mgrid[:48, :64]
    x = np.linspace(16, 48, frames)[:, None, None]
    disc = (columns - x) ** 2 + (rows - 24) ** 2 < 100
    return np.where(disc, 1, np.where(rows < 20, 2, 0)).astype(np.uint8)


def full(pose):
    """(4, 4) camera-to-world of a (3, 4) world-to-camera."""
    return np.vstack([invert_pose(pose), [0, 0, 0, 1]])


def write_colmap(made, folder, names=None, text=True, camera=PINHOLE):
    names = names or [f"{name}.png" for name in made.names]
    image_files.write(made.images, folder / "images", names)
    colmap.write_sparse(made, camera, names, folder / "sparse" / "0", text=text)
    return names
