"""Every selection method by name: those that come with trained weights, and the baselines."""

from __future__ import annotations

from fsel import baselines
from fsel.data.problem import Method
from fsel.selector import pretrained
from fsel.selector.policies import RENAMED
from fsel.utils.registry import Registry

METHODS: Registry[Method] = Registry(
    "method",
    {**dict.fromkeys(pretrained.FILES, ""), **baselines.HOMES, **baselines.LATER.homes},
    RENAMED,
    group=baselines.GROUP,
)
"""What `fsel.select` and the commands choose from, by name."""
for _name in pretrained.FILES:
    METHODS[_name] = pretrained.method(_name)
