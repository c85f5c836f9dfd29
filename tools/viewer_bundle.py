"""Make the script of the page of `fsel view`: three.js and Spark with what is in `web`, in a file.

    python tools/viewer_bundle.py

npm, of Node.js, fetches the versions and checksums that `package-lock.json` pins.
"""

import hashlib
import shutil
import subprocess
import tempfile
from pathlib import Path

from fsel.pages.viewer import SCRIPT, WEB

LICENSED = ("three", "@sparkjsdev/spark", "fflate")  # what is in the bundle; all are MIT
STEPS = (("ci", "--ignore-scripts", "--no-audit", "--no-fund"), ("run", "bundle"))


def mark() -> str:
    """Return the digest of all that the bundle is made from, its first words."""
    digest = hashlib.sha256()
    for file in sorted(WEB.glob("[!.]*")):
        if file.is_file():
            digest.update(file.name.encode() + file.read_bytes())
    return digest.hexdigest()[:16]


def bundle() -> str:
    """Return the bundle, its packages' licences at its head."""
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "web"
        shutil.copytree(WEB, place)
        for step in STEPS:
            subprocess.run(["npm", *step], cwd=place, check=True)
        packages = place / "node_modules"
        licences = [
            f"{name}\n{(packages / name / 'LICENSE').read_text(encoding='utf-8')}"
            for name in LICENSED
        ]
        content = (place / "bundle.js").read_text(encoding="utf-8")
    head = "\n".join([mark(), *licences]).replace("*/", "* /")
    return f"/* {head}*/\n{content}"


if __name__ == "__main__":
    SCRIPT.write_text(bundle(), encoding="utf-8")
