"""Chooses the clips and order for each participant: balanced, shuffled, under anonymous names. Needs numpy alone."""

import hashlib
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

import numpy as np

from ..errors import UsageError
from . import sounds

CLIPS = (".mp4", ".webm")


@dataclass(frozen=True)
class Design:
    """The clips of a study: files by (condition, excerpt), or (condition, excerpt, "own" or "other" sound).

    ``names`` are their names on the page; ``form`` is one of :data:`build.FORMS`.
    """

    conditions: tuple[str, ...]
    excerpts: tuple[str, ...]
    clips: dict[tuple[str, ...], Path]
    names: dict[tuple[str, ...], str]
    seed: int
    form: str = "rating"

    def orders(self, participants: int) -> list[list]:
        """Return for each participant the names of clips, or of pairs of clips (left, right), in order."""
        if self.form == "rating":
            return [[self.names[key] for key in self.order(number)] for number in range(participants)]
        return [[[self.names[key] for key in pair] for pair in self.pairs(number)] for number in range(participants)]

    def pairs(self, participant: int) -> list[tuple[tuple[str, ...], tuple[str, ...]]]:
        """Return left and right clip of every trial for the ``participant`` (from 0), shuffled for each.

        Form "pairs" has every two conditions of every excerpt, "matched" every clip with its own and another sound. Sides are
        exchanged from one participant to the next, and balanced over the trials of each.
        """
        if self.form == "pairs":
            combinations = [(a, b) for at, a in enumerate(self.conditions) for b in self.conditions[at + 1 :]]
            trials = [((a, excerpt), (b, excerpt)) for excerpt in self.excerpts for a, b in combinations]
        else:
            clips = ((condition, excerpt) for excerpt in self.excerpts for condition in self.conditions)
            trials = [((*one, "own"), (*one, "other")) for one in clips]
        random = np.random.default_rng((self.seed, participant // 2))  # two share the order, with sides exchanged
        turned = random.permutation(len(trials)) % 2 == participant % 2
        shuffled = random.permutation(len(trials))
        return [trials[row][::-1] if turned[row] else trials[row] for row in shuffled]

    def order(self, participant: int) -> list[tuple[str, str]]:
        """Return (condition, excerpt) of every clip for the ``participant`` (from 0), excerpt by excerpt.

        Excerpts are shuffled for each participant. Within an excerpt the conditions follow a row of a Williams square, so that
        over participants and excerpts each is in each place, and before each other one, equally often.
        """
        random = np.random.default_rng((self.seed, participant))
        square = williams(len(self.conditions))
        shuffled = random.permutation(len(self.excerpts))
        return [
            (self.conditions[condition], self.excerpts[number])
            for number in shuffled
            for condition in square[(participant + number) % len(square)]
        ]


def find(folder: str | PathLike, seed: int = 0, form: str = "rating") -> Design:
    """Return the design for ``folder``, which has a folder for every condition, each with the same clips.

    Raises :class:`UsageError` if conditions or clips are missing.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise UsageError(f"There is no folder {folder}.", "Give one with a folder of clips for every condition.")
    films = {}
    for place in sorted(path for path in folder.iterdir() if path.is_dir()):
        clips = {path.stem: path for path in sorted(place.iterdir()) if path.suffix.lower() in CLIPS}
        if clips:
            films[place.name] = clips
    if len(films) < (1 if form == "matched" else 2):
        raise UsageError(f"{folder} holds clips of {len(films)} conditions.", "A study compares two or more, a folder each.")
    excerpts = sorted(set().union(*films.values()))
    for condition, clips in films.items():
        missing = [excerpt for excerpt in excerpts if excerpt not in clips]
        if missing:
            message = f"{folder / condition} has no clip {missing[0]}"
            raise UsageError(f"{message}, which other conditions have.", "Give every condition the same clips.")
    clips = {(condition, excerpt): films[condition][excerpt] for condition in films for excerpt in excerpts}
    names = {key: f"{_digest(seed, *key)}{path.suffix.lower()}" for key, path in clips.items()}
    return Design(tuple(films), tuple(excerpts), clips, names, seed, form)


def add_mismatched_sound(design: Design, folder: Path) -> Design:
    """Return a design with every clip twice, written to ``folder``: with its own sound and with that of another excerpt.

    Raises :class:`UsageError` for a single excerpt and for films without sound.
    """
    clips: dict[tuple[str, ...], Path] = {}
    for condition in design.conditions:
        films = {excerpt: design.clips[condition, excerpt] for excerpt in design.excerpts}
        others = sounds.sound_partners({excerpt: sounds.film_seconds(film) for excerpt, film in films.items()})
        for excerpt, film in films.items():
            for sound, heard in (("own", film), ("other", films[others[excerpt]])):
                key = condition, excerpt, sound
                clips[key] = folder / f"{_digest(design.seed, *key)}{film.suffix.lower()}"
                sounds.replace_sound(film, heard, clips[key])
    return replace(design, clips=clips, names={key: path.name for key, path in clips.items()})


def williams(count: int) -> list[list[int]]:
    """Return rows in which each of ``count`` conditions is in each place, and after each other one, equally often.

    There are ``count`` rows for even numbers, twice as many for odd ones (Williams 1949).
    """
    first = [0]
    for step in range(1, count):
        first.append((step + 1) // 2 if step % 2 else count - step // 2)
    rows = [[(place + shift) % count for place in first] for shift in range(count)]
    return rows if count % 2 == 0 else rows + [row[::-1] for row in rows]


def _digest(seed: int, *parts: str) -> str:
    return hashlib.sha256("\0".join([str(seed), *parts]).encode()).hexdigest()[:12]
