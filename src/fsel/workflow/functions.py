"""Function of every rule: the stage of its name, or one that is listed here."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from itertools import combinations
from operator import attrgetter

STAGES, PAPER = "fsel.stages", "fsel.experiments.paper"
STUDIES, ABLATION = "fsel.experiments.studies", f"{PAPER}.ablation"

LISTED = {
    "split_labelled": f"{STAGES}.split:split_labelled",
    "handsign": f"{PAPER}.learned:handsign",
    "seedvar": f"{PAPER}.learned:seedvar",
    "evaluate_searched": f"{PAPER}.ga_vs_learned:TRIALS.evaluate",
    "ga_vs_learned": f"{PAPER}.ga_vs_learned:ga_vs_learned",
    "select_geometry": f"{PAPER}.time_quality:TRIALS.select",
    "evaluate_geometry": f"{PAPER}.time_quality:TRIALS.evaluate",
    "measure_costs": f"{PAPER}.time_quality:measure_costs",
    "time_quality": f"{PAPER}.time_quality:time_quality",
    "select_crosscapture": f"{PAPER}.crosscapture:TRIALS.select",
    "evaluate_crosscapture": f"{PAPER}.crosscapture:TRIALS.evaluate",
    "crosscapture": f"{PAPER}.crosscapture:crosscapture",
    "select_objects": f"{PAPER}.objectcentric:TRIALS.select",
    "evaluate_objects": f"{PAPER}.objectcentric:TRIALS.evaluate",
    "objectcentric": f"{PAPER}.objectcentric:objectcentric",
    "trial_feature_sweep": f"{ABLATION}.trials:trial_case",
    "trial_scorer_arch": f"{ABLATION}.trials:trial_case",
    "evaluate_feature_sweep": f"{ABLATION}.trials:TRIALS.evaluate",
    "evaluate_scorer_arch": f"{ABLATION}.trials:TRIALS.evaluate",
    "feature_sweep": f"{ABLATION}.tables:feature_sweep",
    "scorer_arch": f"{ABLATION}.tables:scorer_arch",
    "pair_poses": f"{PAPER}.pose_sources:pair_poses",
    "select_paired": f"{PAPER}.pose_sources:TRIALS.select",
    "evaluate_paired": f"{PAPER}.pose_sources:TRIALS.evaluate",
    "pose_sources": f"{PAPER}.pose_sources:pose_sources",
    "evaluate_transfer": f"{PAPER}.transfer:evaluate_transfer",
    "transfer": f"{PAPER}.transfer:transfer",
    "evaluate_reconchoice": f"{PAPER}.transfer:evaluate_reconchoice",
    "reconchoice": f"{PAPER}.transfer:reconchoice",
    "pipeline_figure": f"{PAPER}.pipeline_figure:pipeline_figure",
    "teaser": f"{PAPER}.pictures:qualitative",
    "qualitative": f"{PAPER}.pictures:qualitative",
    "real_world": f"{PAPER}.pictures:real_world",
    "speed_error": f"{STUDIES}.speed_error:speed_error",
}


def home_of(rule: str) -> str:
    """Return `module:function` of a rule, by the longest part of its name that is known: other
    words are those of a variant, or of a workflow that imports it with `as fsel_*`."""
    words = rule.split("_")
    for start, end in sorted(combinations(range(len(words) + 1), 2), key=lambda s: s[0] - s[1]):
        part = "_".join(words[start:end])
        if part in LISTED:
            return LISTED[part]
        if find_spec(f"{STAGES}.{part}"):
            return f"{STAGES}.{part}:{part}"
    raise ValueError(f"rule {rule}: neither listed nor named as a stage in {STAGES}")


def function_of(rule: str) -> Callable[..., None]:
    """Import the function that a rule runs."""
    module, _, name = home_of(rule).partition(":")
    found: Callable[..., None] = attrgetter(name)(import_module(module))
    return found
