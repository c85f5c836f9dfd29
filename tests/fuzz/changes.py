"""What an entry of cases.json changes in a folder.

A file's change is `[start, end, packed]`: those of its bytes are replaced by others, packed with
zlib and Base64. Otherwise it is a word: `gone`, `folder`, `fifo`, or `link:` and where to.
"""

import base64
import os
import zlib


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
