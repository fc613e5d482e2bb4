"""Reads word vectors of the user with gensim: FastText ``.bin``, word2vec ``.bin`` and text ``.vec``, which contain no code."""

from pathlib import Path
from typing import Any

import numpy as np

from ..errors import VectorsUnreadable
from ..files import open_file

DIMENSIONS = 300
_FASTTEXT_MAGIC = 793712314


class Keyed:
    """A gensim ``KeyedVectors`` with the interface :class:`table.Table`."""

    def __init__(self, vectors: Any):
        self._vectors = vectors
        self.key_to_index: dict[str, int] = vectors.key_to_index

    def rows(self, indices: np.ndarray) -> np.ndarray:
        """Return the vectors ``(len(indices), 300)`` float32."""
        return np.asarray(self._vectors.vectors[indices], np.float32)

    def guess(self, word: str) -> np.ndarray | None:
        """Return a vector for an unknown word if the file has n-grams, else None."""
        if not hasattr(self._vectors, "vectors_ngrams"):
            return None
        try:
            return self._vectors.get_vector(word)
        except KeyError:
            return None


def read_vectors(path: Path) -> Keyed:
    """Load a file of the format that its suffix and, for ``.bin``, its first bytes tell; raises :class:`VectorsUnreadable`."""
    from gensim.models import KeyedVectors
    from gensim.models.fasttext import load_facebook_vectors

    name = str(path)
    try:
        if path.suffix == ".bin" and _is_fasttext(path):
            vectors = load_facebook_vectors(name)
        else:
            _check_size(path)
            vectors = KeyedVectors.load_word2vec_format(name, binary=path.suffix == ".bin")
        width = vectors.vector_size
    except Exception as error:  # gensim raises struct, unpickling, Unicode and value errors
        raise VectorsUnreadable(
            f"{path} cannot be read as word vectors ({type(error).__name__}).", "Download or save the file again."
        ) from error
    if width != DIMENSIONS:
        raise VectorsUnreadable(
            f"{path} holds {width}-dimensional vectors; the network reads {DIMENSIONS}.", "Choose vectors of 300 dimensions."
        )
    return Keyed(vectors)


def _check_size(path: Path) -> None:
    """Raise ValueError if a word2vec file is too small for the counts in its first line, as gensim would allocate that much."""
    with open_file(path) as file:
        count, width = map(int, file.readline(100).split())
    each = 4 if path.suffix == ".bin" else 2
    if count < 0 or not 0 < width <= 10_000 or count * width * each > path.stat().st_size:
        raise ValueError("it is cut off")


def _is_fasttext(path: Path) -> bool:
    with open_file(path) as file:
        return int.from_bytes(file.read(4), "little") == _FASTTEXT_MAGIC
