"""Downloads from a server on loopback that cuts and changes its mind; archives of ill will."""

import hashlib
import io
import stat
import threading
import zipfile
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
import pytest

from fsel.stages.download import download
from fsel.stages.unpack import unpack

BODY = np.random.default_rng(0).integers(0, 256, 3_000_000, dtype=np.uint8).tobytes()
DIGEST = hashlib.sha256(BODY).hexdigest()


class Handler(BaseHTTPRequestHandler):
    def log_message(self, *_):
        pass

    def do_GET(self):
        server, wanted = self.server, self.headers.get("Range")
        server.requested.append(wanted)
        if server.errors:
            self.send_error(server.errors.pop(0))
            return
        start = 0
        if wanted and server.ranges and self.headers.get("If-Range") == server.etag:
            start = int(wanted.removeprefix("bytes=").removesuffix("-"))
            if start >= len(server.body):
                self.send_error(416)
                return
        rest = server.body[start:]
        self.send_response(206 if start else 200)
        self.send_header("Content-Length", str(len(rest)))
        self.send_header("ETag", server.etag)
        self.end_headers()
        cut = server.cuts.pop(0) if server.cuts else len(rest)
        self.wfile.write(rest[:cut])  # then the connection closes, early or not


@pytest.fixture
def server():
    """A server of `body` that keeps the ranges that it was asked for."""
    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as made:
        made.body, made.etag, made.cuts, made.errors = BODY, '"one"', [], []
        made.requested, made.ranges = [], True
        made.url = f"http://127.0.0.1:{made.server_port}/scene.zip"
        threading.Thread(target=made.serve_forever, daemon=True).start()
        yield made
        made.shutdown()


def fetch(server, path, sha256="", pause=0.0):
    download(server.url, path, sha256, pause)


def test_a_cut_connection_is_continued_where_it_was_cut(server, tmp_path):
    server.cuts = [1_000_000, 500_000]
    fetch(server, tmp_path / "scene.zip", DIGEST)
    assert server.requested == [None, "bytes=1000000-", "bytes=1500000-"]
    assert (tmp_path / "scene.zip").read_bytes() == BODY
    assert {path.name for path in tmp_path.iterdir()} == {"scene.zip", "scene.zip.sha256"}


@pytest.mark.parametrize("replaced", [False, True])
def test_another_run_goes_on_where_one_gave_up(replaced, server, tmp_path):
    server.cuts = [1_000_000, 0, 0, 0, 0, 0]
    with pytest.raises(OSError, match=r"cut 5 times .* 1000000 bytes are kept"):
        fetch(server, tmp_path / "scene.zip")
    assert not (tmp_path / "scene.zip").exists()
    server.requested.clear()
    if replaced:
        server.body, server.etag = BODY[::-1], '"two"'
    fetch(server, tmp_path / "scene.zip")
    assert server.requested == ["bytes=1000000-"]
    assert (tmp_path / "scene.zip").read_bytes() == (BODY[::-1] if replaced else BODY)


@pytest.mark.parametrize("etag", ['"one"', 'W/"weak"'])
def test_a_server_without_ranges_starts_anew(server, tmp_path, etag):
    server.ranges, server.etag, server.cuts = False, etag, [2_000_000]
    fetch(server, tmp_path / "scene.zip", DIGEST)
    assert (tmp_path / "scene.zip").read_bytes() == BODY


def test_a_part_that_is_already_whole(server, tmp_path):
    (tmp_path / "scene.zip.part").write_bytes(BODY)
    (tmp_path / "scene.zip.part.etag").write_text('"one"')
    fetch(server, tmp_path / "scene.zip", DIGEST)
    assert (tmp_path / "scene.zip").read_bytes() == BODY


def test_a_busy_server_is_asked_again_and_a_missing_file_is_not(server, tmp_path):
    server.errors = [503, 500]
    fetch(server, tmp_path / "scene.zip", DIGEST)
    server.errors, before = [404, 404], len(server.requested)
    with pytest.raises(OSError, match="answers 404"):
        fetch(server, tmp_path / "other.zip")
    assert len(server.requested) == before + 1


def test_a_wrong_checksum_leaves_nothing(server, tmp_path):
    with pytest.raises(ValueError, match=f"sha256 is {DIGEST}, expected 00.*was deleted"):
        fetch(server, tmp_path / "scene.zip", "00" * 32)
    assert list(tmp_path.glob("scene.zip")) == list(tmp_path.glob("*.part")) == []


def test_a_file_fetched_again_must_be_the_same(server, tmp_path):
    fetch(server, tmp_path / "scene.zip")
    (tmp_path / "scene.zip").unlink()
    server.body, server.etag = BODY[::-1], '"two"'
    with pytest.raises(ValueError, match=f"expected {DIGEST}"):
        fetch(server, tmp_path / "scene.zip")


def test_other_schemes_are_refused(tmp_path):
    with pytest.raises(ValueError, match="only http and https"):
        download((tmp_path / "secret").as_uri(), tmp_path / "scene.zip")


def archive(path, members, links=()):
    with zipfile.ZipFile(path, "w") as file:
        for name, content in members.items():
            file.writestr(name, content)
        for name in links:
            info = zipfile.ZipInfo(name)
            info.external_attr = (stat.S_IFLNK | 0o777) << 16
            file.writestr(info, "/etc/passwd")
    return path


