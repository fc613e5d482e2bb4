"""Reads the shipped English acoustic model and dictionary, which :mod:`pack` has written.

Senones, weights and triphones are exact; means and the logarithms of variances have half precision, which changes a senone's
score by 0.01 on average (successive frames differ by five). assets/NOTICE.txt names the authors."""

from pathlib import Path

import numpy as np

from ... import npz
from .sphinx_model import Parts, UnreadableModel

ENGLISH = Path(__file__).parents[2] / "assets" / "english.npz"
_PREFIX = 3
"""The search in the dictionary skips all words that share this many first letters at once."""


def read(path: Path = ENGLISH) -> Parts:
    """Read the acoustic model; raises :class:`UnreadableModel`."""
    try:
        with npz.open_arrays(path) as data:
            return Parts(
                phones=_text(data["phones"]).split(),
                silence=int(data["silence"]),
                triphones=np.cumsum(data["triphones"], axis=0, dtype=np.uint8),
                means=_join_halves(data["means"]).astype(np.float32),
                variances=np.exp(_join_halves(data["variances"]).astype(np.float32)),
                found=data["found"].astype(int),
                **{name: data[name] for name in ("sequences", "alone", "matrix", "weights", "transitions")},
            )
    except (OSError, npz.NotArrays) as error:
        raise UnreadableModel(f"{path.name} is damaged: {error}") from error


def pronunciations(wanted: set[str], path: Path = ENGLISH) -> dict[str, list[str]]:
    """Return the pronunciations of those words that are in the dictionary, phones separated by spaces."""
    with npz.open_arrays(path) as data:
        names, shared, ends = _text(data["sounds"]).split(), data["shared"], np.cumsum(data["lengths"])
        rest, phones = _text(data["rest"]).split("\n"), data["said"]
    entries: dict[str, list[str]] = {}
    beginnings, word = {base[:_PREFIX] for base in wanted}, ""
    heads = np.flatnonzero(shared < _PREFIX).tolist()
    shared = shared.tolist()
    if len(shared) != len(rest):
        raise npz.NotArrays("its words are not as many as their letters")
    for head, following in zip(heads, [*heads[1:], len(rest)], strict=True):
        word = word[: shared[head]] + rest[head]
        if _base(word)[:_PREFIX] not in beginnings:
            continue  # no word with this beginning is wanted
        for number in range(head, following):
            word = word[: shared[number]] + rest[number]
            if (base := _base(word)) in wanted:
                begin = ends[number - 1] if number else 0
                entries.setdefault(base, []).append(" ".join(names[phone] for phone in phones[begin : ends[number]]))
    return entries


def _base(word: str) -> str:
    """Return a word without the number of its pronunciation, as in ``read(2)``."""
    return word.partition("(")[0]


def phone_pairs(path: Path = ENGLISH) -> tuple[list[str], np.ndarray]:
    """Return the names of phones and counts ``(names + 1, names + 1)`` of pairs in the words of the dictionary.

    An entry counts how often the phone of its column precedes that of its row; the last row and column are word borders."""
    with npz.open_arrays(path) as data:
        names, lengths, phones = _text(data["sounds"]).split(), data["lengths"].astype(int), data["said"].astype(int)
    border = len(names)
    line = np.insert(phones, np.cumsum(lengths), border)
    count = np.zeros((border + 1, border + 1))
    np.add.at(count, (line, np.roll(line, 1)), 1)
    return names, count


def _join_halves(halves: np.ndarray) -> np.ndarray:
    """Undo :func:`pack._split_halves`."""
    return np.ascontiguousarray(np.moveaxis(halves, 0, -1)).view("<f2")[..., 0]


def _text(array: np.ndarray) -> str:
    return array.tobytes().decode()
