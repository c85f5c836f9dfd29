"""Every selection method by name: the baselines, and `fsel` with the shipped scorer."""

from __future__ import annotations

from fsel import baselines
from fsel.problem import Method
from fsel.selector import pretrained

METHODS: dict[str, Method] = {
    pretrained.POLICY.name: pretrained.POLICY.method(pretrained.scorer()),
    **baselines.METHODS,
}
