"""The untrained control: the scorer's features, sign-corrected and summed (paper, Appendix D.3)."""

from __future__ import annotations

from fsel.features.columns import FEATURES
from fsel.features.static import SIGNS
from fsel.selectors.policies import Policy
from fsel.selectors.scorer import Linear

POLICY = Policy(
    name="untrained",
    label="Untrained sum",
    pool="candidates",
    reference="proxies",
    inputs=FEATURES,
    kind=Linear,
)
METHOD = POLICY.method(Linear(SIGNS))
