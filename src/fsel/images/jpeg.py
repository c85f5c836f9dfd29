"""A JPEG's segments before its pixels: would libjpeg take them? (ITU-T T.81, annex B.)"""

from __future__ import annotations

import mmap
from struct import error as Short
from struct import unpack_from

START = 2  # bytes of the marker that a file begins with
FRAMES = (0xC0, 0xC1, 0xC2)  # baseline, extended and progressive: they state the size
SCAN, QUANTA, CODES = 0xDA, 0xDB, 0xC4
OTHERS = {0xCC, 0xDC, 0xDD, *range(0xE0, 0xF0), 0xFE}  # that may come before the scan
KNOWN = {*FRAMES, SCAN, QUANTA, CODES, *OTHERS}
ALONE = {0x01, *range(0xD0, 0xD8)}  # markers without a length
COMPONENTS = (1, 3, 4)
LONGEST = 15  # bits of a difference between two blocks' means
BLOCKS = 10  # of a unit, at most
Content = bytes | mmap.mmap
Segment = tuple[int, int, int]


def segments(content: Content) -> list[Segment]:
    """Marker of each segment up to the scan's, its start and its end."""
    found, at = [], START
    while True:
        at = content.find(b"\xff", at)  # what lies before a marker is passed over
        if at < 0:
            break
        marker = content[at + 1]
        if marker == 0xFF:
            at += 1
        elif marker in ALONE:
            at += 2
        else:
            (length,) = unpack_from(">H", content, at + 2)
            found.append((marker, at, at + 2 + length))
            if marker == SCAN or length < 2:
                break
            at += 2 + length
    return found


def tables_hold(content: Content) -> bool:
    """Whether the segments before the pixels are whole and go together."""
    quanta: set[int] = set()
    parts: dict[int, tuple[int, int, int]] = {}
    try:
        for marker, start, end in segments(content):
            inside = bytes(content[start + 4 : end])
            if marker not in KNOWN or len(inside) != end - start - 4:
                return False
            if marker == CODES and not _codes_hold(inside):
                return False
            if marker == QUANTA:
                quanta |= _quanta(inside)
            if marker in FRAMES:
                if parts:  # libjpeg refuses a second
                    return False
                parts = _parts(inside)
            if marker == SCAN:
                return _scan_holds(inside, parts, quanta)
    except (Short, IndexError, ValueError):
        return False
    return False


def _quanta(inside: bytes) -> set[int]:
    """Numbers of the quantisation tables of a segment."""
    found, at = set(), 0
    while at < len(inside):
        precision, number = divmod(inside[at], 16)
        at += 65 + 64 * (precision > 0)
        if number > 3 or at > len(inside):
            raise ValueError
        found.add(number)
    return found


def _codes_hold(inside: bytes) -> bool:
    """Whether a segment's Huffman tables have as many codes as fit, and name known tables."""
    at = 0
    while at + 17 <= len(inside):
        kind, number = divmod(inside[at], 16)
        counts = inside[at + 1 : at + 17]
        at += 17 + sum(counts)
        code = 0
        for length, count in enumerate(counts, 1):
            code = 2 * code + count
            if code > 1 << length:
                return False
        if kind > 1 or number > 3 or sum(counts) > 256 or at > len(inside):
            return False
        if kind == 0 and max(inside[at - sum(counts) : at], default=0) > LONGEST:
            return False
    return at == len(inside)


def _parts(inside: bytes) -> dict[int, tuple[int, int, int]]:
    """Component -> sampling across and down, and the number of its quantisation table."""
    precision, _, _, count = unpack_from(">BHHB", inside)
    if precision != 8 or count not in COMPONENTS or len(inside) != 6 + 3 * count:
        raise ValueError
    found = {}
    for at in range(6, len(inside), 3):
        across, down = divmod(inside[at + 1], 16)
        if not (1 <= across <= 4 and 1 <= down <= 4):
            raise ValueError
        found[inside[at]] = (across, down, inside[at + 2])
    return found


def _scan_holds(inside: bytes, parts: dict[int, tuple[int, int, int]], quanta: set[int]) -> bool:
    count = inside[0]
    if not parts or not 1 <= count <= 4 or len(inside) != 4 + 2 * count:
        return False
    named = [inside[at] for at in range(1, 1 + 2 * count, 2)]
    tables = [divmod(inside[at], 16) for at in range(2, 2 + 2 * count, 2)]
    if not all(name in parts for name in named) or any(max(pair) > 3 for pair in tables):
        return False
    blocks = sum(parts[name][0] * parts[name][1] for name in named)
    most = [max(part[axis] for part in parts.values()) for axis in (0, 1)]
    whole = all(not most[axis] % part[axis] for part in parts.values() for axis in (0, 1))
    return (
        whole
        and (count == 1 or blocks <= BLOCKS)
        and all(parts[name][2] in quanta for name in named)
    )
