"""Serving a reconstructor to `fsel` on standard input and output; one file, for any environment.

    from fsel_worker import serve

    model_of_weights = load()                    # once, before serving
    serve(fit, render)

    def fit(subset): ...                         # returns a model, anything
    def render(model, views): ...                # returns (T, h, w, 3), float in [0, 1] or uint8

Needs Python 3.8 and NumPy. `fsel` puts the folder of this file on the program's path; it may be
copied as well. What the program prints once it has imported this goes to the log, never among the
answers. The protocol is worker.schema.json.
"""

import json
import os
import sys
import threading
import time
import traceback

import numpy as np

PROTOCOL = 2
ARRAYS = (
    *("images", "masks", "world_to_camera", "intrinsics"),
    *("xyz", "rgb", "track_point", "track_frame"),
)
STATED = ("primitives", "bytes", "device", "peak_bytes", "seconds")  # of a model, where it has them
FULL = ("out of memory", "OutOfMemoryError", "Cannot allocate memory")
POLL = 1.0  # seconds between looks for the parent process
# whatever prints from now on, libraries too, prints into the log
ANSWERS_TO = os.dup(1)
os.dup2(2, 1)


class Frames:
    """Frames to reconstruct from, with their images and cameras.

    Attributes:
        folder: of its files; with the need `files` also images and cameras as trainers read them.
        frames: (K,) numbers in the capture.
        images: (K, h, w, 3) uint8 RGB.
        world_to_camera: (K, 3, 4) float64, OpenCV axes.
        intrinsics: (K, 4) float64 fx, fy, cx, cy in pixels; the first pixel's centre is 0.5, 0.5.
        masks: (K, h, w) bool, True where a pixel counts; None for none.
        xyz, rgb: (M, 3) float64 and uint8, sparse points; None without the need `points`.
        track_point, track_frame: (L,) which point is seen by which of the K frames.
    """

    def __init__(self, folder, frames):
        self.folder, self.frames = folder, np.array(frames, np.int64)
        for name in ARRAYS:
            path = os.path.join(folder, name + ".npy")
            setattr(self, name, np.load(path) if os.path.exists(path) else None)


class Cameras:
    """Cameras to render from.

    Attributes:
        world_to_camera: (T, 3, 4) float64, OpenCV axes.
        intrinsics: (T, 4) float64 fx, fy, cx, cy in pixels.
        size: (width, height).
        folder: of the model's subset.
    """

    def __init__(self, request):
        self.folder, self.size = request["folder"], tuple(request["size"])
        views = np.load(request["views"])  # a row a view: its pose, then its intrinsics
        self.world_to_camera, self.intrinsics = views[:, :12].reshape(-1, 3, 4), views[:, 12:]

    def __len__(self):
        return len(self.world_to_camera)


def camera_to_world(poses):
    """Return (N, 4, 4) inverses of (N, 3, 4) poses."""
    whole = np.tile(np.eye(4), (len(poses), 1, 1))
    whole[:, :3] = poses
    return np.linalg.inv(whole)


def middle_and_unit(centers):
    """Return the (3,) mean of (N, 3) camera centres and their largest distance from it, or 1."""
    middle = centers.mean(axis=0)
    return middle, np.linalg.norm(centers - middle, axis=1).max() or 1.0


def camera_matrices(intrinsics):
    """Return (N, 3, 3) matrices of (N, 4) fx, fy, cx, cy."""
    matrices = np.tile(np.eye(3), (len(intrinsics), 1, 1))
    matrices[:, [0, 1, 0, 1], [0, 1, 2, 2]] = intrinsics
    return matrices


