"""What is done to one file of a capture, by a generator of random numbers."""

import gzip
import json
import math
import struct
import zlib

import cv2
import numpy as np

from .changes import replaced

ODD = [
    None, 0, -1, 1, 0.1, 40, 1e308, -1e308, 1e-308, 10**30, math.nan, math.inf, -math.inf, "", "x",
    "../x", "a/../b.jpg", " x ", "a\nb", [], {}, [[]], [0, 0, 0, 0], True,
]  # fmt: skip
NUMBERS = [0.0, -0.0, -1.0, 1e308, -1e308, 1e-308, math.nan, math.inf, -math.inf, 1e9]
COUNTS = [0, 1, 2**31 - 1, 2**32 - 1, 2**63 - 1, 2**64 - 1]
WORDS = ["0", "-1", "nan", "inf", "1e308", "1e-308", "x", "", "99999999999", "../x"]


def flipped(content, rng):
    out = bytearray(content)
    for _ in range(int(rng.integers(1, 5))):
        if out:
            out[rng.integers(len(out))] ^= int(rng.integers(1, 256))
    return bytes(out)


def cut(content, rng):
    return content[: rng.integers(len(content) + 1)]


def repeated(content, rng):
    start, end = np.sort(rng.integers(len(content) + 1, size=2))
    return content[:end] + content[start:end] + content[end:]


def removed(content, rng):
    start, end = np.sort(rng.integers(len(content) + 1, size=2))
    return content[:start] + content[end:]


def emptied(content, rng):
    return b""


def odd_number(content, rng):
    """Eight bytes become an odd number, or an odd count."""
    if len(content) < 8:
        return content
    kind = rng.integers(2)
    packed = struct.pack("<d", rng.choice(NUMBERS))
    if kind:
        packed = struct.pack("<Q", COUNTS[rng.integers(len(COUNTS))])
    at = int(rng.integers(len(content) - 7))
    return content[:at] + packed + content[at + 8 :]


def odd_word(content, rng):
    lines = content.decode("utf-8", "replace").split("\n")
    at = int(rng.integers(len(lines)))
    words = lines[at].split(" ")
    if rng.integers(4):
        words[rng.integers(len(words))] = WORDS[rng.integers(len(WORDS))]
        lines[at] = " ".join(words)
    else:
        del lines[at]
    return "\n".join(lines).encode()


def other_text(content, rng):
    return content.decode("utf-8", "replace").encode("utf-16")


def odd_field(content, rng):
    try:
        document = json.loads(content)
    except ValueError:
        return flipped(content, rng)
    places = list(_places(document))
    if not places:
        return b"[]"
    holder, key = places[rng.integers(len(places))]
    if rng.integers(5):
        holder[key] = ODD[rng.integers(len(ODD))]
    else:
        del holder[key]
    return json.dumps(document).encode()


def _places(node):
    keys = node if isinstance(node, dict) else range(len(node)) if isinstance(node, list) else ()
    for key in keys:
        yield node, key
        yield from _places(node[key])


def odd_packed(content, rng):
    try:
        return gzip.compress(odd_field(gzip.decompress(content), rng), mtime=0)
    except (OSError, EOFError, zlib.error):
        return flipped(content, rng)


def large_claim(content, rng):
    """A header that states an image of gigapixels, the rest being whole."""
    size = struct.pack(">II", 60_000, 60_000)
    if content.startswith(b"\x89PNG") and len(content) > 33:
        head = b"IHDR" + size + content[24:29]
        return content[:12] + head + struct.pack(">I", zlib.crc32(head)) + content[33:]
    at = content.find(b"\xff\xc0")
    if at < 0:
        return content
    return content[: at + 5] + struct.pack(">HH", 60_000, 60_000) + content[at + 9 :]


def other_image(content, rng):
    """A readable image of another size, or grey."""
    shape = [(24, 32, 3), (48, 64), (64, 48, 3), (1, 1, 3), (96, 128, 3)][rng.integers(5)]
    ending = ".png" if content.startswith(b"\x89PNG") else ".jpg"
    return cv2.imencode(ending, np.full(shape, 90, np.uint8))[1].tobytes()


ANY = [flipped, cut, repeated, removed, emptied]
BY_ENDING = {
    ".json": [odd_field] * 6 + [odd_word, other_text],
    ".jgz": [odd_packed] * 6,
    ".txt": [odd_word] * 6 + [other_text],
    ".ply": [odd_number] * 3 + [odd_word] * 3,
    ".log": [odd_word] * 4 + [other_text],
    ".bin": [odd_number] * 5,
    ".png": [large_claim, other_image],
    ".jpg": [large_claim, other_image],
}


PLACES = ["gone", "folder", "fifo", "link:/dev/zero", "link:/dev/null", "link:nowhere"]


def damage(path, rng):
    """Change one file; sometimes it goes, or something else takes its place."""
    choice = int(rng.integers(10 * (len(PLACES) + 2)))
    places = [*PLACES, f"link:{path.name}", f"link:{path.parent}"]
    if choice < len(places):
        replaced(path, places[choice])
        return
    content = path.read_bytes()
    known = [*ANY, *BY_ENDING.get(path.suffix.lower(), [])]
    path.write_bytes(known[rng.integers(len(known))](content, rng))
