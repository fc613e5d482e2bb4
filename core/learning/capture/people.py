"""Several people in a picture: finds their faces, and the part of the picture with the one who speaks, or who is named."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...errors import CorpusUnreadable, UsageError
from ...sound.audio import SAMPLE_RATE
from . import estimator, film

_RATE = 8.0
"""Pictures a second in which faces are looked for."""
_BURSTS, _BURST = 6, 3.0
"""Faces are looked for in so many parts of a film, of so many seconds each."""
_LEAST_SHARE = 0.25
"""A person is seen in this share of the pictures at least."""
_ASIDE, _ABOVE, _BELOW = 2.6, 1.2, 7.0
"""How far the part of the picture reaches from a face's middle, in heights of the face."""
_SPEAKS = 1.3
"""How many times as much as others the lips of the one who speaks move, where there is a voice."""


@dataclass(eq=False)
class Person:
    """The faces of one person: ``boxes`` (middle x, middle y, width, height), lips and voice at their moments."""

    boxes: list[np.ndarray] = field(default_factory=list)
    lips: list[float] = field(default_factory=list)
    loud: list[bool] = field(default_factory=list)

    @property
    def middle(self) -> np.ndarray:
        return np.median(self.boxes, axis=0)

    @property
    def speech(self) -> float:
        """How much the lips move while there is a voice."""
        moves = np.abs(np.diff(self.lips)) if len(self.lips) > 2 else np.zeros(1)
        heard = np.array(self.loud[1:]) if len(self.lips) > 2 else np.zeros(1, bool)
        return float(np.nanmean(moves[heard])) if np.isfinite(moves[heard]).any() else 0.0


def choose(
    path: Path, person: int | str | None, sound: np.ndarray | None, progress: Callable[[float], object]
) -> tuple[tuple[float, float, float, float], list[str]]:
    """Return the part of the picture to look at and sentences for the user. Raises :class:`UsageError` for nobody's number."""
    everyone = find(path, sound, progress)
    if person is None and len(everyone) < 2:
        return estimator.WHOLE, []
    if not everyone:
        raise CorpusUnreadable(f"No face is seen in {path}.", "Leave --person out, or choose another film.")
    number = _speaker(everyone) if person is None else _named(person, len(everyone))
    why = "the one who speaks, or else is largest" if person is None else "as asked for"
    note = f"{len(everyone)} people are seen; number {number + 1} from the left is captured, {why} (--person N takes another)."
    return _region(everyone, number, film.facts(path)), [note]


def find(path: Path, sound: np.ndarray | None, progress: Callable[[float], object]) -> list[Person]:
    """Return the people whose faces are seen in a good part of the film, from left to right."""
    facts, everyone, moments = film.facts(path), [], []

    def pictures() -> Iterator[tuple[bool, np.ndarray]]:
        for picture in film.pictures(path, _RATE, _spans(facts.seconds)):
            moments.append(picture.time)
            yield False, picture.pixels

    heard = iter(range(10**9))

    def hear(answer: dict) -> object:
        if "done" in answer:
            return True
        at = moments[next(heard)]
        progress(min(at / max(facts.seconds, 1e-6), 1.0))
        _assign(everyone, answer["faces"], _is_loud(sound, at))
        return None

    estimator.run("faces", pictures(), hear, facts.seconds)
    lasting = [one for one in everyone if len(one.boxes) >= _LEAST_SHARE * len(moments)]
    return sorted(lasting, key=lambda one: one.middle[0])


def _spans(seconds: float) -> list[tuple[float, float]] | None:
    """Return the parts of the film that are looked at, None for all of a short one."""
    if seconds <= _BURSTS * _BURST:
        return None
    return [(start, start + _BURST) for start in np.linspace(0, seconds - _BURST, _BURSTS)]


def _assign(everyone: list[Person], faces: list, loud: bool) -> None:
    """Give each face to the person who was nearest, or to a new one."""
    free = list(everyone)
    for x, y, width, height, lips in sorted(faces, key=lambda face: -face[3]):
        box = np.array([x + width / 2, y + height / 2, width, height])
        near = [one for one in free if np.hypot(*(one.boxes[-1] - box)[:2]) < 1.2 * max(width, height)]
        if near:
            who = min(near, key=lambda one: np.hypot(*(one.boxes[-1] - box)[:2]))
            free.remove(who)
        else:
            who = Person()
            everyone.append(who)
        who.boxes.append(box)
        who.lips.append(np.nan if lips is None else float(lips))
        who.loud.append(loud)


def _is_loud(sound: np.ndarray | None, at: float) -> bool:
    if sound is None:
        return False
    here = sound[max(int((at - 0.1) * SAMPLE_RATE), 0) : int((at + 0.1) * SAMPLE_RATE)]
    return bool(len(here)) and float(np.sqrt(np.mean(here**2))) > 0.3 * float(np.sqrt(np.mean(sound**2)))


def _speaker(everyone: list[Person]) -> int:
    """Return who speaks: whose lips move clearly most where there is a voice, else whose face is largest."""
    speech = np.array([one.speech for one in everyone])
    best = int(speech.argmax())
    if speech[best] > max(_SPEAKS * np.delete(speech, best).max(initial=0), 1e-4):
        return best
    return int(np.argmax([one.middle[3] for one in everyone]))


def _named(person: int | str, count: int) -> int:
    sides = {"left": 1, "right": count}
    number = sides.get(str(person).lower(), person)
    if not (str(number).isdecimal() and 1 <= int(number) <= count):
        raise UsageError(f"There is no person {person} among the {count} in the film.", f"Give 1 to {count}, from the left.")
    return int(number) - 1


def _region(everyone: list[Person], number: int, facts: film.Facts) -> tuple[float, float, float, float]:
    """Return the part of the picture around a person, no further than half way to the neighbours."""
    x, y, _, tall = everyone[number].middle
    wide = tall * facts.height / facts.width
    left, right = x - _ASIDE * wide, x + _ASIDE * wide
    if number > 0:
        left = max(left, (everyone[number - 1].middle[0] + x) / 2)
    if number < len(everyone) - 1:
        right = min(right, (everyone[number + 1].middle[0] + x) / 2)
    box = np.clip([left, y - _ABOVE * tall, right, y + _BELOW * tall], 0, 1)
    return tuple(float(edge) for edge in box)  # pyright: ignore[reportReturnType]
