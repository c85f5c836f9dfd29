"""A program that says where images were taken without a look: on a parabola, but for some."""

import sys

TEXT = """
import sys
from pathlib import Path
names = sorted(path.name for path in Path(sys.argv[1], "images").iterdir())
del names[int(sys.argv[2])]
lines = [f"{at + 1} 1 0 0 0 {at} 0 {at * at} 1 {name}\\n" for at, name in enumerate(names)]
Path("sparse/cameras.txt").write_text("1 PINHOLE 64 48 60 60 32 24\\n")
Path("sparse/images.txt").write_text("\\n".join(lines) + "\\n")
Path("sparse/points3D.txt").write_text("")
"""


def written(folder, lost=-1):
    """The command of the program, which is put into a folder.

    Args:
        folder: of places.py.
        lost: the number of the image that it does not place.
    """
    path = folder / "places.py"
    path.write_text(TEXT)
    return [sys.executable, str(path), "{folder}", str(lost)]
