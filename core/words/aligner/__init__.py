"""Forced alignment, run as a separate program: it blocks nobody, and if pocketsphinx's C code crashes on an unusual model, only
that process dies.

The standard engine is numpy (:mod:`numpy_engine`): Sphinx's English acoustic model (:mod:`acoustic`, :mod:`cepstra`), words as
a graph of phones (:mod:`graph`), and the best path through it (:mod:`viterbi`). :mod:`long_alignment` aligns long recordings
piece by piece.

:mod:`align` starts it as ``python -P .../aligner/start.py``, whatever the name of this package. Standard input is one line
of JSON and then ``samples`` little-endian int16 samples at 16 kHz::

    {"stretches": [{"words": [[spoken, ...], ...], "start": 0.0, "end": 61.5}, ...],     words between two times in seconds
     "pauses": [[start, end], ...], "samples": n, "folder": "for temporary files", "model": null or {"acoustic": folder or null,
     "dictionary": file or null, "letters": {"sch": "SH", ...} or null, "voice": "de" or null}}

Standard output is JSON lines, ``{"progress": 0..1}`` and last ``{"spans": [[start, end, confidence, phones] or null, ...]}``,
one for every word of every stretch; phones are ``[name, start, end]``. A word in capitals that is in no dictionary is spelt
out. Sound is read when needed and discarded afterwards, so memory does not grow with the recording."""