def test_one_folder_and_the_archives_in_it(tmp_path):
    inner = archive(tmp_path / "inner.zip", {"seq-01/frame.txt": "pose"}).read_bytes()
    members = {"chess/TrainSplit.txt": "sequence1", "chess/seq-01.zip": inner, "fire/x": "other"}
    unpack(archive(tmp_path / "all.zip", members), "chess", tmp_path / "data" / "chess")
    files = sorted(
        p.relative_to(tmp_path / "data/chess").as_posix() for p in tmp_path.glob("data/*/**/*")
    )
    assert files == [".fsel", "TrainSplit.txt", "seq-01", "seq-01/frame.txt"]
    assert (tmp_path / "data/chess/seq-01/frame.txt").read_text() == "pose"


@pytest.mark.parametrize(
    "name", ["a/../../out.txt", "../out.txt", "/out.txt", "a\\..\\out.txt", "c:/out.txt"]
)
@pytest.mark.parametrize("nested", [False, True])
def test_a_hostile_archive_writes_nothing(tmp_path, name, nested):
    hostile = archive(tmp_path / "hostile.zip", {"a/good.txt": "good", name: "bad"})
    if nested:
        hostile = archive(tmp_path / "outer.zip", {"in.zip": hostile.read_bytes()})
    (tmp_path / "results" / "dataset").mkdir(parents=True)
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(ValueError, match="leads out of the folder; refused"):
        unpack(hostile, "", tmp_path / "results" / "dataset" / "scene")
    assert sorted(tmp_path.rglob("*")) == before


def cut(path):
    content = archive(path, {f"a/{i}": BODY[:1000] for i in range(9)}).read_bytes()
    path.write_bytes(content[: len(content) // 2])
    return path


def damaged(path):
    content = bytearray(archive(path, {"a/x": b"\0" * 5000}).read_bytes())
    content[60] ^= 255
    path.write_bytes(content)
    return path


def bomb(path):
    """A member larger than it says."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("a/x", b"\0" * 1_000_000)
    sizes = ((size).to_bytes(4, "little") for size in (1_000_000, 10))
    path.write_bytes(buffer.getvalue().replace(*sizes))
    return path


def packed(path):
    """Damage amid a member that LZMA packed."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_LZMA) as file:
        file.writestr("a/x", BODY[:5000])
    content = bytearray(path.read_bytes())
    content[60:100] = b"\xff" * 40
    path.write_bytes(content)
    return path


def named(path):
    """A name that says of itself to be UTF-8, and is not."""
    path.write_bytes(archive(path, {"a/ü": "1"}).read_bytes().replace("ü".encode(), b"\xff\xff"))
    return path


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (lambda path: archive(path, {"a/x": "good"}, ["a/link"]), "'a/link' is a link or device"),
        (cut, "all.zip: cannot be unpacked"),
        (damaged, "all.zip: cannot be unpacked"),
        (bomb, "all.zip: cannot be unpacked"),
        (packed, "all.zip: cannot be unpacked"),
        (named, "all.zip: cannot be unpacked"),
        (lambda path: archive(path, {"garden/x": "1", "stump/x": "1"}), r"\['garden', 'stump'\]"),
    ],
)
def test_a_refused_archive_leaves_the_former_folder(made, said, tmp_path):
    unpack(archive(tmp_path / "all.zip", {"a/old": "old"}), "a", tmp_path / "scene")
    path = made(tmp_path / "all.zip")
    with pytest.raises(ValueError, match=said):
        unpack(path, "a", tmp_path / "scene")
    assert {p.name for p in (tmp_path / "scene").iterdir()} == {".fsel", "old"}
    assert {p.name for p in tmp_path.iterdir()} == {"all.zip", "scene"}


@pytest.mark.parametrize("nested", [False, True])
def test_an_archive_of_more_than_is_allowed_writes_nothing(nested, tmp_path):
    archive(tmp_path / "all.zip", {"a/x": bytes(3000), "a/y": bytes(1000), "b/z": bytes(9000)})
    if nested:
        content = (tmp_path / "all.zip").read_bytes()
        archive(tmp_path / "all.zip", {"a/in.zip": content})
    size = 4e-6 + nested * (9e-6 + len(content) / 1e9 if nested else 0)
    with pytest.raises(ValueError, match=r"zip: unpacks to .* GB; allowed: "):
        unpack(tmp_path / "all.zip", "a", tmp_path / "scene", most=size - 1e-9)
    assert [path.name for path in tmp_path.iterdir()] == ["all.zip"]
    unpack(tmp_path / "all.zip", "a", tmp_path / "scene", most=size + 1e-9)


def test_files_of_a_scene_are_compared_with_their_sha256(tmp_path):
    path = archive(tmp_path / "all.zip", {"garden/x": "1", "garden/y": "2"})
    right = {"x": hashlib.sha256(b"1").hexdigest()}
    unpack(path, "garden", tmp_path / "scene", files=right, licence="MIT")
    for wrong, said in ((right | {"y": "0" * 64}, "sha256 of y is"), ({"z": "0" * 64}, "no file")):
        with pytest.raises(ValueError, match=said):
            unpack(path, "garden", tmp_path / "other", files=wrong)
        assert not (tmp_path / "other").exists()
