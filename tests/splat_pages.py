"""What a browser draws on the page of a splat, at the cameras themselves."""

import base64

import cv2
import numpy as np
from browsing import acted

SCRIPT = """
await view.ready;
const drawn = async (frames) => {{
  for (let quiet = 0; quiet < frames;) {{
    await new Promise(requestAnimationFrame);
    quiet = view.spark.sorting || view.spark.dirty || view.asked ? 0 : quiet + 1;
  }}
}};
await drawn(1);
const first = performance.now();
const shots = [];
for (const at of {frames}) {{
  view.fly(at, 0);
  await drawn(4);
  view.renderer.render(view.scene, view.camera);
  shots.push(view.renderer.domElement.toDataURL());
}}
return {{ first, shots }};
"""


def drawn(page, size, frames, folder):
    """Pictures at some cameras, and the seconds until the whole splat was first drawn.

    Args:
        page: text of `fsel.pages.viewer.page`.
        size: (width, height) of the cameras' images.
        frames: their numbers.
        folder: for the page and the browser's own files.
    """
    shown = f"#view {{ width: {size[0]}px; height: {size[1]}px;"
    exact = page.replace("html, body, #view { height: 100%;", shown)
    window = (max(size[0], 500), size[1] + 200)
    seen = acted(exact, window, SCRIPT.format(frames=list(map(int, frames))), folder)
    files = [base64.b64decode(shot.partition(",")[2]) for shot in seen["shots"]]
    images = [cv2.imdecode(np.frombuffer(file, np.uint8), cv2.IMREAD_COLOR) for file in files]
    return np.stack(images)[..., ::-1], seen["first"] / 1e3
