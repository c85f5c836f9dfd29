"""A program that says where images were taken without a look: on a parabola, but for some."""

import sys

TEXT = """
import sys
from pathlib import Path
assert Path(sys.argv[1]) == Path.cwd() and not list(Path("sparse").iterdir())
names = sorted(path.name for path in Path("images").iterdir())
del names[int(sys.argv[2])]
for model, part in enumerate((names[:2], names)):  # the second has more of them
    folder = Path("sparse", str(model))
    folder.mkdir()
    lines = [f"{at + 1} 1 0 0 0 {at} 0 {at * at} 1 {name}\\n" for at, name in enumerate(part)]
    (folder / "cameras.txt").write_text("1 PINHOLE 64 48 60 60 32 24\\n")
    (folder / "images.txt").write_text("\\n".join(lines) + "\\n")
    (folder / "points3D.txt").write_text("")
"""


def written(folder, lost=-1, text=TEXT):
    """The command of the program, which is put into a folder and does not place one image."""
    path = folder / "places.py"
    path.write_text(text)
    return [sys.executable, str(path), "{folder}", str(lost)]
