"""Every selection method by name: those that come with trained weights, and the baselines."""

from __future__ import annotations

from fsel import baselines
from fsel.data.problem import Method
from fsel.selector import pretrained
from fsel.selector.policies import RENAMED
from fsel.utils.registry import Registry

METHODS: Registry[Method] = Registry(
    "method",
    {**dict.fromkeys(pretrained.FILES, ""), **baselines.METHODS.homes, **baselines.LATER.homes},
    RENAMED,
)
"""What `fsel.select` and the commands choose from, by name."""
for _name in pretrained.FILES:
    METHODS[_name] = pretrained.method(_name)
