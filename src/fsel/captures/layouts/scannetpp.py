"""ScanNet++ v2: the DSLR's fisheye images, and the iPhone's video frames."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from fsel.captures.images import files as image_files
from fsel.captures.layouts import colmap, nerfstudio
from fsel.captures.layouts.contract import Layout, RawCapture, Recording, has_file
from fsel.captures.layouts.nerfstudio import intrinsics_of
from fsel.captures.parsing import member, numbers, read_json, text
from fsel.core.geometry import invert_pose

VALID_MASK = 250  # a mask video is compressed: 255 does not survive exactly
ROTATION = nerfstudio.OLD_APPLIED_TRANSFORM  # carried by the poses though the file does not say so


def read_dslr(folder: Path) -> RawCapture:
    """Read dslr/ without bad and test frames, its distorted images or, without these, the
    undistorted ones; of masks only 255 counts."""
    root = folder / "dslr"
    kind = "" if (root / "resized_images").is_dir() else "_undistorted"
    images_folder = f"resized{kind}_images"
    if not (root / images_folder).is_dir():
        raise FileNotFoundError(f"{root}: neither resized_images nor {images_folder} is there")
    path = root / "nerfstudio" / f"transforms{kind}.json"
    masks = f"resized{kind}_masks" if kind else "resized_anon_masks"
    raw = nerfstudio.from_json(path, root, images=images_folder, masks=masks, undo=ROTATION)
    listed = read_json(path).get("test_frames", [])
    tests = [text(frame, "file_path", path, "test_frames") for frame in listed]
    dropped = raw.dropped | dict.fromkeys(tests, "a test frame, never a candidate")
    raw = replace(raw, dropped=dropped, mask_values=(255, 255))
    if kind or not (root / "colmap" / "points3D.txt").is_file():
        return raw  # the model's observations are of the distorted images
    return colmap.with_points(raw, root / "colmap")


def write_dslr(recording: Recording, folder: Path) -> None:
    """Write a recording as a DSLR capture, every 20th frame a test frame."""
    root = folder / "dslr"
    names = recording.write_images(root / "resized_images", "JPG")
    masks = recording.write_masks(root / "resized_anon_masks")
    frames = nerfstudio.frames_of(names, recording.world_to_camera, ROTATION)
    for at, frame in enumerate(frames):
        frame["is_bad"] = bool(recording.bad[at])
        if masks:
            frame["mask_path"] = masks[at]
    content = intrinsics_of(recording.camera)
    content["frames"] = [f for i, f in enumerate(frames) if i % 20 != 19]
    content |= {"test_frames": frames[19::20], "has_mask": bool(masks)}
    colmap.write_sparse(recording, recording.camera, names, root / "colmap", text=True)
    (root / "nerfstudio").mkdir(exist_ok=True)
    (root / "nerfstudio" / "transforms.json").write_text(json.dumps(content))


def read_iphone(folder: Path) -> RawCapture:
    """Read iphone/: metric poses in pose_intrinsic_imu.json, images in rgb.mkv or in rgb/, of the
    frames that nerfstudio/transforms.json registered and does not test on."""
    root = folder / "iphone"
    path = root / "pose_intrinsic_imu.json"
    raw = nerfstudio.from_json(
        root / "nerfstudio" / "transforms.json", root, images="rgb", undo=ROTATION
    )
    metric = read_json(path)
    names = [Path(name).name for name in raw.names]  # some carry a video/ or iphone/ prefix
    stems = [Path(name).stem for name in names]
    absent = [stem for stem in stems if stem not in metric]
    if absent:
        raise ValueError(f"{path}: no entry for {absent[0]!r}")
    poses = []
    for stem in stems:
        pose = member(metric[stem], "aligned_pose", path, stem)
        poses.append(invert_pose(numbers(pose, (4, 4), path, f"aligned_pose of {stem}")))
    masks = None
    if (root / "rgb_masks").is_dir() or (root / "rgb_mask.mkv").is_file():
        masks = _stored(root / "rgb_masks", "rgb_mask.mkv", [f"{stem}.png" for stem in stems])
    unused = {f"{stem}.jpg": "not registered by COLMAP" for stem in metric.keys() - set(stems)}
    raw = replace(
        raw,
        names=names,
        images=_stored(root / "rgb", "rgb.mkv", names),
        world_to_camera=np.array(poses),
        sequences=["iphone"] * len(stems),
        masks=masks,
        mask_values=(VALID_MASK, 255),
        dropped=raw.dropped | unused,
    )
    if not (root / "colmap" / "points3D.txt").is_file():
        return raw
    return colmap.with_points(raw, root / "colmap")


def _stored(folder: Path, video: str, names: list[str]) -> list[image_files.Image]:
    """Return the images that were extracted, or the video's: frame n is called frame_00000n."""
    if folder.is_dir():
        return [folder / name for name in names]
    path = folder.with_name(video)
    if not path.is_file():
        raise FileNotFoundError(f"{path}: missing, and so is the folder {folder.name}")
    film = image_files.Video(path)
    return [image_files.VideoFrame(film, int(Path(name).stem.rsplit("_", 1)[-1])) for name in names]


def write_iphone(recording: Recording, folder: Path) -> None:
    """Write a recording as an iPhone capture whose lost frames COLMAP did not register."""
    root = folder / "iphone"
    names = recording.write_images(root / "rgb", "jpg")
    fx, fy, cx, cy = recording.camera.params[:4]
    metric = {}
    for name, pose in zip(recording.names, recording.world_to_camera, strict=True):
        full = np.vstack([invert_pose(pose), [0, 0, 0, 1]]).tolist()
        intrinsic = [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]
        metric[name] = {"pose": full, "aligned_pose": full, "intrinsic": intrinsic}
    (root / "pose_intrinsic_imu.json").write_text(json.dumps(metric))
    kept = np.flatnonzero(~recording.lost)
    poses = recording.world_to_camera[kept]
    frames = nerfstudio.frames_of([names[i] for i in kept], poses, ROTATION)
    (root / "nerfstudio").mkdir(exist_ok=True)
    content = json.dumps(intrinsics_of(recording.camera) | {"frames": frames})
    (root / "nerfstudio" / "transforms.json").write_text(content)
    colmap.write_sparse(recording, recording.camera, names, root / "colmap", lost=False, text=True)


DSLR = Layout("scannetpp_dslr", has_file("dslr/nerfstudio/transforms.json"), read_dslr, write_dslr)
IPHONE = Layout(
    "scannetpp_iphone", has_file("iphone/pose_intrinsic_imu.json"), read_iphone, write_iphone
)
