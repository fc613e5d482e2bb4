"""Logs of unexpected errors (bugs), for attaching to a report."""

import os
import platform
import sys
import tempfile
import traceback

from .version import VERSION


def write_log(error: BaseException) -> str:
    """Write a log of ``error`` and return a sentence for the user that names it."""
    try:
        handle, path = tempfile.mkstemp(prefix="s2ag-mistake-", suffix=".log")
        with open(handle, "w", encoding="utf-8", errors="backslashreplace") as file:
            file.write("\n".join(_environment()) + "\n\n")
            file.writelines(traceback.format_exception(error))
    except OSError as failure:
        return f"Please report it; its log could not be written ({failure.strerror or failure}), S2AG_DEBUG=1 shows it."
    return f"Please report it with the log {path}."


def _environment() -> list[str]:
    numpy = sys.modules.get("numpy")
    return [
        f"s2ag {VERSION}, Python {platform.python_version()}, numpy {getattr(numpy, '__version__', 'not loaded')}",
        f"{platform.platform()}, {os.cpu_count()} cores",
        f"command: {sys.argv[1:]}",
    ]
