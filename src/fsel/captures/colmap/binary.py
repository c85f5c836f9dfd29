"""Binary COLMAP models: where their entries lie, and what is checked before COLMAP reads them.

Beyond a file's end its reader takes anything for counts, and its time grows with the square of the
images.
"""

from __future__ import annotations

from mmap import ACCESS_READ, mmap
from pathlib import Path
from struct import error as Short
from struct import unpack_from

from fsel.captures.colmap.bindings import pycolmap

IMAGES, POINTS = "images.bin", "points3D.bin"
CAMERA = 4 + 4 + 8 + 8  # id, model, width, height
IMAGE = 4 + 7 * 8 + 4  # id, quaternion and translation, camera id
OBSERVATION = 8 + 8 + 8  # x, y, point id
POINT = 8 + 3 * 8 + 3 + 8  # id, position, colour, error
TRACK_ELEMENT = 4 + 4  # image id, index of the observation
RIG = 4 + 4  # id, number of sensors
SENSOR = 4 + 4  # type, id
POSE = 7 * 8  # quaternion and translation
FRAME = 4 + 4 + POSE  # id, rig's id, pose
DATUM = SENSOR + 8  # sensor, id of the image


def check_files(images: Path) -> None:
    """Refuse a folder of images that is empty."""
    if not any(images.iterdir()):
        raise FileNotFoundError(f"{images}: no images in it")


def check_whole(model: Path) -> None:
    """Refuse files that end before their counts say, or go on too long.

    A cut file would make COLMAP allocate all memory of the machine.

    Raises:
        ValueError: naming the file.
    """
    for path in sorted(model.glob("*.txt")) + sorted(model.glob("*.bin")):
        if not (path.is_file() or path.is_dir()):  # COLMAP's reader would wait, deaf to signals
            raise ValueError(f"{path}: not a regular file")
    for name in ENTRIES:
        if (model / name).is_file():
            entries(model / name)


def is_binary(model: Path) -> bool:
    """Check whether COLMAP reads a folder's binary files, not its text."""
    return all((model / name).is_file() for name in (IMAGES, POINTS, "cameras.bin"))


def entries(path: Path) -> tuple[mmap, list[int]]:
    """A binary file, and where each of its entries begins.

    Args:
        path: of a file whose name is in `ENTRIES`.

    Raises:
        ValueError: for a file that ends before its counts say, or goes on too long, naming it.
    """
    skip, at, starts = ENTRIES[path.name], 8, []
    try:
        with path.open("rb") as file:
            content = mmap(file.fileno(), 0, access=ACCESS_READ)
        (count,) = unpack_from("<Q", content)
        for _ in range(count):
            starts.append(at)
            at = skip(content, at)
            if at > len(content):  # before a later entry is looked for there
                raise ValueError(f"an entry ends at {at} of {len(content)} bytes")
    except (Short, ValueError) as error:
        raise ValueError(f"{path}: cut short or damaged ({error})") from error
    if at != len(content):
        raise ValueError(
            f"{path}: cut short or damaged: {len(content)} bytes, its entries take {at}"
        )
    return content, starts


def _after_camera(content: mmap, at: int) -> int:
    _, kind = unpack_from("<ii", content, at)
    named = pycolmap.CameraModelId(kind)  # ValueError for one that COLMAP has not
    camera = pycolmap.Camera.create_from_model_id(1, named, 1.0, 2, 2)
    return at + CAMERA + 8 * len(camera.params)


def name_span(content: mmap, at: int) -> tuple[int, int]:
    """Start of the name of the image that begins at `at`, and the zero byte behind it.

    Raises:
        ValueError: where no zero byte follows.
    """
    end = content.find(b"\0", at + IMAGE)
    if end < 0:
        raise ValueError(f"the name of the image at {at} has no end")
    return at + IMAGE, end


def _after_image(content: mmap, at: int) -> int:
    end = name_span(content, at)[1] + 1
    return end + 8 + OBSERVATION * unpack_from("<Q", content, end)[0]


def _after_point(content: mmap, at: int) -> int:
    return at + POINT + 8 + TRACK_ELEMENT * unpack_from("<Q", content, at + POINT)[0]


def _after_rig(content: mmap, at: int) -> int:
    """End of a rig: each sensor but the first says whether its pose follows."""
    (sensors,) = unpack_from("<I", content, at + 4)
    at += RIG + SENSOR * (sensors > 0)
    for _ in range(1, sensors):
        (posed,) = unpack_from("<B", content, at + SENSOR)
        at += SENSOR + 1 + POSE * (posed > 0)
    return at


def _after_frame(content: mmap, at: int) -> int:
    return at + FRAME + 4 + DATUM * unpack_from("<I", content, at + FRAME)[0]


ENTRIES = {
    "rigs.bin": _after_rig,
    "frames.bin": _after_frame,
    "cameras.bin": _after_camera,
    IMAGES: _after_image,
    POINTS: _after_point,
}
"""By file, the function that says where an entry ends."""
