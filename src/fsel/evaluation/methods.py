"""Every selection method by name: those that come with trained weights, and the baselines."""

from __future__ import annotations

from fsel.core.problem import Method
from fsel.core.registry import Registry
from fsel.selectors import baselines, pretrained

_HOMES = {**dict.fromkeys(pretrained.FILES, ""), **baselines.HOMES, **baselines.PRACTICE.homes}
METHODS: Registry[Method] = Registry("method", _HOMES, group=baselines.GROUP)
"""What `fsel.select` and the commands choose from, by name."""
for _name in pretrained.FILES:
    METHODS[_name] = pretrained.method(_name)
