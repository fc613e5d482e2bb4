"""What the Python package has and Blender's extension lacks."""

import importlib.util

from ..errors import UsageError


def is_whole() -> bool:
    """Return whether this is the whole Python package rather than the extension's zip."""
    return importlib.util.find_spec("..learning", __package__) is not None


def require_whole(what: str, extra: str = "engine") -> None:
    """Raise :class:`UsageError` in the extension's zip, which lacks ``what``; ``extra`` of the package is what it needs."""
    if not is_whole():
        remedy = f'In a Python of your own: pip install "s2ag[{extra}]"'
        raise UsageError(f"{what} of the Python package s2ag, not of Blender's extension.", remedy)
