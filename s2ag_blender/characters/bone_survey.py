"""Reports which bones of a character would be animated: ``python -m s2ag.s2ag_blender.characters.bone_survey SURVEY.json``.

Runs in a process of its own. The file is a JSON object: ``character``, ``gender``, ``armature`` or null, ``map`` and
``face_map`` (paths) or null. One JSON line on stdout is the ``result`` (armature, family, number of ``bones``, ``table``,
``map``, ``warnings``, ``face`` with ``table`` and ``map``, and as ``refusal`` what makes it unusable, or null) or the
``error`` (kind, message, remedy). The exit status is 0, or 2 after an error.
"""

import json
import sys
from typing import Any

from ...core import json_text
from ...core.errors import UsageError
from .. import program

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

    from ...rigs import maps
    from ...rigs.faces import shapes
    from ...rigs.family import families
    from ..rig import facemaps, reading
    from . import face_lookup, loading

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
        "table": maps.table(detected),
        "map": json.loads(maps.dump(detected)),
        "face": face_lookup.describe_face(item),
        "warnings": [*detected.warnings, *summoned.disarmed],
        "refusal": refusal and {"message": refusal.message, "remedy": refusal.remedy},
    }


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
