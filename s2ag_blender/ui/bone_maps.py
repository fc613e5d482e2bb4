"""Bone maps and face maps that the user chooses: edited in the panel, loaded from and saved to files of ``s2ag rig``."""
# pyright: reportInvalidTypeForm=false

import json
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import bpy
from bpy_extras.io_utils import ExportHelper, ImportHelper

from ...core.errors import RigUnusable, S2agError
from ...core.motion.skeleton import EDGE_NAMES
from ...rigs import maps
from ...rigs.detect import ROWS
from ...rigs.faces import shapes
from ...rigs.skeleton import Mapping, part_phrase
from ..characters import face_lookup
from ..datablocks import ArmatureObject, Context
from ..rig import chosen_bones, facemaps, readiness, reading
from ..takes.operator_base import character
from ..translations import translate, translate_error
from .bases import OperatorMixin, OperatorResult, require_character

ORDER = (*ROWS, "crown")
"""Parts that a map may name, in the order of the panel."""
ALWAYS_SHOWN = ("hips", *EDGE_NAMES, "left_hand", "right_hand")
"""Parts that always have a row; twist bones and the crown have one only where the map names some."""


def edit(armature: ArmatureObject) -> None:
    """Start a bone map from all detected bones, so that nothing changes yet; keep a map that is there."""
    if not armature.s2ag.bone_map:
        _fill(armature.s2ag, reading.detect_mapping(armature, reading.read(armature))[0])
        readiness.clear_cache(armature)


def reset(armature: ArmatureObject) -> None:
    """Go back to the detected bones."""
    armature.s2ag.bone_map.clear()
    armature.s2ag.bone_map_notes = ""
    readiness.clear_cache(armature)


def load(armature: ArmatureObject, path: str | Path) -> Mapping:
    """Load a bone map from a file and return it. Incomplete maps are allowed: the panel shows what is missing.

    Raises :class:`RigUnusable`, before changing anything, if the file is no bone map or names bones the armature lacks.
    """
    mapping = maps.load(path)
    _require_bones(armature, mapping.chains | ({"hips": (mapping.hips,)} if mapping.hips else {}))
    armature.s2ag.bone_map.clear()
    _fill(armature.s2ag, mapping)
    readiness.clear_cache(armature)
    return mapping


def _fill(settings: Any, mapping: Mapping) -> None:
    """Store a mapping as the bone map of the settings."""
    chains = mapping.chains | ({"hips": (mapping.hips,)} if mapping.hips else {})
    for part in ORDER:
        if part in chains or part in ALWAYS_SHOWN:
            item = settings.bone_map.add()
            item.name, item.bones = part, chosen_bones.join(chains.get(part, ()))
    switches = [{"bone": one.bone, "path": one.path, "value": one.value} for one in mapping.switches]
    settings.bone_map_notes = json.dumps({"family": mapping.family, "switches": switches})


def save(armature: ArmatureObject, path: str | Path) -> Mapping:
    """Write the chosen bones, else the detected ones, as a bone map file; return the map.

    Raises :class:`OutputUnwritable`, and :class:`RigUnusable` if a bone is in two parts.
    """
    mapping = chosen_bones.mapping_of_settings(armature.s2ag)
    if mapping is None:
        mapping, _ = reading.survey(armature)
    elif not isinstance(mapping, Mapping):
        mapping = reading.mapping_by_hand(armature, reading.read(armature), mapping)
    maps.parse(json.loads(maps.dump(mapping)))  # do not write what cannot be loaded
    maps.save(path, mapping, armature.name)
    return mapping


def _require_bones(armature: ArmatureObject, chains: dict[str, tuple[str, ...]]) -> None:
    """Raise :class:`RigUnusable` if the armature lacks bones of ``chains``."""
    names = [bone.name for bone in armature.data.bones]
    present = set(names)
    missing = [(part, bone) for part, chain in chains.items() for bone in chain if bone not in present]
    if not missing:
        return
    part, bone = missing[0]
    if len(missing) == 1:
        near = get_close_matches(bone, names, 1)
        hint = f'Did you mean "{near[0]}"?' if near else "Correct the bone map."
        raise RigUnusable(f'The armature has no bone "{bone}" for {part_phrase(part)}.', hint)
    total = sum(map(len, chains.values()))
    raise RigUnusable(
        f'The armature lacks {len(missing)} of the {total} bones of this map, "{bone}" among them.', "Load the map of this rig."
    )


