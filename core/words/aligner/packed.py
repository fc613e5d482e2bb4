"""Reads and writes the shipped English acoustic model and dictionary, one file of a quarter of the original size.

    python -m s2ag.core.words.aligner.packed FOLDER english.npz

packs the folder ``en-us`` of pocketsphinx's models. Senones, weights and triphones are exact; means and the logarithms of
variances have half precision, which changes a senone's score by 0.01 on average (successive frames differ by five).
assets/NOTICE.txt names the authors.
"""

import sys
from pathlib import Path

import numpy as np

from ... import npz
from ...files import whole_file
from . import sphinx_model
from .sphinx_model import Parts, UnreadableModel

ENGLISH = Path(__file__).parents[2] / "assets" / "english.npz"
_MIN_VARIANCE = 1e-4
"""Sphinx's floor of variances."""
_PREFIX = 3
"""The search in the dictionary skips all words that share this many first letters at once."""


def read(path: Path = ENGLISH) -> Parts:
    """Read the acoustic model; raises :class:`UnreadableModel`."""
    try:
        with npz.opened(path) as data:
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
    with npz.opened(path) as data:
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


def neighbours(path: Path = ENGLISH) -> tuple[list[str], np.ndarray]:
    """Return the names of phones and counts ``(names + 1, names + 1)`` of pairs in the words of the dictionary.

    An entry counts how often the phone of its column precedes that of its row; the last row and column are word borders.
    """
    with npz.opened(path) as data:
        names, lengths, phones = _text(data["sounds"]).split(), data["lengths"].astype(int), data["said"].astype(int)
    border = len(names)
    line = np.insert(phones, np.cumsum(lengths), border)
    count = np.zeros((border + 1, border + 1))
    np.add.at(count, (line, np.roll(line, 1)), 1)
    return names, count


def write(folder: Path, path: Path) -> None:
    """Pack ``folder``, which contains ``en-us`` (the acoustic model) and ``cmudict-en-us.dict``, into the file ``path``."""
    parts = sphinx_model.read(folder / "en-us")
    arrays = {
        **parts._asdict(),
        "phones": _bytes(" ".join(parts.phones)),
        "triphones": np.diff(parts.triphones, axis=0, prepend=np.zeros((1, 4), np.uint8)),
        "found": parts.found.astype(np.uint16),
        "sequences": np.asfortranarray(parts.sequences),
        "means": _split_halves(parts.means),
        "variances": _split_halves(np.log(np.maximum(parts.variances, _MIN_VARIANCE))),
        **_dictionary(folder / "cmudict-en-us.dict"),
    }
    with whole_file(path) as temporary:
        np.savez_compressed(temporary, **arrays)


def _dictionary(path: Path) -> dict[str, np.ndarray]:
    """Pack the dictionary: for every word the number of letters shared with the previous one and the rest of its letters, and
    the phone numbers of all words in one array, with their lengths."""
    lines = [line.split(None, 1) for line in path.read_text("utf-8").splitlines() if len(line.split(None, 1)) == 2]
    ways = [way.split() for _, way in lines]
    names = sorted({phone for way in ways for phone in way})
    number = {name: place for place, name in enumerate(names)}
    shared, rest, before = [], [], ""
    for word, _ in lines:
        same = next((at for at, (a, b) in enumerate(zip(word, before, strict=False)) if a != b), min(len(word), len(before)))
        shared.append(same)
        rest.append(word[same:])
        before = word
    return {
        "sounds": _bytes(" ".join(names)),
        "shared": np.array(shared, np.uint8),
        "rest": _bytes("\n".join(rest)),
        "lengths": np.array([len(way) for way in ways], np.uint8),
        "said": np.array([number[phone] for way in ways for phone in way], np.uint8),
    }


def _split_halves(values: np.ndarray) -> np.ndarray:
    """Convert to half precision ``(2, ...)`` uint8, low bytes separate from high ones, which compresses better."""
    return np.moveaxis(values.astype("<f2")[..., None].view(np.uint8), -1, 0)


def _join_halves(halves: np.ndarray) -> np.ndarray:
    """Undo :func:`_split_halves`."""
    return np.ascontiguousarray(np.moveaxis(halves, 0, -1)).view("<f2")[..., 0]


def _bytes(text: str) -> np.ndarray:
    return np.frombuffer(text.encode(), np.uint8)


def _text(array: np.ndarray) -> str:
    return array.tobytes().decode()


if __name__ == "__main__":
    write(Path(sys.argv[1]), Path(sys.argv[2]))
