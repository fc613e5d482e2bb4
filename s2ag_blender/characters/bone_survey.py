"""Reports which bones of a character would be animated: ``python -m s2ag.s2ag_blender.characters.bone_survey SURVEY.json``.

Runs in a process of its own. The file is a JSON object: ``character``, ``gender``, ``armature`` or null, ``map`` and
``face_map`` (paths) or null. One JSON line on stdout is the ``result`` (armature, family, number of ``bones``, ``table``,
``map``, ``warnings``, ``face`` with ``table`` and ``map``, and as ``refusal`` what makes it unusable, or null) or the
``error`` (kind, message, remedy). The exit status is 0, or 2 after an error.
"""

import json
import sys
from collections.abc import Collection
from typing import TYPE_CHECKING, Any

from ...core import json_text
from ...core.errors import UsageError
from .. import program

if TYPE_CHECKING:
    from ..datablocks import ArmatureObject

KEYS = {"character", "gender", "armature", "map", "face_map"}


def main(arguments: list[str]) -> int:
    """Run the survey file named by ``arguments``; return the exit status."""
    return program.run(arguments, lambda path, voice: survey(**_read(path)), "survey")


def survey(
    character: str,
    gender: str = "female",
    armature: str | None = None,
    map: str | None = None,
    face_map: str | None = None,
) -> dict[str, Any]:
    """Load a character in this Blender, whose open file is lost; return the content of ``result``. Raises S2agError."""
    import bpy

    from ...rigs import map_table, maps
    from ...rigs.faces import shapes
    from ...rigs.family import families
    from ..rig import facemaps, reading
    from . import loading

    mapping, face = maps.load(map) if map else None, shapes.load(face_map) if face_map else None
    bpy.ops.wm.read_factory_settings(use_empty=True)
    summoned = loading.load_character(character, gender, armature, mapping)[0]
    item = summoned.armature
    detected, refusal = reading.survey(item, mapping)
    facemaps.store_face_map(item, face)
    return {
        "armature": item.name,
        "family": {family.key: family.name for family in families()}.get(detected.family, detected.family),
        "bones": len(item.data.bones),
        "table": map_table.table(detected),
        "map": json.loads(maps.dump(detected)),
        "face": describe_face(item),
        "warnings": [*detected.warnings, *summoned.disarmed],
        "refusal": refusal and {"message": refusal.message, "remedy": refusal.remedy},
    }


def describe_face(armature: "ArmatureObject") -> dict[str, Any]:
    """Return ``table``, the face's parts and what shows them as lines of text, and ``map``, its map as JSON, or None."""
    from ...rigs.faces import bones as face_bones
    from ...rigs.faces import shapes
    from . import face_lookup

    found, face = face_lookup.find(armature), face_lookup.face_map(armature)
    if found is None or face is None:
        return {"table": "no shape keys or bones that speak were found", "map": None}
    by_key = {
        part: [key for key, ways in found.shapes.keys.items() if _shows(ways, names)] for part, names in shapes.PARTS.items()
    }
    by_bone = {
        part: [bone for key, bone in found.bones.items() if face_bones.shown_channels([key]) & set(names)]
        for part, names in shapes.PARTS.items()
    }
    missing = set(found.missing)
    lines = [f"{found.shapes.family}, {len(found.shapes.keys)} keys, {len(found.bones)} bones"]
    for part in shapes.PARTS:
        what = [*by_key[part], *by_bone[part]]
        by_rest = "by other parts or at rest"
        lines.append(
            f"  {part:<23}{'missing' if part in missing else ', '.join(what[:4]) + (' ...' if what[4:] else '') or by_rest}"
        )
    return {"table": "\n".join(lines), "map": shapes.dump(face)}


def _shows(weights: dict[str, Any], names: Collection[str]) -> bool:
    return bool({name.rstrip("+-") for name, weight in weights.items() if weight} & set(names))


def _read(path: str) -> dict[str, Any]:
    try:
        content = json_text.read(path)
        if not KEYS >= set(content) >= {"character"}:
            raise ValueError(f"its keys are {sorted(content)}")
    except (OSError, ValueError, TypeError) as error:
        raise UsageError(f"{path} is not a survey: {error}", "Let s2ag rig write it.") from error
    return content


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
