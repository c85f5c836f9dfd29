"""Pages looked at in a real browser, in a frame of any width."""

import base64
import html
import json
import re
import shutil
import subprocess

import cv2
import numpy as np
import pytest

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "chrome"))), None)
needs_a_browser = pytest.mark.skipif(BROWSER is None, reason="no Chromium is installed")
FRAME = """<!doctype html><body style="margin:0"><iframe src="{page}" style="width:{width}px;
height:1200px;border:0"></iframe><script>
const frame = document.querySelector('iframe');
frame.addEventListener('load', () => {{
  const seen = frame.contentWindow.eval({script});
  document.documentElement.setAttribute('data-seen', JSON.stringify(seen));
}});
</script>"""


def browse(folder, *arguments):
    """Run the browser; what it wrote."""
    command = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
    command += [
        "--enable-logging=stderr",
        "--allow-file-access-from-files",
        "--disable-web-security",
        f"--user-data-dir={folder / 'profile'}",
        "--virtual-time-budget=5000",
    ]
    return subprocess.run([*command, *arguments], capture_output=True, text=True, timeout=120)


def pictures(page):
    """JPEG files in a page's text, in its order."""
    found = re.findall(r"data:image/jpeg;base64,([A-Za-z0-9+/=]+)", page)
    return [base64.b64decode(text) for text in found]


def decoded(picture):
    """(h, w, 3) uint8 of a JPEG file."""
    return cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR)


def looked_at(page, width, script, folder):
    """What a script finds in a page that is so many pixels wide, which raises no error.

    Args:
        page: file.
        width: pixels.
        script: an expression of JavaScript, run in the page when it is loaded.
        folder: for the browser's own files.
    """
    frame = folder / f"frame{width}.html"
    frame.write_text(FRAME.format(page=page.as_uri(), width=width, script=json.dumps(script)))
    ran = browse(folder, f"--window-size={max(width, 500)},1200", "--dump-dom", frame.as_uri())
    assert "Uncaught" not in ran.stderr
    (found,) = re.findall(r'data-seen="([^"]*)"', ran.stdout)
    return json.loads(html.unescape(found))
