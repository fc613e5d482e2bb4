"""Analyses preferences between two clips, answers of -2 to 2: shares, an exact test and strengths. Needs numpy alone."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike

import numpy as np

from ..errors import UsageError
from ..multiple_testing import holm_correction
from .analysis import LEVEL, ROUNDS, interval, read_files, read_key

OTHER = "other sound"
"""The opponent of a condition in studies of the same motion with its own and with another sound."""


_Vote = tuple[tuple[str, str], int, dict[str, int]]


@dataclass(frozen=True)
class Votes:
    """Scores -2..2 ``(participants, excerpts)`` by question and pair: above 0 for the pair's first, NaN for missing answers."""

    participants: tuple[int, ...]
    conditions: tuple[str, ...]
    excerpts: tuple[str, ...]
    scores: dict[str, dict[tuple[str, str], np.ndarray]]


def read(files: Sequence[str | PathLike], key: str | PathLike) -> Votes:
    """Read the answers that the page saved in a study of pairs; raises :class:`UsageError` as :func:`analysis.read` does."""
    study = read_key(key)
    conditions, excerpts, clips = tuple(study["conditions"]), tuple(study["excerpts"]), study["clips"]
    names = tuple(question["id"] for question in study["questions"])
    people = read_files(files, study["id"], lambda answers: [_vote(one, clips, excerpts, names) for one in answers])
    numbers = tuple(sorted(people))
    scores: dict[str, dict[tuple[str, str], np.ndarray]] = {name: {} for name in names}
    for row, number in enumerate(numbers):
        for pair, column, values in people[number]:
            for name in names:
                turned = pair not in scores[name] and (pair[1], pair[0]) in scores[name]
                ordered = (pair[1], pair[0]) if turned else pair
                table = scores[name].setdefault(ordered, np.full((len(numbers), len(excerpts)), np.nan))
                table[row, column] = -values[name] if turned else values[name]
    return Votes(numbers, conditions, excerpts, scores)


def _vote(answer: dict, clips: dict, excerpts: tuple[str, ...], names: tuple[str, ...]) -> _Vote:
    """Return the pair, the excerpt's number and each question's score for the pair's first."""
    left, right = clips[answer["left"]], clips[answer["right"]]
    first, second = (OTHER if clip.get("sound") == "other" else clip["condition"] for clip in (left, right))
    if left["excerpt"] != right["excerpt"] or first == second or not all(isinstance(name, str) for name in (first, second)):
        raise ValueError("two clips are no pair")
    values = {name: answer[name] for name in names}
    for name, value in values.items():
        if isinstance(value, bool) or value not in (-2, -1, 0, 1, 2):
            raise ValueError(f"{name} is {value!r}")
    # The page counts positive to the right; a score is for the first of the pair, which is never the other sound.
    if first == OTHER:
        return (second, OTHER), excerpts.index(left["excerpt"]), values
    return (first, second), excerpts.index(left["excerpt"]), {name: -value for name, value in values.items()}


def analyse(votes: Votes, ours: str | None = None, seed: int = 0) -> dict:
    """Return counts, the first's share (ties count half) and mean with intervals, and an exact sign test, by question and pair.

    Intervals are percentiles of a bootstrap over participants; the test is two-sided over participants' means, so that
    each counts once, and corrected by Holm's method for the pairs of a question. Strengths are Bradley and Terry's, as
    logarithms around 0; ties count half for each, and one tie is added to every pair so that no strength is infinite.
    """
    if ours is not None and ours not in votes.conditions:
        raise UsageError(f"There is no condition {ours!r}.", f"Conditions are {', '.join(votes.conditions)}.")
    count = len(votes.participants)
    draws = np.random.default_rng(seed).integers(count, size=(ROUNDS, count))
    result: dict = {"participants": count, "excerpts": len(votes.excerpts), "questions": {}}
    for name, pairs in votes.scores.items():
        figures = {}
        for pair, scores in pairs.items():
            turned = pair[1] == ours
            figures["/".join(pair[::-1] if turned else pair)] = _figures(-scores if turned else scores, draws)
        for pair, corrected in holm_correction({pair: one["p"] for pair, one in figures.items()}).items():
            figures[pair]["p_holm"] = corrected
        result["questions"][name] = {"pairs": figures, "strengths": strengths(pairs, votes.conditions)}
    return result


