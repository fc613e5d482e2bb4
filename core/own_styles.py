"""Styles of one's own: files that ``s2ag learn`` writes, chosen by their path or, in the user's folder of styles, by name."""

import json
import math
import re
from os import PathLike
from pathlib import Path
from typing import Any

from . import json_text, user_folders
from .errors import UnknownStyle
from .files import atomic_file

FORMAT, SUFFIX = "s2ag style 1", ".json"
_REMEDY = "Name a file that s2ag learn has written."


def folder() -> Path | None:
    """Return the user's folder of styles, None where there is no home."""
    try:
        return user_folders.data() / "styles"
    except RuntimeError:
        return None


def path_of(name: str) -> Path:
    """Return the file of a style in the user's folder. Raises :class:`UnknownStyle` for what cannot be a name."""
    own = folder()
    if own is None or not name.strip() or set(name) & set("+:>") or name.lower().endswith(SUFFIX):
        raise UnknownStyle(f"{name!r} cannot be the name of a style.", "Leave out +, : and >, and give it letters.")
    stem = re.sub(r"[^\w-]+", "_", name.strip()).lower()
    return own / f"{stem}{SUFFIX}"


def listed() -> list[dict]:
    """Return the styles in the user's folder, by name; files that are none are left out."""
    own, found = folder(), []
    try:
        paths = sorted(own.glob("*" + SUFFIX)) if own else []
    except OSError:
        return []  # it may not be read: there are no styles, and a name that is asked for is told as unknown
    for path in paths:
        try:
            found.append(read(path))
        except UnknownStyle:
            continue  # told when the file itself is named
    return found


def read(path: str | PathLike) -> dict[str, Any]:
    """Read a style: ``name``, ``description``, ``weights`` (their hash), ``point`` of the latent space, ``rest`` pose,
    ``answers`` to accents and other facts of a speaker, and of the source ``manner`` (figures) and ``seconds``.

    Raises :class:`UnknownStyle` for a file that is none."""
    try:
        style = json_text.read(path, 1_000_000)
    except (OSError, ValueError) as error:
        raise UnknownStyle(f"The style {path} cannot be read: {error}.", _REMEDY) from error
    if not isinstance(style, dict) or style.get("format") != FORMAT or not _is_whole(style):
        raise UnknownStyle(f"{path} is no style of this version.", _REMEDY)
    return style


def write(style: dict, path: Path) -> None:
    """Write a style, atomically; the user's folder is made if it is missing."""
    if path.parent == folder():
        path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_file(path) as temporary:
        temporary.write_text(json.dumps(style, indent=1), "utf-8")


def find(name: str) -> dict[str, Any] | None:
    """Return the style of a name, which is a path or that of a style in the user's folder; None where there is none.

    Raises :class:`UnknownStyle` for files that are none."""
    if name.lower().endswith(SUFFIX):
        return read(name)
    wanted = name.casefold()
    return next((one for one in listed() if one["name"].casefold() == wanted), None)


def _is_whole(style: dict) -> bool:
    """Whether a style has its parts, their shapes, and numbers wherever it has no text."""
    kinds = {"format": str, "name": str, "description": str, "weights": str, "answers": dict, "manner": dict, "point": list}
    try:
        leaves = [leaf for part in style.values() if not isinstance(part, str) for leaf in _leaves(part)]
        shaped = len(style["rest"]) == 9 and all(len(row) == 3 for row in style["rest"])
        typed = all(isinstance(style[name], kind) for name, kind in kinds.items()) and bool(style["seconds"])
        return shaped and typed and all(math.isfinite(one) for one in leaves) and bool(style["name"])
    except (KeyError, TypeError):
        return False


def _leaves(value: Any) -> list:
    """Return what lists and objects hold in the end."""
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list) else None
    return [value] if parts is None else [leaf for part in parts for leaf in _leaves(part)]
