"""Selections compared on a capture's own frames by successive halving.

Not in the paper. No single rule wins on every capture. So a few selections are reconstructed and
scored on frames that neither they nor uniform sampling contain: by `splats`, and those ahead there
by small `gaussians` too. Another one replaces uniform sampling where both reconstructors put it
ahead by 0.2 dB and not behind in SSIM, and their mean by 0.5 dB and beyond chance.

With targets that are frames, their own images can score instead: another selection replaces the
rule's where `gaussians` put it ahead by 0.2 dB, and picks that are no more than the targets are
exchanged as long as there is time. Gains: docs/results/captures_unknown.md and captures_known.md.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from scipy.special import stdtrit

from fsel.core.problem import Problem
from fsel.core.subsets import evenly, subset_key
from fsel.core.threads import side_by_side
from fsel.selection.candidates import EVEN, RULE, candidates, serving, with_fixed
from fsel.selection.small_fits import Scorer, small_fits
from fsel.selection.validation import (
    STATED,
    WHOLE,
    AcceptanceRule,
    CandidateScore,
    TimeBudget,
    ValidationResult,
)
from fsel.selectors.baselines.by_pose import nearest_frames

VALIDATION = 96  # frames at most that are rendered and scored
LEAST_PICKS = 3  # that are reconstructed from
HEATS = ((None, 1), (3, 1), (1, 2))  # selections that run, None for all, and shares of new fits
SHARE_SECONDS = 5.0  # of patience for one fit of each share
MOST_SHARES = 20  # beyond which fits tell no more
KNOWN_SHARES = 2  # of those where targets score: the rest of the time goes to exchanges
ROUND, ROUND_SECONDS = 8, 4.0  # exchanges that are tried at a time; of patience for them
AROUND = 8  # times as many frames as picks, the nearest to the targets, may come in
EXCHANGED = "exchanges"
NONE = np.empty(0, np.int64)
STRETCHES = 12  # of the validation frames at most: neighbours are not independent
LEAST_STRETCH = 3  # frames of a stretch
CHANCE = 0.05  # one-sided, by Student's t over the stretches, for all that are tried together
FIT_DEVIATION = 0.17  # dB of one fit by `gaussians`, by its seed alone


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
    exchanged = len(halving.near) > len(rule)
    most = KNOWN_SHARES if exchanged else MOST_SHARES
    share = max(1, round(min(patience.seconds / SHARE_SECONDS, most)))
    left = patience.seconds - most * SHARE_SECONDS
    return halving.run(share, patience, max(0, round(left / ROUND_SECONDS)) if exchanged else 0)


def halving_of(problem: Problem, rule: np.ndarray, targets: np.ndarray) -> SuccessiveHalving | None:
    """Return the comparison before its first fit; None and arguments as of `validated`."""
    pool, k = problem.sequence, len(rule)
    acceptance = WHOLE if problem.targets_unknown else STATED
    spare = len(pool) - k if problem.targets_unknown else len(targets)
    if k < LEAST_PICKS or spare < acceptance.validation:
        return None
    if problem.targets_unknown:
        simple = candidates(problem, k)
        tried = {EVEN: simple[EVEN], RULE: rule} | simple
    else:
        tried = {RULE: rule} | serving(problem, rule, targets)
    names: dict[tuple[int, ...], str] = {}
    for name, frames in tried.items():
        names.setdefault(subset_key(with_fixed(problem, frames)), name)
    picks = {name: np.array(key) for key, name in names.items()}
    validation = pool if problem.targets_unknown else targets
    validation = validation[evenly(len(validation), VALIDATION)]
    near = near_targets(problem, k, targets)
    score = small_fits(problem.capture, validation, [*picks.values(), near])
    return SuccessiveHalving(score, picks, validation, acceptance, near, problem.fixed_picks)


def near_targets(problem: Problem, k: int, targets: np.ndarray) -> np.ndarray:
    """Return the frames that may come in by exchanges, some times as many as the k picks; none for
    more picks than targets, which exchanges do not improve."""
    if k > len(targets):
        return NONE
    return nearest_frames(problem, problem.sequence, min(AROUND * k, len(problem.sequence)))


class SuccessiveHalving:
    """Comparison of selections with a first one, in heats: the best go on with new fits.

    `picks` maps names to (K,) ascending frames, of which the first is kept unless another meets the
    rule; `validation` are (W,) frames that are scored; picks but those of `fixed` may be exchanged
    for frames of `near`.
    """

    def __init__(
        self,
        score: Scorer,
        picks: Mapping[str, np.ndarray],
        validation: np.ndarray,
        rule: AcceptanceRule = WHOLE,
        near: np.ndarray = NONE,
        fixed: np.ndarray = NONE,
    ) -> None:
        self._score, self._picks, self._validation = score, dict(picks), validation
        self._rule, self.near, self._fixed, self._others = rule, near, fixed, 0
        self._scores: dict[str, dict[str, list[np.ndarray]]] = {
            name: {"splats": [], "gaussians": []} for name in picks
        }
        self._first, *others = self._picks
        self._hopeful = [name for name in others if self._free(name).sum() >= rule.validation]
        self._started: float | None = None

    def run(self, share: int, patience: TimeBudget, rounds: int = 0) -> ValidationResult:
        """Run all heats, with `share` fits of a selection in the first, and rounds of exchanges, up
        to the time's ceiling.

        Time runs from the end of the first fit by `gaussians`, which may have to be compiled.
        """
        if self._hopeful and self._rule.sure:
            every = [(name, None) for name in (self._first, *self._hopeful)]
            for name, scores in self._fits(every):
                self._scores[name]["splats"].append(scores)
        self._hopeful = [name for name in self._hopeful if self._rule.agreed(self.trial(name))]
        heats = [(count, share * shares) for count, shares in HEATS]
        left = sum(self._runners(count) * seeds for count, seeds in heats) + rounds * (ROUND + 1)
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
        kept = self._kept()
        if rounds and not over:
            kept, cut = self._improved(kept, rounds, patience)
        trials, on_targets = tuple(map(self.trial, self._picks)), not self._rule.sure
        return ValidationResult(trials, kept, self._made, cut, on_targets, patience.seconds)

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

    def _improved(self, kept: str, rounds: int, patience: TimeBudget) -> tuple[str, bool]:
        """Exchange picks of a selection, in each round the best of some exchanges where two fits
        gain by it; name what comes of it, and say whether time was up."""
        picks, fitted = self._picks[kept], self._scores[kept]["gaussians"][:2]
        fitted += [self._score(picks, seed) for seed in range(len(fitted), 2)]
        now, over, rng = picks, False, np.random.default_rng(0)
        for left in reversed(range(rounds)):
            if over:
                break
            gone, come = np.setdiff1d(now, self._fixed), np.setdiff1d(self.near, now)
            pairs = zip(rng.choice(gone, ROUND), rng.choice(come, ROUND), strict=True)
            tried = [np.sort(np.append(now[now != out], new)) for out, new in pairs]
            first = list(side_by_side(lambda frames: self._score(frames, 0), tried))
            best = int(np.argmax([_psnr(scores) for scores in first]))
            self._others += ROUND
            if _psnr(first[best]) > _psnr(fitted[0]):
                second = self._score(tried[best], 1)
                self._others += 1
                if _psnr(second) > _psnr(fitted[1]):
                    now, fitted = tried[best], [first[best], second]
            over = self._late(left * (ROUND + 1), patience) and left > 0
        if now is picks:
            return kept, over
        self._picks[EXCHANGED], self._scores[EXCHANGED] = now, {"splats": [], "gaussians": fitted}
        return EXCHANGED, over

    @property
    def _made(self) -> int:
        kept = sum(len(scores) for made in self._scores.values() for scores in made.values())
        return kept + self._others

    def _heat(self, jobs: list[tuple[str, int]], left: int, patience: TimeBudget) -> bool:
        """Make some fits; whether the time's ceiling was reached, or progress ended them."""
        planned = self._made + left
        for name, scores in self._fits(jobs):
            self._scores[name]["gaussians"].append(scores)
            if self._late(planned - self._made, patience):
                return True
        return False

    def _late(self, left: int, patience: TimeBudget) -> bool:
        """Show progress with so many fits left; return whether it or the time's ceiling ends it."""
        self._started = self._started or time.perf_counter()
        gone = time.perf_counter() - self._started
        shown = patience.progress(self._made, self._made + left, gone)
        return not shown or gone > patience.ceiling * patience.seconds

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


def _psnr(scores: np.ndarray) -> float:
    return float(scores[:, 0].mean())


def _stretches(count: int) -> int:
    """Count the stretches that so many validation frames are cut into."""
    return int(np.clip(count // LEAST_STRETCH, 2, STRETCHES))


def _chance(trial: CandidateScore, tried: int = 1) -> float:
    """Gain in dB that chance may bring to the best of so many (Bonferroni)."""
    return trial.error * float(stdtrit(_stretches(trial.validation) - 1, 1 - CHANCE / tried))
