"""Runs :mod:`serve` by path: the package gets another name and is not imported as a whole, only the modules that are needed."""

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
    # before the limits below: this code uses all cores itself, while numpy's small products need one thread
    threads.thread_count()
    for key, one in threads.SINGLE_THREAD_ENVIRONMENT.items():
        os.environ.setdefault(key, one)
    importlib.import_module(f"{name}.words.aligner.serve").main()