def serve(fit, render, name="", version="", device="cpu", needs=(), pixels="float32"):
    """Answer requests until standard input ends.

    Args:
        fit: subset -> model.
        render: (model, views) -> (T, h, w, 3) images, float in [0, 1] or uint8.
        name, version, device: of what reconstructs, for logs and tables.
        needs: any of `points` and `files`.
        pixels: type of the images, `float32`, or `uint8` for a quarter the bytes.
    """
    answers = os.fdopen(ANSWERS_TO, "w", encoding="utf-8", newline="\n")
    threading.Thread(target=_end_with_parent, args=(os.getppid(),), daemon=True).start()
    stated = {"protocol": PROTOCOL, "name": name or os.path.basename(sys.argv[0])}
    stated.update(version=str(version), device=device, needs=list(needs), pixels=pixels)
    state = {"fit": fit, "render": render, "stated": stated, "models": {}}
    for line in sys.stdin:
        request = json.loads(line)
        if request["do"] == "close":  # has no answer
            for model in request["models"]:
                state["models"].pop(model, None)
            continue
        try:
            answer = {"ok": True, **ANSWERS[request["do"]](request, state)}
        except Exception as error:
            traceback.print_exc()
            said = f"{type(error).__name__}: {error}"
            full = isinstance(error, MemoryError) or any(word in said for word in FULL)
            answer = {"ok": False, "error": said, "outcome": "out of memory" if full else "failed"}
        sys.stderr.flush()
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


def _hello(request, state):
    if request["protocol"] != PROTOCOL:
        raise ValueError(f"protocol {request['protocol']}; this helper speaks {PROTOCOL}")
    return state["stated"]


def _bind(request, state):
    """Forget the models of another capture."""
    state["models"].clear()
    return {}


def _fit(request, state):
    subset = Frames(request["folder"], request["frames"])
    started = time.perf_counter()
    device = state["stated"]["device"]
    peak = _Peak(device)
    model = state["fit"](subset)
    costs = {"seconds": time.perf_counter() - started, "peak_bytes": peak.bytes()}
    costs["device"] = _cuda(device).get_device_name() if _cuda(device) else device
    costs.update({name: getattr(model, name) for name in STATED if hasattr(model, name)})
    state["models"][request["model"]] = model
    return costs


def _render(request, state):
    if request["model"] not in state["models"]:
        raise ValueError(f"no model {request['model']}")
    out = np.lib.format.open_memmap(request["out"], mode="r+")
    started = time.perf_counter()
    images = np.asarray(state["render"](state["models"][request["model"]], Cameras(request)))
    seconds = time.perf_counter() - started
    if images.shape != out.shape:
        raise ValueError(f"render returned shape {images.shape}, expected {out.shape}")
    if images.dtype == np.uint8 and out.dtype != np.uint8:
        images = images / np.float32(255)
    np.copyto(out, images, casting="same_kind")
    return {"seconds": seconds}


ANSWERS = {"hello": _hello, "bind": _bind, "fit": _fit, "render": _render}


class _Peak:
    """Memory at its highest, above that at the start: torch's on the GPU for the device
    `cuda`, else resident; 0 where it is not known."""

    def __init__(self, device):
        self._cuda = _cuda(device)
        if self._cuda:
            self._cuda.reset_peak_memory_stats()
            self._start = self._cuda.memory_allocated()
            return
        try:
            with open("/proc/self/clear_refs", "w") as file:
                file.write("5")  # forget the highest so far
        except OSError:
            pass
        self._start = _resident("VmRSS")

    def bytes(self):
        highest = self._cuda.max_memory_allocated() if self._cuda else _resident("VmHWM")
        return max(highest - self._start, 0)


def _cuda(device):
    """torch.cuda for the device `cuda`, where the program has imported torch and there is a GPU."""
    torch = sys.modules.get("torch")
    return torch.cuda if device == "cuda" and torch and torch.cuda.is_available() else None


def _resident(field):
    try:
        with open("/proc/self/status") as file:
            return next(int(line.split()[1]) * 1024 for line in file if line.startswith(field))
    except OSError:
        return 0


def _end_with_parent(parent):
    """End this process when the one that started it has ended, within a fit too."""
    while os.getppid() == parent:
        time.sleep(POLL)
    os._exit(1)
