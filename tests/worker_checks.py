"""Checks that a program keeps the protocol of a worker, for tests of recipes and of your own."""

import json
from pathlib import Path

import numpy as np
from jsonschema import Draft202012Validator
from selection_problems import around, pointed
from small_captures import ring

from fsel.reconstruct import external
from fsel.reconstruct.external import External
from fsel.reconstruct.external.worker import Worker

SCHEMA = json.loads(Path(external.__file__).with_name("worker.schema.json").read_text())
TOLERANCE = 1 / 255  # between images that should be the same


def check_worker(monkeypatch, serve, **settings):
    """Fit, render, fail and end as fsel makes a worker do it; the schema judges what is said."""

    def judged(self, request, ask=Worker.ask):
        answer = ask(self, request)
        validate(request, "request")
        validate(answer, request["do"])
        return answer

    monkeypatch.setattr(Worker, "ask", judged)
    capture = pointed(around(ring(8), size=(32, 24)))
    reconstructor = External(capture, serve=serve, **settings)
    views, frames = capture.view(np.array([1, 6])), np.array([0, 3, 5])
    model = reconstructor.fit(frames)
    images = model.render(views)
    assert np.isfinite(images).all(), "values are not finite"
    assert images.min() >= -TOLERANCE, "values below 0"
    assert images.max() <= 1 + TOLERANCE, "values above 1"
    alone = model.render(capture.view(np.array([6])))
    np.testing.assert_allclose(alone, images[1:], atol=TOLERANCE, err_msg="a view alone")
    reconstructor.fit(np.array([2, 4, 7])).render(views)
    again = model.render(views)
    np.testing.assert_allclose(again, images, atol=TOLERANCE, err_msg="after another fit")
    small = pointed(around(ring(8), size=(20, 28)))
    External(small, serve=serve, **settings).fit(frames).render(small.view(np.array([1])))
    model.render(views)  # bound to the first capture again
    reconstructor.worker.start()
    assert reconstructor.worker.stop() == 0, "it does not end with its input"


def validate(message, kind):
    """Compare a message with a definition of the schema."""
    definitions = {"$defs": SCHEMA["$defs"], "$ref": f"#/$defs/{kind}"}
    Draft202012Validator(definitions).validate(json.loads(json.dumps(message)))
