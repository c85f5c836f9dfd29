"""Selections compared on a capture's own frames by successive halving.

Not in the paper. No single rule wins on every capture. So a few selections are reconstructed and
scored on frames that neither they nor uniform sampling contain: by `splats`, and those ahead there
by small `gaussians` too. Another one replaces uniform sampling where both reconstructors put it
ahead by 0.2 dB and not behind in SSIM, and their mean by 0.5 dB and beyond chance.

With targets that are frames, their own images can score instead: another selection replaces the
rule's where `gaussians` put it ahead by 0.2 dB. Gains: docs/results/captures_unknown.md.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.special import stdtrit

from fsel.core.capture import Capture
from fsel.core.problem import Problem
from fsel.core.subsets import evenly, subset_key
from fsel.core.threads import side_by_side
from fsel.metrics import score_views
from fsel.reconstruct.gaussians import Gaussians
from fsel.reconstruct.splats import Splats
from fsel.selection.candidates import EVEN, RULE, candidates, serving, uniform, with_fixed
from fsel.selection.validation import (
    STATED,
    WHOLE,
    AcceptanceRule,
    CandidateScore,
    TimeBudget,
    ValidationResult,
)

VALIDATION = 96  # frames at most that are rendered and scored
LEAST_PICKS = 3  # that are reconstructed from
HEATS = ((None, 1), (3, 1), (1, 2))  # selections that run, None for all, and shares of new fits
SHARE_SECONDS = 5.0  # of patience for one fit of each share
MOST_SHARES = 20  # beyond which fits tell no more
STRETCHES = 12  # of the validation frames at most: neighbours are not independent
LEAST_STRETCH = 3  # frames of a stretch
CHANCE = 0.05  # one-sided, by Student's t over the stretches, for all that are tried together
FIT_DEVIATION = 0.17  # dB of one fit by `gaussians`, by its seed alone
SIDE = 64  # pixels
SETTINGS: dict[str, Any] = {"steps": 150, "gaussians": 2000, "background": "mean"}
METRICS = ("psnr", "ssim")
BLOCK = 32  # frames that are opened at a time, at the size they have


def validated(
    problem: Problem, rule: np.ndarray, patience: TimeBudget, targets: np.ndarray
) -> ValidationResult | None:
    """Try the picks of the rule, and the simple selections of `fsel.selection.candidates`.

    Every machine makes the planned fits and keeps the same picks, but for one so slow or loaded
    that it reaches the time's ceiling, some times the patience.

    Args:
        rule: (K,) the picks of `fsel`, best first.
        targets: (F,) frames that are held out; empty where the whole capture is to be rendered.

    Returns:
        None without patience, or with too few frames to reconstruct or to score.
    """
    halving = halving_of(problem, rule, targets) if patience.seconds else None
    if halving is None:
        return None
    share = max(1, round(min(patience.seconds / SHARE_SECONDS, MOST_SHARES)))
    return halving.run(share, patience)


def halving_of(problem: Problem, rule: np.ndarray, targets: np.ndarray) -> SuccessiveHalving | None:
    """Return the comparison before its first fit; None and arguments as of `validated`."""
    pool, k = problem.sequence, len(rule)
    acceptance = WHOLE if problem.targets_unknown else STATED
    spare = len(pool) - k if problem.targets_unknown else len(targets)
    if k < LEAST_PICKS or spare < acceptance.validation:
        return None
    if problem.targets_unknown:
        tried = {EVEN: pool[uniform(problem, k)], RULE: rule} | candidates(problem, k)
    else:
        tried = {RULE: rule} | serving(problem, rule, targets)
    names: dict[tuple[int, ...], str] = {}
    for name, frames in tried.items():
        names.setdefault(subset_key(with_fixed(problem, frames)), name)
    picks = {name: np.array(key) for key, name in names.items()}
    validation = pool if problem.targets_unknown else targets
    validation = validation[evenly(len(validation), VALIDATION)]
    score = small_fits(problem.capture, validation, picks)
    return SuccessiveHalving(score, picks, validation, acceptance)


class SuccessiveHalving:
    """Comparison of selections with a first one, in heats: the best go on with new fits.

    `picks` maps names to (K,) ascending frames, of which the first is kept unless another meets the
    rule; `validation` are (W,) frames that are scored.
    """

    def __init__(
        self,
        score: Scorer,
        picks: Mapping[str, np.ndarray],
        validation: np.ndarray,
        rule: AcceptanceRule = WHOLE,
    ) -> None:
        self._score, self._picks, self._validation = score, dict(picks), validation
        self._rule = rule
        self._scores: dict[str, dict[str, list[np.ndarray]]] = {
            name: {"splats": [], "gaussians": []} for name in picks
        }
        self._first, *others = self._picks
        self._hopeful = [name for name in others if self._free(name).sum() >= rule.validation]
        self._started: float | None = None

    def run(self, share: int, patience: TimeBudget) -> ValidationResult:
        """Run all heats, with `share` fits of a selection in the first, up to the time's ceiling.
        Time runs from the end of the first fit by `gaussians`, which may have to be compiled.
        """
        if self._hopeful and self._rule.sure:
            every = [(name, None) for name in (self._first, *self._hopeful)]
            for name, scores in self._fits(every):
                self._scores[name]["splats"].append(scores)
        self._hopeful = [name for name in self._hopeful if self._rule.agreed(self.trial(name))]
        heats = [(count, share * shares) for count, shares in HEATS]
        left = sum(self._runners(count) * seeds for count, seeds in heats)
        over, cut, seed = False, False, 0
        for count, seeds in heats:
            names = self._contenders()[:count]
            cut = cut or (over and len(names) > 0)
            if cut or not names:
                break
            jobs = [(name, seed + at) for at in range(seeds) for name in (self._first, *names)]
            made = self._made
            over = self._heat(jobs, left, patience)
            cut = over and self._made < made + len(jobs)
            left -= self._runners(count) * seeds
            seed += seeds
        trials, on_targets = tuple(map(self.trial, self._picks)), not self._rule.sure
        return ValidationResult(trials, self._kept(), self._made, cut, on_targets, patience.seconds)

    def trial(self, name: str) -> CandidateScore:
        """Return what is known of a selection; its error is infinite before both have scored it."""
        frames, free, made = self._picks[name], self._free(name), self._scores
        count, first = int(free.sum()), made[self._first]
        both = {
            by: (np.array(own)[:, free], np.array(first[by])[:, free])
            for by, own in made[name].items()
            if own and first[by]
        }
        fits = sum(map(len, made[name].values()))
        if count < self._rule.validation or not both:
            return CandidateScore(name, frames, np.nan, np.nan, np.nan, np.inf, count, fits)
        gain, least, ssim, error = compared(both)
        error = error if "gaussians" in both else np.inf
        return CandidateScore(name, frames, gain, least, ssim, error, count, fits)

    def _free(self, name: str) -> np.ndarray:
        """(W,) validation frames that neither a selection nor the first one holds."""
        return ~np.isin(self._validation, np.union1d(self._picks[name], self._picks[self._first]))

    def _contenders(self) -> list[str]:
        """Selections that may still be kept, the best first."""
        trials = [self.trial(name) for name in self._hopeful]
        open_ = [one for one in trials if not one.gain + _chance(one) <= self._rule.margin]
        return [one.name for one in sorted(open_, key=lambda one: -one.gain)]

    def _kept(self) -> str:
        """The best selection of those that meet the rule; else the first one."""
        trials = [one for one in map(self.trial, self._hopeful) if self._rule.agreed(one)]
        ahead = [one for one in trials if one.gain > self._margin(one)]
        return max(ahead, key=lambda one: one.gain).name if ahead else self._first

    def _margin(self, trial: CandidateScore) -> float:
        """Gain in dB to be exceeded; infinite where `gaussians` were not fitted."""
        sure = self._rule.sure or np.isinf(trial.error)
        return max(self._rule.margin, _chance(trial, len(self._picks) - 1) if sure else 0.0)

    def _runners(self, count: int | None) -> int:
        """Count the selections that a heat has at most, the first one included."""
        return len(self._hopeful[:count]) + 1 if self._hopeful else 0

    @property
    def _made(self) -> int:
        return sum(len(scores) for made in self._scores.values() for scores in made.values())

    def _heat(self, jobs: list[tuple[str, int]], left: int, patience: TimeBudget) -> bool:
        """Make some fits; whether the time's ceiling was reached, or progress ended them."""
        planned, most = self._made + left, patience.ceiling * patience.seconds
        for name, scores in self._fits(jobs):
            self._scores[name]["gaussians"].append(scores)
            self._started = self._started or time.perf_counter()
            gone = time.perf_counter() - self._started
            if not patience.progress(self._made, planned, gone) or gone > most:
                return True
        return False

    def _fits(self, jobs: Sequence[tuple[str, int | None]]) -> Iterator[tuple[str, np.ndarray]]:
        """Yield the names of jobs with their scores, in order, fitted on all threads."""
        made = side_by_side(lambda job: self._score(self._picks[job[0]], job[1]), jobs)
        return zip((name for name, _ in jobs), made, strict=True)


