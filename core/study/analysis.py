"""Analyses ratings: the share of answers 4 and 5 with confidence intervals (paper section 5.5). Needs numpy alone."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import TypeVar

import numpy as np

from .. import json_text
from ..errors import UsageError
from .build import FORMS, QUESTIONS

HIGH = 4
ROUNDS = 10000
LEVEL = 0.95
_NAMES = tuple(question["id"] for question in QUESTIONS)

T = TypeVar("T")


@dataclass(frozen=True)
class Answers:
    """Ratings 1..5 of every question ``(participants, conditions, excerpts)``; NaN for missing answers."""

    participants: tuple[int, ...]
    conditions: tuple[str, ...]
    excerpts: tuple[str, ...]
    ratings: dict[str, np.ndarray]


def read(files: Sequence[str | PathLike], key: str | PathLike) -> Answers:
    """Read answers saved by the page, with the study's ``key.json``.

    Raises :class:`UsageError` for a file of another study, a participant who occurs twice, and invalid ratings.
    """
    study = read_key(key)
    conditions, excerpts, clips = tuple(study["conditions"]), tuple(study["excerpts"]), study["clips"]
    people = read_files(files, study["id"], lambda answers: _ratings(answers, clips, conditions, excerpts))
    numbers = tuple(sorted(people))
    return Answers(numbers, conditions, excerpts, {name: np.stack([people[n][name] for n in numbers]) for name in _NAMES})


def read_key(key: str | PathLike) -> dict:
    """Read a study's ``key.json``; raises :class:`UsageError`."""
    study = _json(key)
    try:
        texts = (study["id"], *study["conditions"], *study["excerpts"], study.setdefault("form", FORMS[0]))
        questions = study.setdefault("questions", QUESTIONS)
        clips = study["clips"]
        if not isinstance(clips, dict) or not all(isinstance(name, str) for name in texts) or study["form"] not in FORMS:
            raise TypeError("names that are no texts")
        if not (study["conditions"] and study["excerpts"] and all(isinstance(question["id"], str) for question in questions)):
            raise TypeError("nothing was asked")
    except (KeyError, TypeError) as error:
        raise UsageError(f"{key} is no key of a study.", "Give the key.json that s2ag study make wrote.") from error
    return study


def read_files(files: Sequence[str | PathLike], study: str, read_one: Callable[[list], T]) -> dict[int, T]:
    """Return ``read_one(answers)`` of each participant's file of ``study``; raises :class:`UsageError` as :func:`read`."""
    people: dict[int, T] = {}
    for file in files:
        content = _json(file)
        try:
            if content["study"] != study:
                raise UsageError(f"{file} belongs to the study {content['study']!r}.", f"Give answers of {study!r} only.")
            number = int(content["participant"])
            if number in people:
                raise UsageError(f"Participant {number} occurs twice.", "Leave one of the files out.")
            people[number] = read_one(content["answers"])
        except (KeyError, TypeError, ValueError, OverflowError, AttributeError) as error:
            raise UsageError(
                f"{file} holds no answers of this study ({error}).", "Give the files that the page saved."
            ) from error
    if not people:
        raise UsageError("There are no answers.", "Give the files that the page saved.")
    return people


def analyse(answers: Answers, ours: str | None = None, seed: int = 0) -> dict:
    """Return by question and condition: counts of 1..5, mean, share of 4 and 5 with interval, and differences from ``ours``.

    Intervals are percentiles of a bootstrap over participants, whose answers are not independent; shares are means over all
    answers. Differences are paired: the same participants answer for both.
    """
    if ours is not None and ours not in answers.conditions:
        raise UsageError(f"There is no condition {ours!r}.", f"Conditions are {', '.join(answers.conditions)}.")
    draws = np.random.default_rng(seed).integers(len(answers.participants), size=(ROUNDS, len(answers.participants)))
    result: dict = {"participants": len(answers.participants), "excerpts": len(answers.excerpts), "questions": {}}
    for name, ratings in answers.ratings.items():
        high = np.where(np.isnan(ratings), np.nan, ratings >= HIGH)
        hits, answered = np.nansum(high, axis=2), np.isfinite(high).sum(axis=2)
        shares = hits[draws].sum(1) / np.maximum(answered[draws].sum(1), 1)
        total = hits.sum(0) / np.maximum(answered.sum(0), 1)
        figures = {}
        for row, condition in enumerate(answers.conditions):
            here = ratings[:, row][np.isfinite(ratings[:, row])]
            figures[condition] = {
                "answers": len(here),
                "counts": [int((here == value).sum()) for value in range(1, 6)],
                "mean": float(here.mean()) if len(here) else float("nan"),
                "share": float(total[row]),
                "interval": interval(shares[:, row]),
            }
        result["questions"][name] = {"conditions": figures, "differences": {}}
        if ours is not None:
            our_row = answers.conditions.index(ours)
            result["questions"][name]["differences"] = {
                other: {
                    "difference": float(total[our_row] - total[row]),
                    "interval": interval(shares[:, our_row] - shares[:, row]),
                }
                for row, other in enumerate(answers.conditions)
                if row != our_row
            }
    return result


def report(result: dict, ours: str | None = None) -> str:
    """Return the analysis as text."""
    lines = [f"{result['participants']} participants, {result['excerpts']} excerpts; {LEVEL:.0%} intervals over participants"]
    for name, question in result["questions"].items():
        lines += ["", f"{name}: share of answers 4 and 5"]
        for condition, found in question["conditions"].items():
            low, high = found["interval"]
            counts = " ".join(map(str, found["counts"]))
            lines.append(
                f"  {condition:<24}{found['share']:7.2%}  [{low:.2%}, {high:.2%}]  mean {found['mean']:.2f}  1-5: {counts}"
            )
        for other, found in question["differences"].items():
            low, high = found["interval"]
            lines.append(f"  {ours} over {other}: {found['difference']:+.2%}  [{low:+.2%}, {high:+.2%}]")
    return "\n".join(lines)


def _ratings(answers: list[dict], clips: dict, conditions: tuple[str, ...], excerpts: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Return the ratings ``(conditions, excerpts)`` of a participant by question; raises ``ValueError`` for invalid ones."""
    ratings = {name: np.full((len(conditions), len(excerpts)), np.nan) for name in _NAMES}
    for answer in answers:
        if answer["clip"] not in clips:
            raise ValueError(f"clip {answer['clip']} is unknown")
        place = clips[answer["clip"]]
        row, column = conditions.index(place["condition"]), excerpts.index(place["excerpt"])
        for name in _NAMES:
            value = answer[name]
            if value not in (1, 2, 3, 4, 5):
                raise ValueError(f"{name} is {value!r}")
            ratings[name][row, column] = value
    return ratings


def interval(values: np.ndarray) -> list[float]:
    """Return the bounds of the middle 95 % of resampled values."""
    rest = 100 * (1 - LEVEL) / 2
    return [float(value) for value in np.percentile(values, [rest, 100 - rest])]


def _json(path: str | PathLike) -> dict:
    try:
        content = json_text.read(path)
    except (OSError, ValueError) as error:
        raise UsageError(f"{path} cannot be read as JSON.", "Give the files that the study wrote.") from error
    if not isinstance(content, dict):
        raise UsageError(f"{path} holds no JSON object.", "Give the files that the study wrote.")
    return content
