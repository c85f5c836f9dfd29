"""Masks that keep people out, by rembg (`pip install 'rembg[cpu]'`; it fetches its weights once).

python people.py FOLDER
"""

import sys
from pathlib import Path

from PIL import Image, ImageOps
from rembg import new_session, remove

folder, session = Path(sys.argv[1]), new_session("u2net_human_seg")
for file in sorted((folder / "images").iterdir()):
    people = remove(Image.open(file).convert("RGB"), session=session, only_mask=True)
    ImageOps.invert(people.convert("L")).save(folder / "masks" / f"{file.name}.png")
