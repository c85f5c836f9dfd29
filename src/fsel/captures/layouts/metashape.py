"""Metashape's cameras in XML: sensors, and cameras in their chunk's or component's world."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from fsel.captures.colmap.camera import Camera, brown
from fsel.captures.layouts.contract import Layout, RawCapture, one_pass
from fsel.captures.layouts.exports import images_of, marked, near_origin, negligible, only
from fsel.captures.parsing import number, numbers
from fsel.core.geometry import poses_at

MARKS = (b"<document", b"<chunk")
KINDS = ("frame", "fisheye")
TERMS = ("f", "cx", "cy", "b1", "b2", "k1", "k2", "k3", "k4", "p1", "p2")


def read(folder: Path) -> RawCapture:
    """Read the aligned and enabled cameras, of several components those of the largest.

    A transform is camera to chunk with OpenCV axes; the chunk's own, or its component's, a turn, a
    scale and a shift, leads to metres.
    """
    path = only(marked(folder, "*.xml", *MARKS), folder, "XML files of Metashape's cameras")
    chunk = _chunk(path)
    every = list(chunk.iterfind("cameras//camera"))
    aligned = [one for one in every if one.find("transform") is not None]
    usable = [one for one in aligned if one.get("enabled") not in ("false", "0")]
    parts = Counter(camera.get("component_id") for camera in usable).most_common(1)
    if not parts:
        raise ValueError(f"{path}: none of {len(every)} cameras is aligned and enabled")
    own = parts[0][0]
    posed = [camera for camera in usable if camera.get("component_id") == own]
    used = set(posed)
    reasons = dict.fromkeys(every, "not aligned") | dict.fromkeys(aligned, "disabled")
    reasons |= dict.fromkeys(usable, "in a smaller component")
    dropped = {one.get("label", ""): reasons[one] for one in every if one not in used}
    files = images_of(folder, [camera.get("label", "") for camera in posed], path)
    worlds = [part.find("transform") for part in chunk.iter("component") if part.get("id") == own]
    worlds = [world for world in (*worlds, chunk.find("transform")) if world is not None]
    poses = _poses(posed, worlds[0] if worlds else None, path)
    lenses = {one.get("id"): one for one in chunk.iterfind("sensors/sensor")}
    cameras = {key: _camera(lenses, key, path) for key in {c.get("sensor_id") for c in posed}}
    frames = zip(files, poses, (cameras[camera.get("sensor_id")] for camera in posed), strict=True)
    return one_pass(list(frames), dropped)


def _chunk(path: Path) -> Element:
    try:
        chunks = ElementTree.parse(path).getroot().findall("chunk")
    except ElementTree.ParseError as error:
        raise ValueError(f"{path}: not readable as XML ({error})") from error
    if len(chunks) != 1:
        raise ValueError(f"{path}: {len(chunks)} chunks; allowed: one. Hint: export one chunk")
    return chunks[0]


def _poses(cameras: list[Element], world: Element | None, path: Path) -> np.ndarray:
    """Return (N, 3, 4) world-to-camera poses."""
    turn = _values(world, "rotation", np.eye(3), path)
    scale = _values(world, "scale", np.ones(1), path)
    shift = _values(world, "translation", np.zeros(3), path)
    matrices = np.array([_values(camera, "transform", np.eye(4), path) for camera in cameras])
    centers = scale * (matrices[:, :3, 3] @ turn.T) + shift
    return near_origin(poses_at(centers, (turn @ matrices[:, :3, :3]).transpose(0, 2, 1)), path)


def _values(parent: Element | None, key: str, absent: np.ndarray, path: Path) -> np.ndarray:
    """Return the numbers of a child, in the shape of what stands for an absent one."""
    found = parent.findtext(key) if parent is not None else None
    if found is None:
        return absent
    return numbers(found.split(), (absent.size,), path, key).reshape(absent.shape)


def _camera(sensors: dict[str | None, Element], key: str | None, path: Path) -> Camera:
    """Return the camera of a sensor; p1 and p2 stand the other way round than OpenCV's."""
    if key not in sensors:
        raise ValueError(f"{path}: sensor_id is {key!r}; allowed: {', '.join(map(str, sensors))}")
    sensor, kind = sensors[key], sensors[key].get("type", "frame")
    adjusted = sensor.find("calibration[@class='adjusted']")
    found = sensor.find("calibration") if adjusted is None else adjusted
    size = sensor.find("resolution")
    if kind not in KINDS or found is None or size is None:
        raise ValueError(
            f"{path}: sensor {key} is of type {kind!r}; allowed: {' or '.join(KINDS)}, with "
            "resolution and calibration"
        )
    width, height = (int(number(size.get(side), path, side)) for side in ("width", "height"))
    f, cx, cy, b1, b2, k1, k2, k3, k4, p1, p2 = (
        number(found.findtext(term, "0"), path, f"{term} of sensor {key}") for term in TERMS
    )
    pinhole = (f + b1, f, width / 2 + cx, height / 2 + cy)
    reach = math.hypot(width, height) / 2 / max(abs(f), 1e-9)
    negligible(b2 * height / 2 / max(abs(f), 1e-9), path, f"skew b2 of sensor {key}")
    if kind == "fisheye":
        if p1 or p2:
            extra = (k1, k2, p2, p1, k3, k4, 0.0, 0.0)
            return Camera("THIN_PRISM_FISHEYE", width, height, (*pinhole, *extra))
        return Camera("OPENCV_FISHEYE", width, height, (*pinhole, k1, k2, k3, k4))
    negligible(f * k4 * reach**9, path, f"k4 of sensor {key}")
    return brown((width, height), pinhole, k1, k2, p2, p1, k3)


LAYOUT = Layout("metashape", lambda folder: bool(marked(folder, "*.xml", *MARKS)), read)