class OfCharacter(OperatorMixin):
    """Base of operators that change the active character; it must exist, be no linked data, and not be in edit mode."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        armature = character(context)
        reason = ""
        if armature is None:
            reason = translate("Select a character's armature")
        elif armature.library is not None:
            reason = translate("The character is linked: make a library override of it first")
        elif armature.mode == "EDIT":
            reason = translate("Leave edit mode first")
        if reason:
            cls.poll_message_set(reason)
        return not reason


class S2AG_OT_edit_bone_map(OfCharacter, bpy.types.Operator):
    """Choose the bones by hand, starting from those that were found"""

    bl_idname = "s2ag.edit_bone_map"
    bl_label = "Choose Bones"

    def execute(self, context: Context) -> OperatorResult:
        edit(require_character(context))
        return {"FINISHED"}


class S2AG_OT_reset_bone_map(OfCharacter, bpy.types.Operator):
    """Go back to the bones that are found by themselves"""

    bl_idname = "s2ag.reset_bone_map"
    bl_label = "Find Bones"

    def execute(self, context: Context) -> OperatorResult:
        reset(require_character(context))
        return {"FINISHED"}


class _WithJsonFile(OperatorMixin):
    """Base of operators that load or save a ``.json`` file in ``work(armature, path)``, whose errors they report."""

    filename_ext = ".json"
    filter_glob: bpy.props.StringProperty(default="*.json", options={"HIDDEN"})

    def work(self, armature: ArmatureObject, path: str) -> None:
        """Load or save the file; may raise :class:`S2agError`."""
        raise NotImplementedError

    def execute(self, context: Context) -> OperatorResult:
        try:
            self.work(require_character(context), bpy.path.abspath(self.filepath))
        except S2agError as error:
            self.report({"ERROR"}, translate_error(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class S2AG_OT_load_bone_map(_WithJsonFile, OfCharacter, bpy.types.Operator, ImportHelper):
    """Take the bones of this character from a bone map, a file that Save writes"""

    bl_idname = "s2ag.load_bone_map"
    bl_label = "Load Bone Map"

    def work(self, armature: ArmatureObject, path: str) -> None:
        load(armature, path)
        self.report({"INFO"}, translate("{name} has the bones of {file}", name=armature.name, file=Path(path).name))


class S2AG_OT_save_bone_map(_WithJsonFile, OfCharacter, bpy.types.Operator, ExportHelper):
    """Write the bones of this character as a bone map, for characters of the same rig"""

    bl_idname = "s2ag.save_bone_map"
    bl_label = "Save Bone Map"
    bl_options = {"REGISTER"}

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        self.filepath = self.filepath or bpy.path.clean_name(require_character(context).name) + self.filename_ext
        return ExportHelper.invoke(self, context, event)

    def work(self, armature: ArmatureObject, path: str) -> None:
        save(armature, path)
        self.report({"INFO"}, translate("Written: {path}", path=path))


class S2AG_OT_load_face_map(_WithJsonFile, OfCharacter, bpy.types.Operator, ImportHelper):
    """Take the shape keys and bones of this character's face from a face map, a file that Save writes"""

    bl_idname = "s2ag.load_face_map"
    bl_label = "Load Face Map"

    def work(self, armature: ArmatureObject, path: str) -> None:
        facemaps.store_face_map(armature, shapes.load(path))
        self.report({"INFO"}, translate("{name} has the face of {file}", name=armature.name, file=Path(path).name))


class S2AG_OT_save_face_map(_WithJsonFile, OfCharacter, bpy.types.Operator, ExportHelper):
    """Write the shape keys and bones of this character's face as a face map, to edit or for characters alike"""

    bl_idname = "s2ag.save_face_map"
    bl_label = "Save Face Map"
    bl_options = {"REGISTER"}

    def invoke(self, context: Context, event: bpy.types.Event) -> OperatorResult:
        self.filepath = self.filepath or bpy.path.clean_name(require_character(context).name) + " face" + self.filename_ext
        return ExportHelper.invoke(self, context, event)

    def work(self, armature: ArmatureObject, path: str) -> None:
        face = face_lookup.face_map(armature)
        if face is None:
            raise RigUnusable(f"{armature.name} has no face that speaks.", "Give it shape keys or a jaw with a usual name.")
        shapes.save(path, face)
        self.report({"INFO"}, translate("Written: {path}", path=path))


class S2AG_OT_reset_face_map(OfCharacter, bpy.types.Operator):
    """Go back to the face that is found by itself"""

    bl_idname = "s2ag.reset_face_map"
    bl_label = "Find Face"

    def execute(self, context: Context) -> OperatorResult:
        facemaps.store_face_map(require_character(context), None)
        return {"FINISHED"}


CLASSES = (
    *(S2AG_OT_edit_bone_map, S2AG_OT_reset_bone_map, S2AG_OT_load_bone_map, S2AG_OT_save_bone_map),
    *(S2AG_OT_load_face_map, S2AG_OT_save_face_map, S2AG_OT_reset_face_map),
)
