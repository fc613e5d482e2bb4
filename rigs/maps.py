"""Bone maps: JSON files that users read, edit and share.

A map lists the bones of each part, lowest first; ``[]`` leaves a part at rest::

    {
      "map": 1,
      "armature": "Hero",
      "family": "mixamo",
      "hips": ["Hips"],
      "torso": ["Spine", "Spine1", "Spine2"],
      "left_upper_arm": ["LeftArm"],
      "switches": [{"bone": "Hand_IK.L", "path": "[\"ik_fk\"]", "value": 1.0}]
    }

``armature``, ``family`` and ``comment`` are notes; ``switches`` are set while the rig is animated."""

import json
from collections.abc import Iterable
from difflib import get_close_matches
from os import PathLike
from pathlib import Path

from ..core import json_text
from ..core.errors import RigUnusable
from ..core.files import atomic_file
from .detect import ROWS
from .family import Switch
from .skeleton import Finding, Mapping, part_phrase

VERSION = 1
LARGEST = 1_000_000
"""Maximum size of a map file in bytes."""
NOTES = ("armature", "family", "comment")
REMEDY = "s2ag rig CHARACTER --save map.json writes a map to start from."


def load(path: str | PathLike) -> Mapping:
    """Read a map. Raises :class:`RigUnusable` for the first error in the file."""
    path = Path(path)
    try:
        data = json_text.read(path, LARGEST, once=True)
    except FileNotFoundError:
        raise RigUnusable(f"The bone map {path} does not exist.", f"Check its path; {REMEDY}") from None
    except OSError as error:
        raise RigUnusable(f"The bone map {path} cannot be read: {error.strerror}.", "Save it as a text file.") from error
    except json_text.NotJson as error:
        raise RigUnusable(f"The bone map {path} is no JSON: {error}.", "Correct that line, or save it in UTF-8.") from error
    return parse(data, f"The bone map {path}")


def save(path: str | PathLike, mapping: Mapping, armature: str = "") -> None:
    """Write a map for :func:`load`, atomically; parts without bones are ``[]``.

    Raises :class:`OutputUnwritable`."""
    with atomic_file(path) as temporary:
        temporary.write_text(dump(mapping, armature), "utf-8")


def dump(mapping: Mapping, armature: str = "") -> str:
    """Return a map as JSON text, one part per line."""
    chains = {"hips": (mapping.hips,) if mapping.hips else ()} | mapping.chains
    parts = [row for row in (*ROWS, "crown") if row in chains or row in _ALWAYS]
    switches = [{"bone": switch.bone, "path": switch.path, "value": switch.value} for switch in mapping.switches]
    entries: dict[str, object] = {"map": VERSION, "armature": armature, "family": mapping.family}
    entries |= {row: list(chains.get(row, ())) for row in parts}
    lines = [f"  {json.dumps(key)}: {json.dumps(value, ensure_ascii=False)}" for key, value in entries.items()]
    if switches:
        rows = ",\n".join(f"    {json.dumps(switch, ensure_ascii=False)}" for switch in switches)
        lines.append(f'  "switches": [\n{rows}\n  ]')
    return "{\n" + ",\n".join(lines) + "\n}\n"


def parse(data: object, where: str = "The bone map") -> Mapping:
    """Convert a map's parsed JSON to a mapping. Raises :class:`RigUnusable` for the first error."""
    if not isinstance(data, dict):
        raise RigUnusable(f"{where} is no JSON object of parts and bones.", REMEDY)
    if data.get("map", VERSION) != VERSION:
        raise RigUnusable(f"{where} is of version {data['map']!r}.", f"This program reads version {VERSION}.")
    allowed = ("map", *NOTES, *ROWS, "crown", "switches")
    for key in data:
        if key not in allowed:
            near = get_close_matches(key, allowed, 1)
            hint = f'Did you mean "{near[0]}"?' if near else f"Use: {', '.join((*ROWS, 'crown'))}."
            raise RigUnusable(f'{where} has a part "{key}", which no body has.', hint)
    chains = {row: _chain(data[row], row, where) for row in (*ROWS, "crown") if row in data}
    chains = {row: chain for row, chain in chains.items() if chain}
    owners: dict[str, str] = {}
    for row, name in ((row, name) for row, chain in chains.items() for name in chain):
        if name in owners:
            raise RigUnusable(
                f'{where} uses "{name}" for {part_phrase(owners[name])} and {part_phrase(row)}.', "Keep it in one part."
            )
        owners[name] = row
    hips = chains.pop("hips", ())
    if len(hips) > 1:
        raise RigUnusable(f"{where} names {len(hips)} bones for the hips.", "Name one.")
    findings = [Finding(row, chains.get(row, hips if row == "hips" else ()), "map") for row in ROWS]
    findings = [item if item.bones else Finding(item.part, note="left out by the map") for item in findings]
    findings = tuple(item for item in findings if item.bones or item.part in _ALWAYS)
    switches = _switches(data.get("switches", []), where)
    family = data.get("family") or "own mapping"
    if not isinstance(family, str):
        raise RigUnusable(f"{where} has a family that is no text.", "Remove the line.")
    return Mapping(chains, family, "".join(hips), switches=switches, findings=findings)


_ALWAYS = frozenset(row for row in ROWS if not row.endswith("_twist"))
"""Parts that are listed even without bones."""


def _chain(value: object, row: str, where: str) -> tuple[str, ...]:
    """Return the bones of a part, which may be one name or a list; () for null, "" and []."""
    chain = [value] if isinstance(value, str) else value
    if chain is None:
        return ()
    if not isinstance(chain, list) or not all(isinstance(name, str) for name in chain):
        raise RigUnusable(
            f"{where} has no bone names for {part_phrase(row)}.", 'Write a list, as in ["Spine", "Spine1"], or [].'
        )
    return tuple(name for name in chain if name)


def _switches(value: object, where: str) -> tuple[Switch, ...]:
    try:
        if not isinstance(value, Iterable):
            raise TypeError
        return tuple(Switch(str(entry["bone"]), str(entry["path"]), float(entry["value"])) for entry in value)
    except (TypeError, KeyError, ValueError):
        remedy = 'Write them as [{"bone": "Hand_IK", "path": "[\\"ik_fk\\"]", "value": 1.0}].'
        raise RigUnusable(f"{where} has switches without bone, path and value.", remedy) from None
