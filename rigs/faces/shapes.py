"""Maps face channels to shape keys. Each file in ``families`` describes one naming scheme.

``keys`` maps key names (synonyms separated by ``|``) to weights of channels (:data:`core.motion.face.CHANNELS`; a sign
selects one direction of a signed channel: ``LOOK_LEFT+`` or ``LOOK_LEFT-``). ``strip`` is a regular expression for prefixes of
names, ``rest`` are channels that need no key because the rest shape or other keys express them."""

import functools
import json
import re
import unicodedata
from collections.abc import Collection
from dataclasses import dataclass, field
from importlib import resources
from os import PathLike
from pathlib import Path

import numpy as np

from ...core import json_text
from ...core.errors import RigUnusable
from ...core.files import atomic_file
from ...core.motion.face import CHANNELS, MOUTH
from .bones import PARTS as BONE_PARTS

LARGEST = 1_000_000
"""Maximum size of a map file in bytes."""
_REMEDY = "Correct it, or let it be written anew: s2ag rig CHARACTER --save-face FILE."
_MIN_MOUTH_CHANNELS = 4
"""Least number of mouth channels by which a family is recognised."""
PARTS = {
    "closed lips": ("PP",), "lip and teeth (f, v)": ("FF",), "vowels": ("AA", "EH", "IH", "OH", "OU"), "jaw": ("JAW",),
    "tongue": ("TH", "DD", "NN"), "blinks": ("BLINK_LEFT", "BLINK_RIGHT"), "gaze": ("LOOK_LEFT", "LOOK_UP"),
    "brows": ("BROW_INNER", "BROW_OUTER", "BROW_LOWER"), "smile": ("SMILE",), "frown": ("FROWN",),
}  # fmt: skip
"""Names of parts of a face for the user, and the channels that express them."""


@dataclass(frozen=True)
class Family:
    """A naming scheme of shape keys; fields as in its file."""

    name: str
    keys: dict[str, dict[str, float]]
    strip: str = ""
    rest: tuple[str, ...] = ()


@dataclass(frozen=True)
class Shapes:
    """The shape keys of a face: ``keys`` ``{name: {channel: weight}}``.

    ``bones`` are face bones by part (:data:`.bones.PARTS`); only maps have them."""

    family: str
    keys: dict[str, dict[str, float]]
    rest: tuple[str, ...] = ()
    bones: dict[str, str] = field(default_factory=dict)

    @property
    def shown(self) -> set[str]:
        """Channels that some key expresses."""
        return {name.rstrip("+-") for weights in self.keys.values() for name, weight in weights.items() if weight}

    def missing(self, others: Collection[str] = ()) -> list[str]:
        """Return the parts of the face that nothing expresses, as user-visible names; bones express the channels ``others``."""
        there = self.shown | set(self.rest) | set(others)
        return [part for part, names in PARTS.items() if not there & set(names)]

    def values(self, weights: np.ndarray) -> dict[str, np.ndarray]:
        """Return the values ``(frames,)``, 0..1, of every key for ``weights`` ``(frames, channels)``."""
        return {
            key: np.clip(sum((amount * _of(weights, name) for name, amount in parts.items()), np.zeros(len(weights))), 0, 1)
            for key, parts in self.keys.items()
        }


@functools.lru_cache(maxsize=1)
def families() -> tuple[Family, ...]:
    """Return all known families, sorted by file name."""
    folder = resources.files(str(__package__)) / "families"
    files = sorted((path for path in folder.iterdir() if path.name.endswith(".json")), key=lambda path: path.name)
    read = (json.loads(path.read_text("utf-8")) for path in files)
    return tuple(Family(one["name"], dict(one["keys"]), one.get("strip", ""), tuple(one.get("rest", ()))) for one in read)


@functools.lru_cache(maxsize=8)  # the panel asks at every redraw
def detect(names: tuple[str, ...]) -> Shapes | None:
    """Return the shape keys of the family that expresses most with keys of these ``names``; None if no mouth can speak."""
    candidates = [shapes for family in families() if (shapes := _match(family, names)) is not None]
    return max(candidates, key=lambda one: (len(one.shown & set(MOUTH)), len(one.shown), len(one.keys)), default=None)


def save(path: str | PathLike, shapes: Shapes) -> None:
    """Write a map for :func:`load` that users may edit, atomically. Raises :class:`OutputUnwritable`."""
    with atomic_file(path) as temporary:
        temporary.write_text(dump(shapes), "utf-8")


