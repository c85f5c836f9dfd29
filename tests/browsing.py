"""Pages looked at in a real browser, in a frame of any width."""

import base64
import http.server
import json
import re
import shutil
import subprocess
import tempfile
import threading

import cv2
import numpy as np
import pytest

BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "chrome"))), None)
needs_a_browser = pytest.mark.skipif(BROWSER is None, reason="no Chromium is installed")
FRAME = """<!doctype html><body style="margin:0"><iframe src="{page}" style="width:{width}px;
height:1200px;border:0"></iframe></body>"""
IN_FRAME = """
const frame = document.querySelector('iframe');
if (frame.contentDocument.readyState !== 'complete' || frame.contentDocument.URL === 'about:blank')
  await new Promise((loaded) => frame.addEventListener('load', loaded));
return await frame.contentWindow.eval({script});
"""
SENT = """<script>(async () => {{
  const run = async () => {{ {script} }};
  const answer = await run().then((value) => ({{ value }}), (error) => ({{ error: error.stack }}));
  const body = JSON.stringify(answer);
  fetch('http://127.0.0.1:{port}/', {{ method: 'POST', mode: 'no-cors', body }});
}})();</script>"""
DRAWING = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
SECONDS = 90  # on a crowded machine


def command(folder, *arguments):
    """A browser without a window that keeps its own files in a new folder within one."""
    profile = tempfile.mkdtemp(dir=folder)
    return [
        *(BROWSER, "--headless", "--no-sandbox", "--hide-scrollbars", "--enable-logging=stderr"),
        *("--allow-file-access-from-files", "--disable-web-security"),
        *(f"--user-data-dir={profile}", *arguments),
    ]


def acted(page, size, script, folder):
    """What a script gives in a page that draws by software WebGL: see `_given`."""
    return _given(page, size, script, folder, DRAWING)[0]


def _given(page, size, script, folder, options):
    """What a script gives in a page, and what the browser wrote.

    Args:
        page: text of it.
        size: (width, height) of the window, pixels.
        script: the body of an asynchronous function, whose value is sent as JSON.
    """
    given, done = [], threading.Event()

    class Answer(http.server.BaseHTTPRequestHandler):
        def do_POST(self):
            given.append(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
            self.send_response(200)
            self.end_headers()
            done.set()

        def log_message(self, *said):
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Answer) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        own = SENT.format(script=script, port=server.server_port)
        (folder / "acted.html").write_text(page.replace("</body>", f"{own}</body>"))
        window = f"--window-size={size[0]},{size[1]}"
        run = command(folder, *options, window, "--remote-debugging-port=0")
        run.append((folder / "acted.html").as_uri())
        browser = subprocess.Popen(run, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        try:
            assert done.wait(SECONDS), "the page gave nothing"
        finally:
            browser.kill()
            said, _ = browser.communicate()
            server.shutdown()
    assert "error" not in given[0], given[0]["error"]
    return given[0]["value"], said


def pictures(page):
    """JPEG files in a page's text, in its order."""
    found = re.findall(r"data:image/jpeg;base64,([A-Za-z0-9+/=]+)", page)
    return [base64.b64decode(text) for text in found]


def decoded(picture):
    """(h, w, 3) uint8 of a JPEG file."""
    return cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR)


def looked_at(page, width, script, folder):
    """What a script finds in a page that is so many pixels wide, which raises no error.

    The page is a file, the script an expression that is run when it is loaded.
    """
    frame = FRAME.format(page=page.as_uri(), width=width)
    inside = IN_FRAME.format(script=json.dumps(script))
    value, said = _given(frame, (max(width, 500), 1200), inside, folder, ["--disable-gpu"])
    assert b"Uncaught" not in said, said.decode()
    return value
