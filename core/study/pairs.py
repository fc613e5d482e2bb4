"""Which of two clips was preferred: shares, an exact test and strengths, from answers of -2 to 2. numpy alone."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike

import numpy as np

from ..corrections import holm
from ..errors import UsageError
from .analysis import LEVEL, ROUNDS, interval, read_files, read_key

OTHER = "other sound"
"""What stands against a condition where the same motion was shown with its own sound and with another."""


@dataclass(frozen=True)
class Votes:
    """``scores[question][pair]`` ``(participants, excerpts)``, -2..2, above 0 for the pair's first, NaN without an answer."""

    participants: tuple[int, ...]
    conditions: tuple[str, ...]
    excerpts: tuple[str, ...]
    scores: dict[str, dict[tuple[str, str], np.ndarray]]


def read(files: Sequence[str | PathLike], key: str | PathLike) -> Votes:
    """Answers that the page saved in a study of pairs; raises :class:`UsageError` as :func:`analysis.read` does."""
    known = read_key(key)
    conditions, excerpts, clips = tuple(known["conditions"]), tuple(known["excerpts"]), known["clips"]
    names = tuple(question["id"] for question in known["questions"])
    people = read_files(files, known["id"], lambda given: [_vote(one, clips, excerpts, names) for one in given])
    numbers = tuple(sorted(people))
    scores: dict[str, dict[tuple[str, str], np.ndarray]] = {name: {} for name in names}
    for row, number in enumerate(numbers):
        for pair, column, values in people[number]:
            for name in names:
                turned = pair not in scores[name] and pair[::-1] in scores[name]
                kept = scores[name].setdefault(pair[::-1] if turned else pair, np.full((len(numbers), len(excerpts)), np.nan))
                kept[row, column] = -values[name] if turned else values[name]
    return Votes(numbers, conditions, excerpts, scores)


def _vote(answer: dict, clips: dict, excerpts: tuple[str, ...], names: tuple[str, ...]):
    """The pair, the excerpt's number and each question's score for the pair's first."""
    left, right = clips[answer["left"]], clips[answer["right"]]
    pair = tuple(OTHER if clip.get("sound") == "other" else clip["condition"] for clip in (left, right))
    if left["excerpt"] != right["excerpt"] or pair[0] == pair[1] or not all(isinstance(name, str) for name in pair):
        raise ValueError("two clips are no pair")
    values = {name: answer[name] for name in names}
    for name, value in values.items():
        if isinstance(value, bool) or value not in (-2, -1, 0, 1, 2):
            raise ValueError(f"{name} is {value!r}")
    # The page counts to the right; a score is for the first of the pair, which is never the other sound.
    if pair[0] == OTHER:
        return (f"{pair[1]}", OTHER), excerpts.index(left["excerpt"]), values
    return pair, excerpts.index(left["excerpt"]), {name: -value for name, value in values.items()}


def analyse(votes: Votes, ours: str | None = None, seed: int = 0) -> dict:
    """Per question and pair: counts, the first's share (ties count half) and mean with intervals, an exact sign test.

    Intervals are percentiles of a bootstrap over participants; the test is two-sided over participants' means, so that one
    who answers often counts once, and Holm's correction holds for all pairs of a question. Strengths are Bradley and Terry's,
    as logarithms around 0, ties half to each and one such tie added to every pair so that none is infinite.
    """
    if ours is not None and ours not in votes.conditions:
        raise UsageError(f"There is no condition {ours!r}.", f"Conditions are {', '.join(votes.conditions)}.")
    count = len(votes.participants)
    draws = np.random.default_rng(seed).integers(count, size=(ROUNDS, count))
    result: dict = {"participants": count, "excerpts": len(votes.excerpts), "questions": {}}
    for name, pairs in votes.scores.items():
        found = {}
        for pair, scores in pairs.items():
            turned = pair[1] == ours
            found["/".join(pair[::-1] if turned else pair)] = _figures(-scores if turned else scores, draws)
        for pair, corrected in holm({pair: one["p"] for pair, one in found.items()}).items():
            found[pair]["p_holm"] = corrected
        result["questions"][name] = {"pairs": found, "strengths": strengths(pairs, votes.conditions)}
    return result


def _figures(scores: np.ndarray, draws: np.ndarray) -> dict:
    asked = np.isfinite(scores)
    points = np.where(asked, (np.sign(np.nan_to_num(scores)) + 1) / 2, 0).sum(1)
    sums, counts = np.where(asked, scores, 0).sum(1), asked.sum(1)
    drawn = np.maximum(counts[draws].sum(1), 1)
    given = scores[asked]
    means = sums / np.maximum(counts, 1)
    return {
        "answers": len(given),
        "counts": {str(value): int((given == value).sum()) for value in (2, 1, 0, -1, -2)},
        "share": float(points.sum() / max(len(given), 1)),
        "interval": interval(points[draws].sum(1) / drawn),
        "mean": float(sums.sum() / max(len(given), 1)),
        "mean_interval": interval(sums[draws].sum(1) / drawn),
        "p": sign_test(int((means > 0).sum()), int((means < 0).sum())),
    }


def sign_test(above: int, below: int) -> float:
    """Two-sided exact probability of a split at least as uneven, were both sides equally likely."""
    total, least = above + below, min(above, below)
    return min(2 * sum(math.comb(total, number) for number in range(least + 1)) / 2**total, 1.0)


def strengths(pairs: dict[tuple[str, str], np.ndarray], conditions: tuple[str, ...]) -> dict[str, float]:
    """Bradley-Terry's strengths by Hunter's minorisation (2004); none where something else than conditions was compared."""
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
    """The analysis as text."""
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
