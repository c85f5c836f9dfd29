"""Every selection method by name: the baselines, and `fsel` with the shipped scorer."""

from __future__ import annotations

from fsel import baselines, shipped
from fsel.problem import Method

METHODS: dict[str, Method] = {
    shipped.POLICY.name: shipped.POLICY.method(shipped.scorer()),
    **baselines.METHODS,
}