def compared(
    judged: Mapping[str, tuple[np.ndarray, np.ndarray]],
) -> tuple[float, float, float, float]:
    """Measure how far one selection is ahead of another on frames that neither holds.

    Args:
        judged: `splats`, `gaussians` or both: (S, J, 2) and (S', J, 2) PSNR in dB and SSIM by fits
            and frames, of the one and the other, J >= 2, frames in capture order.

    Returns:
        Mean difference of PSNR; the least of a reconstructor, of PSNR and of SSIM; the standard
        error of the first: of frames, by the spread of the means of neighbours, and of fits.
    """
    each = np.array([own.mean(axis=0) - other.mean(axis=0) for own, other in judged.values()])
    mean = each[..., 0].mean(axis=0)
    means = np.array([group.mean() for group in np.array_split(mean, _stretches(len(mean)))])
    of_frames = means.var(ddof=1) / len(means)
    fits = sum(1 / len(fitted) for fitted in judged.get("gaussians", ()))
    of_fits = FIT_DEVIATION**2 * fits / len(judged) ** 2
    least, ssim = each.mean(axis=1).min(axis=0)
    return float(mean.mean()), float(least), float(ssim), float(np.sqrt(of_frames + of_fits))


def _stretches(count: int) -> int:
    """Count the stretches that so many validation frames are cut into."""
    return int(np.clip(count // LEAST_STRETCH, 2, STRETCHES))


def _chance(trial: CandidateScore, tried: int = 1) -> float:
    """Gain in dB that chance may bring to the best of so many (Bonferroni)."""
    return trial.error * float(stdtrit(_stretches(trial.validation) - 1, 1 - CHANCE / tried))


Scorer = Callable[[np.ndarray, int | None], np.ndarray]
"""(K,) frames -> (W, 2) PSNR in dB and SSIM by `gaussians` of a seed, or, for None, `splats`."""


def small_fits(capture: Capture, validation: np.ndarray, picks: Mapping[str, np.ndarray]) -> Scorer:
    """Make what fits the selections at a small size and scores them on (W,) validation frames."""
    needed = np.unique(np.concatenate([validation, *picks.values()]))
    small, rows = _small(capture, needed), np.searchsorted(needed, validation)
    truth, views = np.asarray(small.images[rows]), small.view(rows)
    masks = None if small.masks is None else small.masks[rows]

    def score(frames: np.ndarray, seed: int | None) -> np.ndarray:
        by = Splats(small) if seed is None else Gaussians(small, **SETTINGS, seed=seed)
        model = by.fit(np.searchsorted(needed, frames))
        return score_views(model.render(views), truth, masks, METRICS)

    return score


def _small(capture: Capture, frames: np.ndarray) -> Capture:
    """Some frames of a capture at the size of the trials, opened a few at a time."""
    blocks = np.array_split(frames, len(frames) // BLOCK + 1)
    parts = [capture.subset(block).resized(SIDE) for block in blocks]
    masks = None
    if capture.masks is not None:
        masks = np.concatenate([np.asarray(part.masks) for part in parts])
    images = np.concatenate([np.asarray(part.images) for part in parts])
    whole = replace(capture, masks=None).subset(frames, images)
    intrinsics = np.concatenate([part.intrinsics for part in parts])
    return replace(whole, intrinsics=intrinsics, masks=masks)
