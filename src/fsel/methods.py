"""Every selection method by name: the baselines, and `fsel` with the shipped scorer."""

from __future__ import annotations

from fsel import baselines
from fsel.problem import Method
from fsel.registry import Registry
from fsel.selector import pretrained

METHODS: Registry[Method] = Registry(
    "method", {pretrained.POLICY.name: "", **baselines.METHODS.homes}
)
METHODS[pretrained.POLICY.name] = pretrained.POLICY.method(pretrained.scorer())
