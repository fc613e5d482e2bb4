"""Looks up 300-dimensional vectors of any word, known or not, and places them on pose frames.

The shipped file holds 50,000 words and 50,000 FastText n-gram buckets, packed by :mod:`build` with a mean cosine of 0.983 to
the original vectors; assets/NOTICE.txt names their sources."""

import unicodedata
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Protocol

import numpy as np

from .. import npz
from ..errors import VectorsUnreadable
from ..optional_packages import has_gensim
from ..words.spelling import normalise, spoken_words

DIMENSIONS = 300
_MAX_VALUE = 65504.0
"""The largest number in half precision, in which tables are stored."""
SHIPPED = Path(__file__).parents[1] / "assets" / "words.npz"


class Table(Protocol):
    """The vectors of a vocabulary: rows by number, and guesses for unknown words."""

    key_to_index: dict[str, int]

    def rows(self, indices: np.ndarray) -> np.ndarray:
        """Return the vectors ``(len(indices), 300)`` float32."""
        ...

    def guess(self, word: str) -> np.ndarray | None:
        """Return a vector ``(300,)`` for an unknown word, or None."""
        ...


class WordVectors:
    """300-dimensional vectors by word, with the interface of gensim's ``KeyedVectors``.

    A word is looked up as written, normalised (lower case, straight apostrophe, no punctuation), without accents, without a
    possessive ``'s``, as its spoken parts (``well-known``, ``25``: the mean of the parts), and last by FastText character
    n-grams, if the file has them. Anything else, such as a dash, gives the zero vector."""

    def __init__(self, table: Table, name: str):
        self._table = table
        self.name = name
        self._cache: dict[str, np.ndarray] = {}

    @classmethod
    def load(cls, path: str | PathLike | None = None) -> "WordVectors":
        """Load the shipped vectors, or a file of the user: our ``.npz``, FastText or word2vec ``.bin``, ``.vec``.

        All but ``.npz`` need gensim. Raises :class:`VectorsUnreadable`."""
        path = Path(path) if path is not None else SHIPPED
        check_readable(path)
        if path.suffix == ".npz":
            return cls(PackedTable.read(path), path.name)
        from .gensim_reader import read_vectors

        return cls(read_vectors(path), path.name)

    @property
    def key_to_index(self) -> dict[str, int]:
        """Row number of every word in the vocabulary."""
        return self._table.key_to_index

    def __len__(self) -> int:
        return len(self.key_to_index)

    def __contains__(self, word: str) -> bool:
        """Return whether the word, as written or normalised, is in the vocabulary; other words have a vector, too."""
        return self._key(word) is not None

    def vector(self, word: str) -> np.ndarray:
        """Return the vector ``(300,)`` float32, read-only; zero for anything that is no word."""
        if word not in self._cache:
            vector = np.asarray(self._find(word), np.float32)
            vector.flags.writeable = False
            self._cache[word] = vector
        return self._cache[word]

    def vectors(self, words: Sequence[str]) -> np.ndarray:
        """Return the vectors ``(len(words), 300)`` float32."""
        return np.stack([self.vector(word) for word in words]) if len(words) else np.zeros((0, DIMENSIONS), np.float32)

    def _key(self, word: str) -> str | None:
        """Return the form of a word that is in the vocabulary, or None."""
        plain = normalise(word)
        bare = "".join(char for char in unicodedata.normalize("NFKD", plain) if not unicodedata.combining(char))
        for form in (word, plain, bare, plain.removesuffix("'s")):
            if form in self.key_to_index:
                return form
        return None

    def _find(self, word: str) -> np.ndarray:
        key = self._key(word)
        if key is not None:
            return self._table.rows(np.array([self.key_to_index[key]]))[0]
        parts = spoken_words(word)
        if parts and parts != [normalise(word)]:
            return self.vectors(parts).mean(0)
        guess = self._table.guess(parts[0]) if parts else None
        return np.zeros(DIMENSIONS, np.float32) if guess is None else guess


def check_readable(path: str | PathLike) -> None:
    """Raise :class:`VectorsUnreadable` unless ``path`` is a file that :meth:`WordVectors.load` can read in this environment."""
    path = Path(path)
    if not path.is_file():
        raise VectorsUnreadable(f"The word vectors {path} do not exist.", "Check the name, or use the shipped ones.")
    if path.suffix == ".kv":
        remedy = 'If you trust its maker: KeyedVectors.load("a.kv").save_word2vec_format("a.bin", binary=True) in Python.'
        raise VectorsUnreadable(f"{path} is a pickle, a program that would run when it is read.", remedy)
    if path.suffix not in (".npz", ".bin", ".vec"):
        raise VectorsUnreadable(f"{path} is no known kind of word vectors.", "Use .npz, .bin or .vec.")
    if path.suffix != ".npz" and not has_gensim():
        raise VectorsUnreadable(f"{path} needs gensim, which is not installed.", 'Install it with: pip install "s2ag[vectors]"')


