"""What was changed in a folder, as an entry of cases.json, and the same changes done again.

A file's change is `[start, end, packed]`: those of its bytes are replaced by others, packed with
zlib and Base64. Otherwise it is a word: `gone`, `folder`, `fifo`, or `link:` and where to.
"""

import base64
import os
import zlib


def between(before, after):
    """Relative path -> change, of two folders of which the second began as a copy."""
    found = {}
    for path in sorted(item for item in before.rglob("*") if item.is_file()):
        name = str(path.relative_to(before))
        change = _change(path, after / name)
        if change:
            found[name] = change
    return found


def _change(path, now):
    if now.is_symlink():
        return f"link:{os.readlink(now)}"
    if now.is_dir():
        return "folder"
    if now.is_fifo():
        return "fifo"
    if not now.exists():
        return "gone"
    old, new = path.read_bytes(), now.read_bytes()
    if old == new:
        return None
    start = _alike(old, new)
    tail = _alike(old[start:][::-1], new[start:][::-1])
    packed = zlib.compress(new[start : len(new) - tail], 9)
    return [start, len(old) - tail, base64.b64encode(packed).decode()]


def _alike(first, second):
    """How many bytes at the beginning are equal."""
    pairs = enumerate(zip(first, second, strict=False))
    return next((at for at, (a, b) in pairs if a != b), min(len(first), len(second)))


def done(changes, folder):
    """Change the files of a copy."""
    for name, change in changes.items():
        path = folder / name
        if isinstance(change, str):
            replaced(path, change)
        else:
            start, end, packed = change
            content = path.read_bytes()
            middle = zlib.decompress(base64.b64decode(packed))
            path.write_bytes(content[:start] + middle + content[end:])


def replaced(path, word):
    """Put something else where a file was."""
    path.unlink()
    if word == "folder":
        path.mkdir()
    elif word == "fifo":
        os.mkfifo(path)
    elif word != "gone":
        path.symlink_to(word.removeprefix("link:"))
