"""Which shape keys a face has and what each of them shows. A file in ``families`` describes one way of naming them.

``keys`` maps names, those that mean the same divided by ``|``, to how much of which channels they show
(:data:`core.motion.face.CHANNELS`; of those that go both ways, ``LOOK_LEFT+`` or ``LOOK_LEFT-`` is one way). ``strip`` is an
expression of what names may begin with, ``rest`` are channels that the face shows by its rest or by other keys.
"""

import functools
import json
import re
import unicodedata
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from importlib import resources
from os import PathLike
from pathlib import Path

import numpy as np

from ...core import json_text
from ...core.errors import RigUnusable
from ...core.files import whole_file
from ...core.motion.face import CHANNELS, MOUTH

LARGEST = 1_000_000
"""Bytes of a map."""
_REMEDY = "Correct it, or let it be written anew: s2ag rig CHARACTER --save-face FILE."
_LEAST = 4
"""Channels of the mouth that make a family recognised."""
PARTS = {
    "closed lips": ("PP",), "lip and teeth (f, v)": ("FF",), "vowels": ("AA", "EH", "IH", "OH", "OU"), "jaw": ("JAW",),
    "tongue": ("TH", "DD", "NN"), "blinks": ("BLINK_LEFT", "BLINK_RIGHT"), "gaze": ("LOOK_LEFT", "LOOK_UP"),
    "brows": ("BROW_INNER", "BROW_OUTER", "BROW_LOWER"), "smile": ("SMILE",), "frown": ("FROWN",),
}  # fmt: skip
"""What people call parts of a face, and the channels that show them."""


@dataclass(frozen=True)
class Family:
    """A way of naming shape keys, as in its file."""

    name: str
    keys: dict[str, dict[str, float]]
    strip: str = ""
    rest: tuple[str, ...] = ()


@dataclass(frozen=True)
class Shapes:
    """A face's own shape keys and what they show: ``keys`` ``{name: {channel: weight}}``.

    ``bones`` of a map are those of a face by part (:data:`.bones.PARTS`).
    """

    family: str
    keys: dict[str, dict[str, float]]
    rest: tuple[str, ...] = ()
    bones: dict[str, str] = field(default_factory=dict)

    @property
    def shown(self) -> set[str]:
        """Channels that something shows."""
        return {name.rstrip("+-") for weights in self.keys.values() for name, weight in weights.items() if weight}

    def missing(self, others: Collection[str] = ()) -> list[str]:
        """Parts of the face that nothing shows, by their names for people; ``others`` are channels that bones show."""
        there = self.shown | set(self.rest) | set(others)
        return [part for part, names in PARTS.items() if not there & set(names)]

    def values(self, weights: np.ndarray) -> dict[str, np.ndarray]:
        """Values ``(frames,)`` of 0..1 for every key, of ``weights`` ``(frames, channels)``."""
        return {
            key: np.clip(sum((amount * _of(weights, name) for name, amount in parts.items()), np.zeros(len(weights))), 0, 1)
            for key, parts in self.keys.items()
        }


@functools.lru_cache(maxsize=1)
def families() -> tuple[Family, ...]:
    """All known families, by file name."""
    folder = resources.files(__package__) / "families"
    files = sorted((path for path in folder.iterdir() if path.name.endswith(".json")), key=lambda path: path.name)
    return tuple(_family(json.loads(path.read_text("utf-8"))) for path in files)


def detect(names: Collection[str]) -> Shapes | None:
    """The family that shows most of a face with keys of these ``names``, and which shows what; None where no mouth speaks."""
    found = [shapes for family in families() if (shapes := _matched(family, names)) is not None]
    return max(found, key=_worth, default=None)


def save(path: str | PathLike, shapes: Shapes) -> None:
    """Write a map that :func:`load` reads again and people may edit, whole or not at all. Raises :class:`OutputUnwritable`."""
    with whole_file(path) as temporary:
        temporary.write_text(dump(shapes), "utf-8")


def dump(shapes: Shapes) -> str:
    """A map as JSON text: a key and a bone a line."""
    keys = ",\n".join(f"    {_text(name)}: {_text(parts)}" for name, parts in shapes.keys.items())
    bones = ",\n".join(f"    {_text(part)}: {_text(name)}" for part, name in shapes.bones.items())
    head = f'  "face_map": 1,\n  "family": {_text(shapes.family)},\n  "rest": {_text(list(shapes.rest))}'
    return f'{{\n{head},\n  "keys": {{\n{keys}\n  }},\n  "bones": {{\n{bones}\n  }}\n}}\n'