def dump(shapes: Shapes) -> str:
    """Return a map as JSON text, one key or bone per line."""
    keys = ",\n".join(f"    {_text(name)}: {_text(parts)}" for name, parts in shapes.keys.items())
    bones = ",\n".join(f"    {_text(part)}: {_text(name)}" for part, name in shapes.bones.items())
    head = f'  "face_map": 1,\n  "family": {_text(shapes.family)},\n  "rest": {_text(list(shapes.rest))}'
    return f'{{\n{head},\n  "keys": {{\n{keys}\n  }},\n  "bones": {{\n{bones}\n  }}\n}}\n'


def load(path: str | PathLike) -> Shapes:
    """Read a map. Raises :class:`RigUnusable` for the first error in it."""
    try:
        data = json_text.read(Path(path), LARGEST, once=True)
    except OSError as error:
        raise RigUnusable(f"The face map {path} cannot be read: {error.strerror}.", "Check its path.") from error
    except json_text.NotJson as error:
        raise RigUnusable(f"The face map {path} is no JSON: {error}.", _REMEDY) from error
    return _validate(data, f"The face map {path}")


def parse(text: str) -> Shapes:
    """Parse a map from JSON text. Raises :class:`RigUnusable`."""
    try:
        data = json_text.parse(text, LARGEST)
    except json_text.NotJson as error:
        raise RigUnusable(f"The face map is no JSON: {error}.", _REMEDY) from error
    return _validate(data, "The face map")


def _validate(data: object, where: str) -> Shapes:
    """Convert a map's parsed JSON. Raises :class:`RigUnusable` for the first error."""
    if not isinstance(data, dict):
        raise RigUnusable(f"{where} is not what face maps are.", _REMEDY)
    keys, bones, rest = data.get("keys"), data.get("bones", {}), data.get("rest", [])
    if data.get("face_map") != 1 or not isinstance(keys, dict) or not isinstance(bones, dict):
        raise RigUnusable(f"{where} is not what face maps are.", _REMEDY)
    for key, parts in keys.items():
        if not isinstance(parts, dict) or not all(_is_weight(*part) for part in parts.items()):
            raise RigUnusable(f"{where} shows by {key!r} what no face does.", _REMEDY)
    for part, name in bones.items():
        if part not in BONE_PARTS or not isinstance(name, str):
            raise RigUnusable(f"{where} has a bone for {part!r}, which no face has.", f"Use: {', '.join(BONE_PARTS)}.")
    if not isinstance(rest, list) or not all(channel in CHANNELS for channel in rest):
        raise RigUnusable(f"{where} shows by rest what no face does.", _REMEDY)
    return Shapes(str(data.get("family", "")), keys, tuple(rest), bones)


def _text(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)


def _is_weight(name: str, weight: object) -> bool:
    """Return whether a map's entry is a known channel and a number within -10..10."""
    is_channel = name in CHANNELS or (name[-1:] in "+-" and name[:-1] in ("LOOK_LEFT", "LOOK_UP"))
    return is_channel and isinstance(weight, (int, float)) and not isinstance(weight, bool) and abs(weight) <= 10


def _of(weights: np.ndarray, name: str) -> np.ndarray:
    """Return a channel (frames,) of ``weights`` (frames, channels); with a sign, only that direction, as values >= 0."""
    column = weights[:, CHANNELS.index(name.rstrip("+-"))]
    if name[-1] in "+-":
        return np.maximum(column if name[-1] == "+" else -column, 0)
    return column


def _match(family: Family, names: Collection[str]) -> Shapes | None:
    """Return the keys among ``names`` that the family knows, None if too few of them move the mouth."""
    by_plain_name: dict[str, str] = {}
    for name in names:
        by_plain_name.setdefault(_plain(re.sub(family.strip, "", name) if family.strip else name), name)
    keys: dict[str, dict[str, float]] = {}
    for synonyms, parts in family.keys.items():
        name = next((by_plain_name[plain] for plain in map(_plain, synonyms.split("|")) if plain in by_plain_name), None)
        if name is not None and name not in keys:
            keys[name] = dict(parts)
    sides = ("BLINK_LEFT", "BLINK_RIGHT")
    one_sided = any(len(parts) == 1 and side in parts for parts in keys.values() for side in sides)
    keys = {name: parts for name, parts in keys.items() if not (one_sided and set(sides) <= parts.keys())}
    shapes = Shapes(family.name, keys, family.rest)
    return shapes if len(shapes.shown & set(MOUTH)) >= _MIN_MOUTH_CHANNELS else None


def _plain(name: str) -> str:
    """Return a name in lower case, reduced to letters and digits."""
    return "".join(char for char in unicodedata.normalize("NFKC", name).lower() if char.isalnum())
