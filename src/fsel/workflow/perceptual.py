"""LPIPS or, where its published weights cannot be had, GMSD: settled once, before the rules."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from fsel.core import packages
from fsel.metrics import published
from fsel.workflow.experiment import Experiment
from fsel.workflow.refusal import refuse

HINT = "`metrics: [psnr, ssim, gmsd]` goes without LPIPS, `lpips.weights` names a file of your own"


def settled(experiment: Experiment, ask: bool) -> Experiment:
    """The experiment with the metrics that it can have.

    Args:
        experiment: the run's.
        ask: look in the package index where the weights are not there yet; the processes of jobs
            do not, since they start when the run has fetched them or goes without.

    Returns:
        The same experiment, or one in which GMSD stands in the place of LPIPS.
    """
    if not experiment.fetches_lpips or _weights(experiment).is_file():
        return experiment
    reason = packages.missing(published.PACKAGE, published.VERSION) if ask else "not fetched"
    if not reason:
        return experiment
    if ask:
        print(
            f"LPIPS: {_weights(experiment)} is not there and cannot be fetched ({reason}); GMSD "
            "takes its place, as every caption says",
            file=sys.stderr,
        )
    return replace(experiment, without_lpips=reason)


def fetch(experiment: Experiment) -> None:
    """Fetch the weights before the first job, where `settled` found that they can be had.

    Raises:
        Refusal: when they cannot after all.
    """
    path = _weights(experiment)
    if not experiment.fetches_lpips or experiment.without_lpips or path.is_file():
        return
    print(f"Fetching LPIPS's weights, once, to {path}", file=sys.stderr)
    try:
        published.fetch(experiment.config["lpips"]["net"], path)
    except (packages.Unobtainable, ValueError) as error:
        refuse(f"LPIPS: {error}", HINT)


def _weights(experiment: Experiment) -> Path:
    return Path(str(experiment.lpips["weights"]))
