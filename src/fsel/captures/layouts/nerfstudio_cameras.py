"""Cameras as transforms.json states them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fsel.captures.colmap.camera import Camera
from fsel.captures.parsing import number

DISTORTION = ("k1", "k2", "p1", "p2")
FISHEYE = ("k1", "k2", "k3", "k4")
LISTED = ("k1", "k2", "k3", "k4", "p1", "p2")  # order of distortion_params
PERSPECTIVE = ("SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV")
SIMPLE = ("SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE")
STRAIGHT = ("SIMPLE_PINHOLE", "PINHOLE")  # cameras without distortion
COEFFICIENTS = {
    **dict.fromkeys(STRAIGHT, ()),
    **dict.fromkeys(("SIMPLE_RADIAL", "SIMPLE_RADIAL_FISHEYE"), ("k1",)),
    **dict.fromkeys(("RADIAL", "RADIAL_FISHEYE"), ("k1", "k2")),
    "OPENCV": DISTORTION,
    "OPENCV_FISHEYE": FISHEYE,
}
"""Camera models that nerfstudio has too, and its names of their coefficients."""
LENGTHS = ("w", "h", "fl_x", "fl_y", "cx", "cy", "camera_angle_x")


def camera_of(content: dict, frame: dict, path: Path) -> Camera:
    """The camera of a frame; a top-level value wins over the frame's, as in nerfstudio.

    Raises:
        ValueError: for missing intrinsics, or a model that is no perspective camera.
    """
    merged = {key: value for key, value in {**frame, **content}.items() if value is not None}
    merged |= {
        key: number(merged[key], path, f"{key} of {frame['file_path']}")
        for key in (*LENGTHS, *LISTED)
        if key in merged
    }
    width, height = merged.get("w"), merged.get("h")
    focal = merged.get("fl_x")
    angle = merged.get("camera_angle_x")
    if angle is not None and not 0 < angle < np.pi:
        raise ValueError(
            f"{path}: camera_angle_x of {frame['file_path']} is {angle:g}; allowed: radians "
            "between 0 and pi"
        )
    if focal is None and angle is not None and width:
        focal = 0.5 * width / np.tan(angle / 2)
    if not (width and height and focal):
        raise ValueError(
            f"{path}: intrinsics of {frame['file_path']} are missing; need w, h and fl_x "
            "(or camera_angle_x), at the top level or in the frame"
        )
    cx, cy = merged.get("cx", width / 2), merged.get("cy", height / 2)
    pinhole = (float(focal), float(merged.get("fl_y", focal)), float(cx), float(cy))
    size = (int(width), int(height))
    return _with_distortion(merged, pinhole, size, path)


def _with_distortion(
    merged: dict, pinhole: tuple[float, ...], size: tuple[int, int], path: Path
) -> Camera:
    stated = merged.get("distortion_params") or []
    if not isinstance(stated, list) or len(stated) > len(LISTED):
        raise ValueError(
            f"{path}: distortion_params must be a list of up to {len(LISTED)} numbers "
            f"({', '.join(LISTED)}), got {repr(stated)[:80]}"
        )
    listed = {
        key: number(entry, path, f"distortion_params ({key})")
        for key, entry in zip(LISTED, stated, strict=False)
    }
    value = {key: float(merged.get(key, listed.get(key, 0.0))) for key in LISTED}
    model = merged.get("camera_model", "OPENCV")
    if model == "OPENCV_FISHEYE":
        return Camera(model, *size, (*pinhole, *(value[key] for key in FISHEYE)))
    if model not in PERSPECTIVE:
        allowed = ", ".join((*PERSPECTIVE, "OPENCV_FISHEYE"))
        raise ValueError(f"{path}: camera_model is {model!r}; allowed: {allowed}")
    if value["k4"]:
        raise ValueError(f"{path}: k4 is {value['k4']}; only a fisheye camera has it")
    extra = tuple(value[key] for key in DISTORTION)
    if value["k3"]:
        return Camera("FULL_OPENCV", *size, (*pinhole, *extra, value["k3"], 0.0, 0.0, 0.0))
    if any(extra):
        return Camera("OPENCV", *size, (*pinhole, *extra))
    return Camera("PINHOLE", *size, pinhole)


def intrinsics_of(camera: Camera) -> dict:
    """The intrinsic keys of a camera of a model in `COEFFICIENTS`."""
    simple = camera.model in SIMPLE
    params = (camera.params[0], *camera.params) if simple else camera.params
    keys = ("fl_x", "fl_y", "cx", "cy", *COEFFICIENTS[camera.model])
    return {
        "camera_model": "OPENCV_FISHEYE" if "FISHEYE" in camera.model else "OPENCV",
        "w": camera.width,
        "h": camera.height,
        **dict(zip(keys, params, strict=True)),
    }
