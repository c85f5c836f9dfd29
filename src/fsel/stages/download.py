"""Archives from the network, resumed where they were cut."""

from __future__ import annotations

import hashlib
import logging
import shutil
import time
from http.client import HTTPException
from pathlib import Path
from urllib.error import HTTPError
from urllib.parse import urlsplit
from urllib.request import Request, urlopen

from fsel.core.files import File

TIMEOUT = 60.0  # seconds without a byte
ATTEMPTS = 5  # in a row without a byte more

logger = logging.getLogger(__name__)


def download(url: str, path: File, sha256: str = "", pause: float = 2.0) -> None:
    """Fetch a file over HTTP; what an earlier run got of it is kept and continued.

    Args:
        path: appears when the whole file is there and its checksum is right; until then its bytes
            lie in `<path>.part`.
        sha256: of the file. Left out, that of the first download, kept in `<path>.sha256`, is
            expected of every later one.
        pause: seconds before another attempt, doubled with each that brings nothing.

    Raises:
        ValueError: for another scheme, or a checksum that differs.
        OSError: when the server refuses, or the connection was cut five times in a row without a
            byte more.
    """
    if urlsplit(url).scheme not in ("http", "https"):
        raise ValueError(f"{url}: only http and https are fetched")
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f"{path.name}.part")
    failed = 0
    while True:
        before = _size(part)
        try:
            _continue(url, part)
            break
        except (HTTPException, OSError) as error:
            if isinstance(error, HTTPError) and error.code < 500:
                raise OSError(f"{url}: the server answers {error.code} {error.reason}") from error
            failed = 0 if _size(part) > before else failed + 1
            if failed == ATTEMPTS:
                raise OSError(
                    f"{url}: cut {ATTEMPTS} times without progress ({error}); {_size(part)} "
                    f"bytes are kept in {part}, and the same command goes on from there"
                ) from error
            logger.info("%s: cut after %d bytes (%s); trying again", url, _size(part), error)
        time.sleep(pause * 2**failed)
    _check(url, part, path, sha256)
    part.replace(path)
    _tag_file(part).unlink(missing_ok=True)


def _size(path: Path) -> int:
    return path.stat().st_size if path.is_file() else 0


def _tag_file(part: Path) -> Path:
    """Return the file with the server's name for the version that a part is of."""
    return part.with_name(f"{part.name}.etag")


def _continue(url: str, part: Path) -> None:
    """Append what is missing; from the start where the server has another version or no ranges."""
    have, tag = _size(part), _tag_file(part)
    headers = {"User-Agent": "fsel", "Accept-Encoding": "identity"}
    if have and tag.is_file():
        headers |= {"Range": f"bytes={have}-", "If-Range": tag.read_text()}
    try:
        answer = urlopen(Request(url, headers=headers), timeout=TIMEOUT)
    except HTTPError as error:
        if error.code != 416:
            raise
        part.unlink()  # it is as long as the file, or longer
        _continue(url, part)
        return
    with answer:
        version = answer.headers.get("ETag", "")
        if not version or version.startswith("W/"):  # weak: of more than one file
            version = answer.headers.get("Last-Modified", "")
        tag.write_text(version) if version else tag.unlink(missing_ok=True)
        continued = answer.status == 206
        with part.open("ab" if continued else "wb") as file:
            shutil.copyfileobj(answer, file, 1 << 20)
        length = answer.headers.get("Content-Length")
    wanted = int(length) + have * continued if length else 0
    if _size(part) < wanted:
        raise ConnectionError(f"{_size(part)} of {wanted} bytes")


def _check(url: str, part: Path, path: Path, sha256: str) -> None:
    with part.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    known = path.with_name(f"{path.name}.sha256")
    wanted = sha256 or (known.read_text().strip() if known.is_file() else digest)
    if digest != wanted:
        part.unlink()
        raise ValueError(
            f"{url}: sha256 is {digest}, expected {wanted}; the download was deleted. Hint: try "
            "again; if it stays so, the file was replaced at its source"
        )
    known.write_text(digest + "\n")
    logger.info("%s: sha256 %s", url, digest)
