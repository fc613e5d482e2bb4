"""What a character may be called: human, human:RIG, mannequin, or a file. Blender's side of it is :mod:`s2ag_blender.cast`."""

from pathlib import Path

from .errors import RigUnusable, UsageError

SUFFIXES = (".blend", ".fbx", ".glb", ".gltf")


def is_own(name: str) -> bool:
    """Whether a character is one of ours, no file."""
    return name in ("human", "mannequin") or (name.startswith("human:") and not Path(name).suffix)


def speaks(name: str) -> bool:
    """Whether a character is one of ours with a face that can speak."""
    return is_own(name) and name != "mannequin"


def checked(name: str) -> str:
    """The character as Blender's side wants it; raises for a file that is missing or of an unknown kind."""
    if is_own(name):
        return name
    path = Path(name).absolute()
    if path.suffix.lower() not in SUFFIXES:
        remedy = f"Use human, human:RIG, mannequin or a {', '.join(SUFFIXES)} file."
        raise UsageError(f"There is no character {name!r}.", remedy)
    if not path.is_file():
        raise RigUnusable(f"The character file {name} does not exist.", "Check its path.")
    return str(path)
