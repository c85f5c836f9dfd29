"""Selections tried on the capture itself, where nobody says what will be rendered.

Not in the paper. No simple rule is good on every capture: every n-th frame is hard to beat where a
camera moves steadily and bad where photos lie in clusters. So a few selections are reconstructed
and scored on frames that neither they nor every n-th frame hold: by `splats`, and those that are
ahead there by small `gaussians`, too. Another one is kept instead of every n-th frame where both
reconstructors put it ahead by 0.2 dB and not behind in SSIM, and the mean of both says that it is
ahead by 0.5 dB and beyond chance: what one reconstructor alone prefers does not speak for others.
What this gains is in docs/results/captures_unknown.md.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.special import stdtrit

from fsel.data.capture import Capture
from fsel.data.problem import Problem
from fsel.data.subsets import evenly, subset_key
from fsel.metrics import score_views
from fsel.reconstruct.gaussians import Gaussians
from fsel.reconstruct.splats import Splats
from fsel.request.candidates import EVEN, candidates
from fsel.request.patience import Patience, Trial, Tried

SIDE = 64  # pixels
SETTINGS: dict[str, Any] = {"steps": 150, "gaussians": 2000, "background": "mean"}
METRICS = ("psnr", "ssim")
VALIDATION = 96  # frames at most that are rendered and scored
LEAST_VALIDATION = 8  # frames that neither of two selections holds
LEAST_PICKS = 3  # that are reconstructed from
HEATS = ((None, 1), (3, 1), (1, 2))  # selections that run, None for all, and shares of new fits
SHARE_SECONDS = 5.0  # of patience for one fit of each share
MOST_SHARES = 20  # beyond which fits tell no more
MARGIN = 0.5  # dB that every n-th frame is to be left behind by
LEAST_GAIN = 0.2  # dB, the same by each reconstructor alone
STRETCHES = 12  # of the validation frames at most: neighbours are not independent
LEAST_STRETCH = 3  # frames of a stretch
CONFIDENCE = 0.95  # one-sided, by Student's t over the stretches
FIT_DEVIATION = 0.17  # dB of one fit by `gaussians`, by its seed alone
BLOCK = 32  # frames that are opened at a time, at the size they have

Scorer = Callable[[np.ndarray, int | None], np.ndarray]
"""(K,) frames -> (W, 2) PSNR in dB and SSIM of the validation frames.

By `gaussians` of a seed, or for None by `splats`, which has no chance in it.
"""


def tried(problem: Problem, rule: np.ndarray, patience: Patience) -> Tried | None:
    """Try the picks of the rule, and the simple selections of `fsel.request.candidates`.

    Every machine keeps the same picks, unless the time is over before the planned fits are made.

    Args:
        problem: of a whole capture; the images of frames that may be picked are read.
        rule: (K,) the picks of `fsel`.
        patience: for how long.

    Returns:
        What was found; None without patience, or where there are too few frames to reconstruct
        from or to score on.
    """
    race = race_of(problem, rule) if patience.seconds else None
    if race is None:
        return None
    share = max(1, round(min(patience.seconds / SHARE_SECONDS, MOST_SHARES)))
    return race.run(share, patience)


def race_of(problem: Problem, rule: np.ndarray) -> Race | None:
    """The race before its first fit; None and arguments as of `tried`."""
    pool, k = problem.sequence, len(rule)
    if k < LEAST_PICKS or len(pool) < k + LEAST_VALIDATION:
        return None
    picks = _distinct({EVEN: pool[evenly(len(pool), k)], "fsel": rule} | candidates(problem, k))
    validation = pool[evenly(len(pool), VALIDATION)]
    return Race(small_fits(problem.capture, validation, picks), picks, validation)


def _distinct(picks: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The same in ascending order, without those that equal one before them."""
    names: dict[tuple[int, ...], str] = {}
    for name, frames in picks.items():
        names.setdefault(subset_key(frames), name)
    return {name: np.array(key) for key, name in names.items()}


