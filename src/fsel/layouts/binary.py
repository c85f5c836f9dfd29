"""What of a COLMAP model is checked before COLMAP reads it.

Beyond a file's end its reader takes anything for counts, and its time grows with the square of the
images.
"""

from __future__ import annotations

from pathlib import Path
from struct import error as Short
from struct import unpack_from

from fsel.held import pycolmap
from fsel.layouts.base import check_number

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


def check_files(model: Path, images: Path) -> None:
    """Refuse a folder of images that is empty, or lacks most of a large model's.

    Raises:
        FileNotFoundError: for an empty folder.
        ValueError: see `fsel.layouts.base.check_number`. A million images would take the reader two
            minutes.
    """
    if not any(images.iterdir()):
        raise FileNotFoundError(f"{images}: no images in it")
    check_number(images, _number_of_images(model), model)


def _number_of_images(model: Path) -> int:
    """As the binary file states it, if so many fit into it; of text, two lines each."""
    packed, text = model / "images.bin", model / "images.txt"
    if packed.is_file():
        with packed.open("rb") as file:
            count = int.from_bytes(file.read(8), "little")
        return count if count <= packed.stat().st_size // (IMAGE + 1 + 8) else 0
    if not text.is_file():
        return 0
    with text.open("rb") as file:
        return sum(not line.startswith(b"#") for line in file) // 2


def check_whole(model: Path) -> None:
    """Refuse files that end before their counts say, or go on too long.

    A cut file would make COLMAP allocate all memory of the machine.

    Raises:
        ValueError: naming the file.
    """
    for path in sorted(model.glob("*.txt")) + sorted(model.glob("*.bin")):
        if not (path.is_file() or path.is_dir()):  # COLMAP's reader would wait, deaf to signals
            raise ValueError(f"{path}: not a regular file")
    for name, skip in ENTRIES.items():
        path = model / name
        if not path.is_file():
            continue
        content, at = path.read_bytes(), 8
        try:
            (count,) = unpack_from("<Q", content)
            for _ in range(count):
                at = skip(content, at)
                if at > len(content):  # before a later entry is looked for there
                    raise ValueError(f"an entry ends at {at} of {len(content)} bytes")
        except (Short, ValueError) as error:
            raise ValueError(f"{path}: cut short or damaged ({error})") from error
        if at != len(content):
            raise ValueError(
                f"{path}: cut short or damaged: {len(content)} bytes, its entries take {at}"
            )


def _after_camera(content: bytes, at: int) -> int:
    _, kind = unpack_from("<ii", content, at)
    named = pycolmap.CameraModelId(kind)  # ValueError for one that COLMAP has not
    camera = pycolmap.Camera.create_from_model_id(1, named, 1.0, 2, 2)
    return at + CAMERA + 8 * len(camera.params)


def _after_image(content: bytes, at: int) -> int:
    name = at + IMAGE
    end = content.index(b"\0", name) + 1
    return end + 8 + OBSERVATION * unpack_from("<Q", content, end)[0]


def _after_point(content: bytes, at: int) -> int:
    return at + POINT + 8 + TRACK_ELEMENT * unpack_from("<Q", content, at + POINT)[0]


def _after_rig(content: bytes, at: int) -> int:
    """Each sensor but the first says whether its pose follows."""
    (sensors,) = unpack_from("<I", content, at + 4)
    at += RIG + SENSOR * (sensors > 0)
    for _ in range(1, sensors):
        (posed,) = unpack_from("<B", content, at + SENSOR)
        at += SENSOR + 1 + POSE * (posed > 0)
    return at


def _after_frame(content: bytes, at: int) -> int:
    return at + FRAME + 4 + DATUM * unpack_from("<I", content, at + FRAME)[0]


ENTRIES = {
    "rigs.bin": _after_rig,
    "frames.bin": _after_frame,
    "cameras.bin": _after_camera,
    "images.bin": _after_image,
    "points3D.bin": _after_point,
}
"""By file, the function that says where an entry ends."""
