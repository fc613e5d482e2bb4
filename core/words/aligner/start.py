"""Run :mod:`serve` by path: the package it lies in goes by another name and is not imported itself, only what serving needs."""

import importlib
import os
import sys
import types
from pathlib import Path

if __name__ == "__main__":
    name = "s2ag_aligner"
    sys.modules[name] = types.ModuleType(name)
    sys.modules[name].__path__ = [str(Path(__file__).parents[2])]
    threads = importlib.import_module(f"{name}.threads")
    threads.cores()  # is asked first: work is shared out here, while products this small gain nothing from a second thread
    for key, one in threads.ONE_EACH.items():
        os.environ.setdefault(key, one)
    importlib.import_module(f"{name}.words.aligner.serve").main()