class Race:
    """Selections against every n-th frame, in heats: the best go on with new fits.

    Args:
        score: what a fit of a selection is worth.
        picks: name -> (K,) ascending frames; the first is every n-th frame.
        validation: (W,) frames that are scored.
    """

    def __init__(
        self, score: Scorer, picks: Mapping[str, np.ndarray], validation: np.ndarray
    ) -> None:
        self._score, self._picks, self._validation = score, dict(picks), validation
        self._splats: dict[str, np.ndarray] = {}
        self._scores: dict[str, list[np.ndarray]] = {name: [] for name in picks}
        self._even, *others = self._picks
        self._hopeful = [name for name in others if self._free(name).sum() >= LEAST_VALIDATION]
        self._started: float | None = None

    def run(self, share: int, patience: Patience) -> Tried:
        """All heats, or those before the time is over.

        Args:
            share: fits of a selection in the first heat.
            patience: for how long, and what follows the progress. The time runs from the end of the
                first fit by `gaussians`, which may have to be compiled.
        """
        for name in (self._even, *self._hopeful) if self._hopeful else ():
            self._splats[name] = self._score(self._picks[name], None)
        self._hopeful = [name for name in self._hopeful if _ahead(self.trial(name))]
        heats = [(count, share * shares) for count, shares in HEATS]
        left = sum(self._runners(count) * seeds for count, seeds in heats)
        over, cut, seed = False, False, 0
        for count, seeds in heats:
            names = self._contenders()[:count]
            cut = cut or (over and len(names) > 0)
            if cut or not names:
                break
            jobs = [(name, seed + at) for at in range(seeds) for name in (self._even, *names)]
            made = self._made
            over = self._heat(jobs, left, patience)
            cut = over and self._made < made + len(jobs)
            left -= self._runners(count) * seeds
            seed += seeds
        return Tried(tuple(map(self.trial, self._picks)), self._kept(), self._made, cut)

    def trial(self, name: str) -> Trial:
        """Return what is known of a selection; its error is infinite before both have scored it."""
        frames, free, scores = self._picks[name], self._free(name), self._scores
        fits, count = len(scores[name]) + (name in self._splats), int(free.sum())
        if count < LEAST_VALIDATION or name not in self._splats:
            return Trial(name, frames, np.nan, np.nan, np.nan, np.inf, count, fits)
        judged = [(self._splats[name][None], self._splats[self._even][None])]
        if both := bool(scores[name] and scores[self._even]):
            judged.append((np.array(scores[name]), np.array(scores[self._even])))
        gain, least, ssim, error = compared([(own[:, free], even[:, free]) for own, even in judged])
        return Trial(name, frames, gain, least, ssim, error if both else np.inf, count, fits)

    def _free(self, name: str) -> np.ndarray:
        """(W,) validation frames that neither a selection nor every n-th frame holds."""
        return ~np.isin(self._validation, np.union1d(self._picks[name], self._picks[self._even]))

    def _contenders(self) -> list[str]:
        """Selections that may still be kept, the best first."""
        trials = [self.trial(name) for name in self._hopeful]
        open_ = [one for one in trials if not one.gain + _chance(one) <= MARGIN]
        return [one.name for one in sorted(open_, key=lambda one: -one.gain)]

    def _kept(self) -> str:
        """The best selection of those surely ahead of every n-th frame; else that itself."""
        trials = [one for one in map(self.trial, self._hopeful) if _ahead(one)]
        ahead = [one for one in trials if one.gain > max(MARGIN, _chance(one))]
        return max(ahead, key=lambda one: one.gain).name if ahead else self._even

    def _runners(self, count: int | None) -> int:
        """Count the selections that a heat has at most, every n-th frame included."""
        return len(self._hopeful[:count]) + 1 if self._hopeful else 0

    @property
    def _made(self) -> int:
        return sum(map(len, self._scores.values())) + len(self._splats)

    def _heat(self, jobs: list[tuple[str, int]], left: int, patience: Patience) -> bool:
        """Make some fits, one after the other, until the time is over; whether it is."""
        planned = self._made + left
        for name, seed in jobs:
            self._scores[name].append(self._score(self._picks[name], seed))
            self._started = self._started or time.perf_counter()
            gone = time.perf_counter() - self._started
            if not patience.progress(self._made, planned, gone) or gone > patience.seconds:
                return True
        return False


def compared(
    judged: Sequence[tuple[np.ndarray, np.ndarray]],
) -> tuple[float, float, float, float]:
    """Measure how far one selection is ahead of another on frames that neither holds.

    Args:
        judged: by `splats`, then by `gaussians` if they were fitted: (S, J, 2) and (S', J, 2) PSNR
            in dB and SSIM by fits and frames, of the one and the other, J >= 2, frames in capture
            order.

    Returns:
        Mean difference of PSNR; the least of a reconstructor, of PSNR and of SSIM; the standard
        error of the first: of frames, by the spread of the means of neighbours, and of fits.
    """
    each = np.array([own.mean(axis=0) - even.mean(axis=0) for own, even in judged])
    mean = each[..., 0].mean(axis=0)
    means = np.array([group.mean() for group in np.array_split(mean, _stretches(len(mean)))])
    of_frames = means.var(ddof=1) / len(means)
    fits = sum(1 / len(own) + 1 / len(even) for own, even in judged[1:])
    of_fits = FIT_DEVIATION**2 * fits / len(judged) ** 2
    least, ssim = each.mean(axis=1).min(axis=0)
    return float(mean.mean()), float(least), float(ssim), float(np.sqrt(of_frames + of_fits))


def small_fits(capture: Capture, validation: np.ndarray, picks: Mapping[str, np.ndarray]) -> Scorer:
    """Make what fits selections at a small size, the only frames opened being those it needs.

    Args:
        capture: at any size.
        validation: (W,) frames that are scored.
        picks: the selections that will be asked for.
    """
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


def _stretches(count: int) -> int:
    """Count the stretches that so many validation frames are cut into."""
    return int(np.clip(count // LEAST_STRETCH, 2, STRETCHES))


def _chance(trial: Trial) -> float:
    """Gain in dB that chance may bring: the fewer frames are scored, the more."""
    return trial.error * float(stdtrit(_stretches(trial.validation) - 1, CONFIDENCE))


def _ahead(trial: Trial) -> bool:
    """Return whether each reconstructor puts a selection ahead, and not behind in SSIM."""
    return trial.least > LEAST_GAIN and trial.ssim >= 0
