"""Pages looked at in a real browser, in a frame of any width."""

import html
import http.server
import json
import re
import shutil
import subprocess
import threading

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

SENT = """<script>(async () => {{
  const run = async () => {{ {script} }};
  const answer = await run().then((value) => ({{ value }}), (error) => ({{ error: error.stack }}));
  const body = JSON.stringify(answer);
  fetch('http://127.0.0.1:{port}/', {{ method: 'POST', mode: 'no-cors', body }});
}})();</script>"""


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


def acted(page, size, script, folder, served=None):
    """What a script gives in a page that draws by software WebGL.

    Args:
        page: text of it.
        size: (width, height) of the window, pixels.
        script: the body of an asynchronous function, whose value is sent as JSON.
        folder: for the page and the browser's own files.
        served: files that the page finds beside it, by path; it then comes from a server.
    """
    given, done = [], threading.Event()

    class Answer(http.server.BaseHTTPRequestHandler):
        def do_POST(self):
            given.append(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
            self.send_response(200)
            self.end_headers()
            done.set()

        def do_GET(self):
            found = {"/": (folder / "acted.html").read_bytes(), **(served or {})}
            self.send_response(200 if self.path in found else 404)
            self.send_header("Content-Type", "text/html" if self.path == "/" else "model/ply")
            self.end_headers()
            self.wfile.write(found.get(self.path, b""))

        def log_message(self, *said):
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Answer) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        own = SENT.format(script=script, port=server.server_port)
        (folder / "acted.html").write_text(page.replace("</body>", f"{own}</body>"))
        command = [BROWSER, "--headless", "--no-sandbox", "--use-gl=angle", "--hide-scrollbars"]
        command += ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        command += [f"--window-size={size[0]},{size[1]}", f"--user-data-dir={folder / 'profile'}"]
        served_at = f"http://127.0.0.1:{server.server_port}/"
        place = served_at if served else (folder / "acted.html").as_uri()
        command += ["--remote-debugging-port=0", place]
        browser = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        try:
            assert done.wait(110), "the page gave nothing"
        finally:
            browser.kill()
            browser.communicate()
            server.shutdown()
    assert "error" not in given[0], given[0]["error"]
    return given[0]["value"]


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
