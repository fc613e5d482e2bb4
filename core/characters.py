"""Names of characters: human, human:RIG, mannequin, or a file. :mod:`s2ag_blender.characters` builds them in Blender."""

import re
from pathlib import Path

from .errors import RigUnusable, UsageError

SUFFIXES = (".blend", ".fbx", ".glb", ".gltf")


def is_builtin(name: str) -> bool:
    """Return whether a character is built in, not a file."""
    return name in ("human", "mannequin") or (name.startswith("human:") and not Path(name).suffix)


def is_seat(text: str) -> bool:
    """Return whether a text says if a character sits: auto, off, on, or the height of its table in metres, as in 0.74."""
    return text in ("auto", "off", "on") or bool(re.fullmatch(r"[0-9]{1,3}(\.[0-9]+)?", text))


def resolve(name: str) -> str:
    """Return a built-in name or the absolute path of a file.

    Raises :class:`UsageError` for unknown names and kinds of files, and :class:`RigUnusable` for missing files."""
    if is_builtin(name):
        return name
    path = Path(name).absolute()
    if path.suffix.lower() not in SUFFIXES:
        remedy = f"Use human, human:RIG, mannequin or a {', '.join(SUFFIXES)} file."
        raise UsageError(f"There is no character {name!r}.", remedy)
    if not path.is_file():
        raise RigUnusable(f"The character file {name} does not exist.", "Check its path.")
    return str(path)
