"""Small COLMAP captures on disk, written by pycolmap and OpenCV alone, and the command on them."""

import json
import shutil
import struct
from pathlib import Path

import cv2
import numpy as np
import pycolmap

from fsel.cli import main

SIZE = (64, 48)
PARAMS = {"PINHOLE": [60, 61, 32, 24], "OPENCV": [60, 61, 32, 24, -0.05, 0.01, 1e-3, -1e-3]}


def ring(frames, radius=4.0, height=-1.0):
    """(N, 3, 4) world-to-camera of cameras on a circle around the y axis, looking at the origin."""
    poses = []
    for turn in 2 * np.pi * np.arange(frames) / frames:
        center = np.array([radius * np.cos(turn), height, radius * np.sin(turn)])
        ahead = -center / np.linalg.norm(center)
        right = np.cross([0.0, 1, 0], ahead)
        right /= np.linalg.norm(right)
        rotation = np.stack([right, np.cross(ahead, right), ahead])
        poses.append(np.column_stack([rotation, -rotation @ center]))
    return np.array(poses)


def write_ring(folder, frames=24, model="PINHOLE", shrink=1, seed=0, cloud=80):
    """A COLMAP capture of `ring` cameras: frame_000.jpg ... and points that neighbours share.

    Args:
        model: of the camera.
        shrink: factor by which the images are smaller than the camera states.
        cloud: number of points; each is seen from a third of the circle.

    Returns:
        The poses, and (M, N) bool, which frame sees which point.
    """
    rng = np.random.default_rng(seed)
    folder = Path(folder)
    poses, xyz = ring(frames), rng.uniform(-1, 1, (cloud, 3))
    start = rng.integers(0, frames, cloud)
    seen = (np.arange(frames) - start[:, None]) % frames < max(2, frames // 3)
    built = pycolmap.Reconstruction()
    camera = pycolmap.Camera(
        camera_id=1, model=model, width=SIZE[0], height=SIZE[1], params=PARAMS[model]
    )
    built.add_camera_with_trivial_rig(camera)
    tracks = [pycolmap.Track() for _ in xyz]
    (folder / "images").mkdir(parents=True)
    for i, pose in enumerate(poses):
        rows = np.flatnonzero(seen[:, i])
        image = pycolmap.Image(
            image_id=i + 1,
            name=f"frame_{i:03d}.jpg",
            camera_id=1,
            keypoints=camera.img_from_cam(xyz[rows] @ pose[:, :3].T + pose[:, 3]),
        )
        rigid = pycolmap.Rigid3d(pycolmap.Rotation3d(pose[:, :3]), pose[:, 3])
        built.add_image_with_trivial_frame(image, rigid)
        for at, row in enumerate(rows):
            tracks[row].add_element(i + 1, at)
        noise = rng.integers(0, 255, (6, 8, 3), dtype=np.uint8)
        size = (SIZE[0] // shrink, SIZE[1] // shrink)
        picture = cv2.resize(noise, size, interpolation=cv2.INTER_CUBIC)
        cv2.imwrite(str(folder / "images" / image.name), picture)
    for point, track in zip(xyz, tracks, strict=True):
        built.add_point3D(point, track, np.array([10, 20, 30], np.uint8))
    (folder / "sparse" / "0").mkdir(parents=True)
    built.write_binary(str(folder / "sparse" / "0"))
    return poses, seen


def film(folder, change, frames=24, size=(240, 180)):
    """Write frames of one texture, larger than the camera states, each a few pixels further.

    `change` has, by the number of a frame, what is done to its picture, (h, w, 3) uint8.
    """
    rng = np.random.default_rng(0)
    wide = (size[1], size[0] + 4 * frames, 3)
    scales = [cv2.GaussianBlur(rng.normal(0, 45 * s, wide), (0, 0), s) for s in (1, 4)]
    wall = np.clip(128 + sum(scales), 20, 235).astype(np.uint8)
    for i in range(frames):
        shot = np.ascontiguousarray(wall[:, 4 * i : 4 * i + size[0]])
        shot = change[i](shot) if i in change else shot
        cv2.imwrite(str(Path(folder) / "images" / f"frame_{i:03d}.jpg"), shot)


def state_orientation(path, value):
    """Add to a JPEG the EXIF that asks for a turn, by one entry."""
    entry = struct.pack("<HHIHH", 0x0112, 3, 1, value, 0)
    inside = b"Exif\0\0" + b"II*\0" + struct.pack("<IH", 8, 1) + entry + bytes(4)
    content = path.read_bytes()
    segment = b"\xff\xe1" + struct.pack(">H", len(inside) + 2) + inside
    path.write_bytes(content[:2] + segment + content[2:])


def damage_pixels(path, size=SIZE):
    """Make a file a JPEG that no decoder takes: its second scan has other components."""
    noise = np.random.default_rng(0).integers(0, 255, size[::-1], dtype=np.uint8)
    progressive = [cv2.IMWRITE_JPEG_PROGRESSIVE, 1]
    content = bytearray(cv2.imencode(".jpg", np.dstack([noise] * 3), progressive)[1])
    first = content.index(b"\xff\xda")
    content[content.index(b"\xff\xda", first + 1) + 4] ^= 0x55
    path.write_bytes(content)


def run(*arguments):
    """Exit code of a command."""
    return main([*map(str, arguments)])


def select(*arguments):
    """That of `fsel select`; without trying selections, unless it says for how long."""
    trying = () if "--patience" in arguments else ("--patience", "0")
    return run("select", *arguments, *trying)


def record_of(out):
    return json.loads((out / "selection.json").read_text())


def opengl(pose):
    """(4, 4) camera-to-world of a world-to-camera pose, y being up and z behind in the camera."""
    return np.linalg.inv(np.vstack([pose, [0, 0, 0, 1]])) @ np.diag([1.0, -1, -1, 1])


def camera_path(folder, poses):
    """nerfstudio's camera path through world-to-camera poses."""
    views = [{"camera_to_world": opengl(pose).ravel().tolist()} for pose in poses]
    (folder / "path.json").write_text(json.dumps({"camera_path": views}))
    return folder / "path.json"


def pose_anew(folder, poses, **content):
    """Replace the COLMAP model of a ring by nerfstudio's transforms.json, with other poses."""
    shutil.rmtree(folder / "sparse")
    frames = [
        {"file_path": f"images/frame_{i:03d}.jpg", "transform_matrix": opengl(pose).tolist()}
        for i, pose in enumerate(poses)
    ]
    content = {"w": SIZE[0], "h": SIZE[1], "fl_x": 60, "frames": frames} | content
    (folder / "transforms.json").write_text(json.dumps(content))


def write_video(path, frames, rate=10.0, code="MJPG"):
    """A video of (h, w, 3) RGB frames; the code FFV1 loses nothing."""
    size = frames[0].shape[1::-1]
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*code), rate, size)
    for frame in frames:
        writer.write(np.ascontiguousarray(frame[..., ::-1]))
    writer.release()
    return path