def _figures(scores: np.ndarray, draws: np.ndarray) -> dict:
    """Return the figures of one pair; ``draws`` are bootstrap samples ``(k, participants)``."""
    answered = np.isfinite(scores)
    points = np.where(answered, (np.sign(np.nan_to_num(scores)) + 1) / 2, 0).sum(1)
    sums, counts = np.where(answered, scores, 0).sum(1), answered.sum(1)
    resampled = np.maximum(counts[draws].sum(1), 1)
    values = scores[answered]
    means = sums / np.maximum(counts, 1)
    return {
        "answers": len(values),
        "counts": {str(value): int((values == value).sum()) for value in (2, 1, 0, -1, -2)},
        "share": float(points.sum() / max(len(values), 1)),
        "interval": interval(points[draws].sum(1) / resampled),
        "mean": float(sums.sum() / max(len(values), 1)),
        "mean_interval": interval(sums[draws].sum(1) / resampled),
        "p": sign_test(int((means > 0).sum()), int((means < 0).sum())),
    }


def sign_test(above: int, below: int) -> float:
    """Return the two-sided exact p of a split at least as uneven, if both sides are equally likely."""
    total, least = above + below, min(above, below)
    return min(2 * sum(math.comb(total, number) for number in range(least + 1)) / 2**total, 1.0)


def strengths(pairs: dict[tuple[str, str], np.ndarray], conditions: tuple[str, ...]) -> dict[str, float]:
    """Return Bradley-Terry strengths by Hunter's MM algorithm (2004); empty unless three or more conditions were compared."""
    if len(conditions) < 3 or any(OTHER in pair for pair in pairs) or not pairs:
        return {}
    wins = np.zeros((len(conditions), len(conditions)))
    for pair, scores in pairs.items():
        first, second = map(conditions.index, pair)
        points = (np.sign(scores[np.isfinite(scores)]) + 1) / 2
        wins[first, second] += points.sum() + 0.5
        wins[second, first] += (1 - points).sum() + 0.5
    games, worth = wins + wins.T, np.ones(len(conditions))
    for _ in range(1000):
        worth = wins.sum(1) / np.maximum((games / (worth[:, None] + worth[None])).sum(1), 1e-12)
        worth /= np.exp(np.log(worth).mean())
    return {name: float(value) for name, value in zip(conditions, np.log(worth), strict=True)}


def report(result: dict) -> str:
    """Return the analysis as text."""
    lines = [f"{result['participants']} participants, {result['excerpts']} excerpts; {LEVEL:.0%} intervals over participants"]
    for name, question in result["questions"].items():
        lines += ["", f"{name}: share that preferred the first, ties half; mean of -2 to 2; answers from 2 down to -2"]
        for pair, found in question["pairs"].items():
            (low, high), (least, most) = found["interval"], found["mean_interval"]
            counts = " ".join(str(count) for count in found["counts"].values())
            first, second = pair.split("/", 1)
            lines.append(
                f"  {first} over {second}: {found['share']:.2%} [{low:.2%}, {high:.2%}]  mean {found['mean']:+.2f} "
                f"[{least:+.2f}, {most:+.2f}]  sign test p {found['p']:.4f}, Holm {found['p_holm']:.4f}  {counts}"
            )
        if question["strengths"]:
            ranked = sorted(question["strengths"].items(), key=lambda one: -one[1])
            lines.append("  Bradley-Terry: " + ", ".join(f"{name} {value:+.2f}" for name, value in ranked))
    return "\n".join(lines)