def load(path: str | PathLike) -> Shapes:
    """Read a map; raises :class:`RigUnusable` with the first thing that is wrong with it."""
    try:
        data = json_text.read(Path(path), LARGEST, once=True)
    except OSError as error:
        raise RigUnusable(f"The face map {path} cannot be read: {error.strerror}.", "Check its path.") from error
    except json_text.NotJson as error:
        raise RigUnusable(f"The face map {path} is no JSON: {error}.", _REMEDY) from error
    return _checked(data, f"The face map {path}")


def parse(text: str) -> Shapes:
    """The map that JSON text describes; raises :class:`RigUnusable`."""
    try:
        data = json_text.parse(text, LARGEST)
    except json_text.NotJson as error:
        raise RigUnusable(f"The face map is no JSON: {error}.", _REMEDY) from error
    return _checked(data, "The face map")


def _checked(data: object, where: str) -> Shapes:
    from .bones import PARTS as BONES

    keys, bones, rest = ({}, {}, []) if not isinstance(data, dict) else map(data.get, ("keys", "bones", "rest"), (None, {}, []))
    if not isinstance(data, dict) or data.get("face_map") != 1 or not isinstance(keys, dict) or not isinstance(bones, dict):
        raise RigUnusable(f"{where} is not what face maps are.", _REMEDY)
    for key, parts in keys.items():
        if not isinstance(parts, dict) or not all(_is_weight(*part) for part in parts.items()):
            raise RigUnusable(f"{where} shows by {key!r} what no face does.", _REMEDY)
    for part, name in bones.items():
        if part not in BONES or not isinstance(name, str):
            raise RigUnusable(f"{where} has a bone for {part!r}, which no face has.", f"Use: {', '.join(BONES)}.")
    if not isinstance(rest, list) or not all(one in CHANNELS for one in rest):
        raise RigUnusable(f"{where} shows by rest what no face does.", _REMEDY)
    return Shapes(str(data.get("family", "")), keys, tuple(rest), bones)


def _text(value) -> str:
    return json.dumps(value, ensure_ascii=False)


def _is_weight(name: str, weight) -> bool:
    known = name in CHANNELS or (name[-1:] in "+-" and name[:-1] in ("LOOK_LEFT", "LOOK_UP"))
    return known and isinstance(weight, (int, float)) and not isinstance(weight, bool) and abs(weight) <= 10


def _of(weights: np.ndarray, name: str) -> np.ndarray:
    column = weights[:, CHANNELS.index(name.rstrip("+-"))]
    if name[-1] in "+-":
        return np.maximum(column if name[-1] == "+" else -column, 0)
    return column


def _family(content: Mapping) -> Family:
    return Family(content["name"], dict(content["keys"]), content.get("strip", ""), tuple(content.get("rest", ())))


def _matched(family: Family, names: Collection[str]) -> Shapes | None:
    there: dict[str, str] = {}
    for name in names:
        there.setdefault(_plain(re.sub(family.strip, "", name) if family.strip else name), name)
    keys: dict[str, dict[str, float]] = {}
    for alike, parts in family.keys.items():
        name = next((there[plain] for plain in map(_plain, alike.split("|")) if plain in there), None)
        if name is not None and name not in keys:
            keys[name] = dict(parts)
    sides = ("BLINK_LEFT", "BLINK_RIGHT")
    alone = any(len(parts) == 1 and side in parts for parts in keys.values() for side in sides)
    keys = {name: parts for name, parts in keys.items() if not (alone and set(sides) <= parts.keys())}
    shapes = Shapes(family.name, keys, family.rest)
    return shapes if len(shapes.shown & set(MOUTH)) >= _LEAST else None


def _worth(shapes: Shapes) -> tuple[int, int, int]:
    """Better: more of a mouth, more of a face, more keys."""
    return len(shapes.shown & set(MOUTH)), len(shapes.shown), len(shapes.keys)


def _plain(name: str) -> str:
    return "".join(char for char in unicodedata.normalize("NFKC", name).lower() if char.isalnum())
