"""Descriptions of what made a table or figure, in words."""

from __future__ import annotations

from collections.abc import Mapping

from fsel.evaluation.latex import tex

STAND_IN = "GMSD in the place of LPIPS, whose weights could not be fetched"


def captures_of(facts: Mapping) -> str:
    """Say where the captures come from, in LaTeX.

    Args:
        facts: embedded, real and missing (labels of datasets that are generated, read from disk,
            and not there), and without_lpips, where GMSD stands in its place; the last two may
            lack.
    """
    captures = []
    if facts["embedded"]:
        names = tex(", ".join(facts["embedded"]))
        captures.append(
            f"generated stand-ins that imitate how each corpus is filmed ({names}), "
            "not the corpora themselves"
        )
    if facts["real"]:
        captures.append(f"read from disk ({tex(', '.join(facts['real']))})")
    if facts.get("missing"):
        captures.append(f"missing, since not on disk: {tex(', '.join(facts['missing']))}")
    if facts.get("without_lpips"):
        captures.append(STAND_IN)
    return "; ".join(captures)


def made_by(facts: Mapping) -> str:
    """Say which captures, reconstructor and appearance descriptor made the numbers, in LaTeX.

    Args:
        facts: as in `captures_of`, and reconstructor, long_side, descriptor.
    """
    return (
        f"Captures: {captures_of(facts)}. Reconstructor: {printed(facts)}; appearance "
        rf"descriptor: \texttt{{{tex(facts['descriptor'])}}}."
    )


def printed(reconstruction: Mapping) -> str:
    """Name a `reconstructor` and its image size, `long_side` in pixels, in LaTeX."""
    name = tex(reconstruction["reconstructor"])
    return rf"\texttt{{{name}}} at {reconstruction['long_side']} pixels"


def note(facts: Mapping) -> str:
    """Say in one plain line which captures and reconstructor made a figure; see `made_by`."""
    embedded, real = (", ".join(facts[key]) for key in ("embedded", "real"))
    captures = [f"generated stand-ins for {embedded}"] if embedded else []
    captures += [f"{real}, read from disk"] if real else []
    if facts.get("missing"):
        captures.append(f"missing: {', '.join(facts['missing'])}")
    if facts.get("without_lpips"):
        captures.append(STAND_IN)
    where = f"{facts['reconstructor']} at {facts['long_side']} pixels"
    return f"Captures: {'; '.join(captures)}. Reconstructor: {where}"
