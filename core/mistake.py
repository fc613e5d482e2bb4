"""Mistakes of our own: what there is to know about one goes to a file that can be attached to a report."""

import os
import platform
import sys
import tempfile
import traceback

from .version import VERSION


def keep(error: BaseException) -> str:
    """Write the log of ``error`` and return the sentence that says where it is and what it is for."""
    try:
        handle, path = tempfile.mkstemp(prefix="s2ag-mistake-", suffix=".log")
        with open(handle, "w", encoding="utf-8", errors="backslashreplace") as file:
            file.write("\n".join(_facts()) + "\n\n")
            file.writelines(traceback.format_exception(error))
    except OSError as refused:
        return f"Please report it; its log could not be written ({refused.strerror or refused}), S2AG_DEBUG=1 shows it."
    return f"Please report it with the log {path}."


def _facts() -> list[str]:
    numpy = sys.modules.get("numpy")
    return [
        f"s2ag {VERSION}, Python {platform.python_version()}, numpy {getattr(numpy, '__version__', 'not loaded')}",
        f"{platform.platform()}, {os.cpu_count()} cores",
        f"command: {sys.argv[1:]}",
    ]