class PackedTable:
    """Product-quantised words and FastText n-gram buckets, as :mod:`build` writes them; rows are decoded on demand."""

    def __init__(self, arrays: dict[str, np.ndarray]):
        names = arrays["words"].tobytes().decode().split("\n")
        self.key_to_index = {name: row for row, name in enumerate(names)}
        self._words = {key.removeprefix("word_"): value for key, value in arrays.items() if key.startswith("word_")}
        self._ngrams = {key.removeprefix("ngram_"): value for key, value in arrays.items() if key.startswith("ngram_")}

    @classmethod
    def read(cls, path: Path) -> "PackedTable":
        """Read a packed file; raise :class:`VectorsUnreadable` for anything else."""
        try:
            with npz.open_arrays(path) as data:
                packed = cls({key: data[key] for key in data})
            packed.check()
            packed.rows(np.array([0, len(packed.key_to_index) - 1]))
            packed.guess("word")
        except Exception as error:  # np.load and zipfile raise many types for damaged files
            raise VectorsUnreadable(f"{path} holds no packed word vectors.", "Build it with core/vectors/build.py.") from error
        return packed

    def check(self) -> None:
        """Raise ValueError for arrays of wrong types, numbers out of range and missing axes."""
        for table in (self._words, self._ngrams):
            numbers = [table[name] for name in ("centroids", "norms")]
            if any(part.dtype.kind != "f" or not np.abs(part).max(initial=0) <= _MAX_VALUE for part in numbers):
                raise ValueError("numbers out of range")
            if not np.array_equal(np.sort(table["order"]), np.arange(DIMENSIONS)):
                raise ValueError("axes are missing")

    def rows(self, indices: np.ndarray) -> np.ndarray:
        """Return the vectors ``(len(indices), 300)`` float32."""
        return decode(self._words, indices)

    def guess(self, word: str) -> np.ndarray:
        """Return the mean ``(300,)`` of the word's n-gram vectors, as FastText does for unknown words."""
        low, high = self._ngrams["bounds"]
        hashes = ngram_hashes(word, int(low), int(high), len(self._ngrams["codes"]))
        return decode(self._ngrams, np.array(hashes)).mean(0) if hashes else np.zeros(DIMENSIONS, np.float32)


def decode(packed: dict[str, np.ndarray], indices: np.ndarray) -> np.ndarray:
    """Return rows ``(len(indices), 300)`` float32 of a product-quantised table.

    Centroids are concatenated, axes restored to their order and multiplied by the norms."""
    codes, centroids = packed["codes"][indices], packed["centroids"]
    rows = np.empty((len(codes), centroids.shape[0] * centroids.shape[2]), np.float32)
    rows[:, packed["order"]] = centroids[np.arange(len(centroids)), codes].reshape(len(codes), -1)
    return rows * packed["norms"][indices].astype(np.float32)[:, None]


def ngram_hashes(word: str, shortest: int, longest: int, buckets: int) -> list[int]:
    """Return FastText's bucket numbers of all character n-grams of ``<word>``: 32-bit FNV-1a of UTF-8 bytes read as signed."""
    characters = [char.encode() for char in f"<{word}>"]
    result = []
    for start in range(len(characters)):
        value = 2166136261
        for length, char in enumerate(characters[start : start + longest], 1):
            for byte in char:
                value = (value ^ (byte if byte < 128 else byte | 0xFFFFFF00)) * 16777619 & 0xFFFFFFFF
            if length >= shortest and not (length == 1 and start in (0, len(characters) - 1)):
                result.append(value % buckets)
    return result


def word_per_frame(
    words: Sequence[tuple[str, float, float]], frames: int, fps: float = 15.0, start: float = 0.0, mode: str = "span"
) -> np.ndarray:
    """Return ``(frames,)`` int32: the number of the ``(word, start, end)`` spoken in each pose frame, -1 for none.

    ``mode="span"`` marks every frame from a word's onset to its end (at least one); ``"onset"`` only the first, as in the
    published code (reference section B.4). Frame 0 is at ``start`` seconds. A word that is being spoken at ``start`` begins in
    frame 0, one that has ended is absent, and of two words in one frame the later wins."""
    if mode not in ("span", "onset"):
        raise ValueError(f"mode is 'span' or 'onset', not {mode!r}")
    index = np.full(frames, -1, np.int32)
    for number, (_, begin, end) in enumerate(words):
        if max(begin, end) < start or (begin < start and end == start):
            continue
        first = max(int(np.floor((begin - start) * fps + 1e-6)), 0)
        last = max(int(np.ceil((end - start) * fps - 1e-6)), first + 1) if mode == "span" else first + 1
        index[first:last] = number
    return index


def vectors_per_frame(
    words: Sequence[tuple[str, float, float]], vectors: WordVectors, frames: int, fps: float = 15.0, start: float = 0.0,
    mode: str = "span"
) -> np.ndarray:  # fmt: skip
    """Return ``(frames, 300)`` float32: the vector of the word spoken in each frame (:func:`word_per_frame`), else zero."""
    index = word_per_frame(words, frames, fps, start, mode)
    numbers, inverse = np.unique(index[index >= 0], return_inverse=True)
    result = np.zeros((frames, DIMENSIONS), np.float32)
    if len(numbers):
        result[index >= 0] = vectors.vectors([words[number][0] for number in numbers])[inverse]
    return result
