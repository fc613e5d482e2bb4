"""The English acoustic model and dictionary as they come with us: one file of a quarter of their size, made by :func:`write`.

    python -m s2ag.core.words.aligner.packed FOLDER english.npz

packs the folder ``en-us`` of pocketsphinx's models: senones, weights and triphones are its own to the bit; means and the
logarithms of variances are kept in half precision, which moves a senone's score by 0.01 in the mean, where one frame differs
from the next by five.
assets/NOTICE.txt names the makers.
"""

import sys
from pathlib import Path

import numpy as np

from ... import npz
from ...files import whole_file
from . import sphinx_model
from .sphinx_model import Parts, UnreadableModel

ENGLISH = Path(__file__).parents[2] / "assets" / "english.npz"
_LEAST = 1e-4
"""The variance below which Sphinx takes none to be."""
_ALIKE = 3
"""Letters that words of the dictionary begin with which are looked at or passed over together."""


def read(path: Path = ENGLISH) -> Parts:
    """The acoustic model; raises :class:`UnreadableModel`."""
    try:
        with npz.opened(path) as data:
            return Parts(
                phones=_text(data["phones"]).split(),
                silence=int(data["silence"]),
                triphones=np.cumsum(data["triphones"], axis=0, dtype=np.uint8),
                means=_whole(data["means"]).astype(np.float32),
                variances=np.exp(_whole(data["variances"]).astype(np.float32)),
                found=data["found"].astype(int),
                **{name: data[name] for name in ("sequences", "alone", "matrix", "weights", "transitions")},
            )
    except (OSError, npz.NotArrays) as error:
        raise UnreadableModel(f"{path.name} is damaged: {error}") from error


def pronunciations(wanted: set[str], path: Path = ENGLISH) -> dict[str, list[str]]:
    """Pronunciations of those words that the dictionary holds, phones divided by spaces."""
    with npz.opened(path) as data:
        names, shared, ends = _text(data["sounds"]).split(), data["shared"], np.cumsum(data["lengths"])
        rest, said = _text(data["rest"]).split("\n"), data["said"]
    found: dict[str, list[str]] = {}
    beginnings, word = {base[:_ALIKE] for base in wanted}, ""
    heads = np.flatnonzero(shared < _ALIKE).tolist()
    shared = shared.tolist()
    if len(shared) != len(rest):
        raise npz.NotArrays("its words are not as many as their letters")
    for head, following in zip(heads, [*heads[1:], len(rest)], strict=True):
        word = word[: shared[head]] + rest[head]
        if _base(word)[:_ALIKE] not in beginnings:
            continue  # nor is any other word that begins as this one does
        for number in range(head, following):
            word = word[: shared[number]] + rest[number]
            if (base := _base(word)) in wanted:
                begin = ends[number - 1] if number else 0
                found.setdefault(base, []).append(" ".join(names[one] for one in said[begin : ends[number]]))
    return found


def _base(word: str) -> str:
    """A word without the number of its pronunciation."""
    return word.partition("(")[0]


def neighbours(path: Path = ENGLISH) -> tuple[list[str], np.ndarray]:
    """Names of phones, and how often ``(names + 1, names + 1)`` the second stands before the first in words of the dictionary;
    the last row and column are a word's border."""
    with npz.opened(path) as data:
        names, lengths, said = _text(data["sounds"]).split(), data["lengths"].astype(int), data["said"].astype(int)
    border = len(names)
    line = np.insert(said, np.cumsum(lengths), border)
    count = np.zeros((border + 1, border + 1))
    np.add.at(count, (line, np.roll(line, 1)), 1)
    return names, count


def write(folder: Path, path: Path) -> None:
    """Pack ``folder`` with ``en-us`` (the acoustic model) and ``cmudict-en-us.dict``."""
    parts = sphinx_model.read(folder / "en-us")
    arrays = {
        **parts._asdict(),
        "phones": _bytes(" ".join(parts.phones)),
        "triphones": np.diff(parts.triphones, axis=0, prepend=np.zeros((1, 4), np.uint8)),
        "found": parts.found.astype(np.uint16),
        "sequences": np.asfortranarray(parts.sequences),
        "means": _halves(parts.means),
        "variances": _halves(np.log(np.maximum(parts.variances, _LEAST))),
        **_dictionary(folder / "cmudict-en-us.dict"),
    }
    with whole_file(path) as temporary:
        np.savez_compressed(temporary, **arrays)


def _dictionary(path: Path) -> dict[str, np.ndarray]:
    """Words as how many letters each shares with the one before and its others, and numbers of phones end to end."""
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


def _halves(values: np.ndarray) -> np.ndarray:
    """Half-precision numbers, their high bytes apart from the low ones, which packs better: ``(2, ...)`` uint8."""
    return np.moveaxis(values.astype("<f2")[..., None].view(np.uint8), -1, 0)


def _whole(halves: np.ndarray) -> np.ndarray:
    """What :func:`_halves` took apart."""
    return np.ascontiguousarray(np.moveaxis(halves, 0, -1)).view("<f2")[..., 0]


def _bytes(text: str) -> np.ndarray:
    return np.frombuffer(text.encode(), np.uint8)


def _text(array: np.ndarray) -> str:
    return array.tobytes().decode()


if __name__ == "__main__":
    write(Path(sys.argv[1]), Path(sys.argv[2]))
