"""Forced alignment, run as a program of its own: what it computes holds up nobody, and where pocketsphinx's C code is asked
for a model of another kind and crashes, only that process dies.

The engine is numpy's (:mod:`ear`): Sphinx's English model of phones (:mod:`acoustic`, :mod:`cepstra`), words as a graph of
phones (:mod:`graph`), and the best path through it (:mod:`viterbi`). :mod:`follow` leads it along long recordings.

Started by :mod:`align` as ``python -P .../aligner/start.py``, whatever name this package goes by. Standard input is one line
of JSON and then ``samples`` little-endian int16 samples at 16 kHz::

    {"stretches": [{"words": [[spoken, ...], ...], "start": 0.0, "end": 61.5}, ...],     words said between two moments
     "pauses": [[start, end], ...], "samples": n, "folder": "for temporary files", "model": null or {"acoustic": folder or null,
     "dictionary": file or null, "letters": {"sch": "SH", ...} or null, "voice": "de" or null}}

Standard output is JSON lines, ``{"progress": 0..1}`` and last ``{"spans": [[start, end, confidence, phones] or null, ...]}``,
one for every word of every stretch; phones are ``[name, start, end]``. A word in capitals is spelt out where no dictionary
knows it. Sound is read as it is needed and forgotten afterwards, so memory does not grow with the recording.
"""
