"""Which bones gesture, chosen by hand: edited in the panel, and kept as the files that ``s2ag rig`` and ``--map`` use."""

import json
from difflib import get_close_matches
from pathlib import Path

import bpy
from bpy_extras.io_utils import ExportHelper, ImportHelper

from ...core.errors import RigUnusable, S2agError
from ...core.motion.skeleton import EDGE_NAMES
from ...rigs import maps
from ...rigs.detect import ROWS
from ...rigs.faces import shapes
from ...rigs.plain import Mapping, spoken
from ..cast import facial
from ..rig import facemaps, readiness, reading
from ..rig.handpicked import chosen, join
from ..takes.running import character
from ..translations import told, told_error

ORDER = (*ROWS, "crown")
"""Parts that a map may name, in the order of the panel."""


SHOWN = ("hips", *EDGE_NAMES, "left_hand", "right_hand")
"""Parts that always have a row; twist bones and the crown have one where there are any."""


def edit(armature: bpy.types.Object) -> None:
    """Make the bones that were found a choice by hand, where there is none yet: all of them, so that nothing changes."""
    if not armature.s2ag.bone_map:
        _fill(armature.s2ag, reading.found(armature, reading.read(armature))[0])
        readiness.forget(armature)


def reset(armature: bpy.types.Object) -> None:
    """Go back to the bones that are found by themselves."""
    armature.s2ag.bone_map.clear()
    armature.s2ag.bone_map_notes = ""
    readiness.forget(armature)


def load(armature: bpy.types.Object, path: str | Path) -> Mapping:
    """Take over a map from a file; returns it. An unfinished one is taken, too: the panel shows what it lacks.

    Raises :class:`RigUnusable` for a file that is no map and for bones that the armature lacks, before anything is changed.
    """
    mapping = maps.load(path)
    _require(armature, mapping.chains | ({"hips": (mapping.hips,)} if mapping.hips else {}))
    armature.s2ag.bone_map.clear()
    _fill(armature.s2ag, mapping)
    readiness.forget(armature)
    return mapping


def _fill(settings, mapping: Mapping) -> None:
    """Make a mapping the choice by hand."""
    chains = mapping.chains | ({"hips": (mapping.hips,)} if mapping.hips else {})
    for part in ORDER:
        if part in chains or part in SHOWN:
            item = settings.bone_map.add()
            item.name, item.bones = part, join(chains.get(part, ()))
    switches = [{"bone": one.bone, "path": one.path, "value": one.value} for one in mapping.switches]
    settings.bone_map_notes = json.dumps({"family": mapping.family, "switches": switches})


def save(armature: bpy.types.Object, path: str | Path) -> Mapping:
    """Write the bones that were chosen, else those that were found, as a map; returns it.

    Raises :class:`OutputUnwritable`, and :class:`RigUnusable` where one bone is to be two parts.
    """
    mapping = chosen(armature.s2ag)
    if mapping is None:
        mapping, _ = reading.survey(armature)
    elif not isinstance(mapping, Mapping):
        mapping = reading.by_hand(armature, reading.read(armature), mapping)
    maps.parse(json.loads(maps.dump(mapping)))  # what could not be read again is not written
    maps.save(path, mapping, armature.name)
    return mapping


def _require(armature, chains: dict[str, tuple[str, ...]]) -> None:
    names = [bone.name for bone in armature.data.bones]
    known = set(names)
    lacking = [(part, bone) for part, chain in chains.items() for bone in chain if bone not in known]
    if not lacking:
        return
    part, bone = lacking[0]
    if len(lacking) == 1:
        near = get_close_matches(bone, names, 1)
        hint = f'Did you mean "{near[0]}"?' if near else "Correct the bone map."
        raise RigUnusable(f'The armature has no bone "{bone}" for {spoken(part)}.', hint)
    total = sum(map(len, chains.values()))
    raise RigUnusable(
        f'The armature lacks {len(lacking)} of the {total} bones of this map, "{bone}" among them.', "Load the map of this rig."
    )


class OfCharacter:
    """Base of operators that change the active character: it is there, not linked, and not in edit mode."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        armature = character(context)
        reason = ""
        if armature is None:
            reason = told("Select a character's armature")
        elif armature.library is not None:
            reason = told("The character is linked: make a library override of it first")
        elif armature.mode == "EDIT":
            reason = told("Leave edit mode first")
        if reason:
            cls.poll_message_set(reason)
        return not reason


class S2AG_OT_edit_bone_map(OfCharacter, bpy.types.Operator):
    """Choose the bones by hand, starting from those that were found"""

    bl_idname = "s2ag.edit_bone_map"
    bl_label = "Choose Bones"

    def execute(self, context):
        edit(character(context))
        return {"FINISHED"}


class S2AG_OT_reset_bone_map(OfCharacter, bpy.types.Operator):
    """Go back to the bones that are found by themselves"""

    bl_idname = "s2ag.reset_bone_map"
    bl_label = "Find Bones"

    def execute(self, context):
        reset(character(context))
        return {"FINISHED"}


class _WithFile:
    """What both file operators have: the kind of file, and one sentence about whatever goes wrong."""

    filename_ext = ".json"
    filter_glob: bpy.props.StringProperty(default="*.json", options={"HIDDEN"})

    def execute(self, context):
        try:
            self.work(character(context), bpy.path.abspath(self.filepath))
        except S2agError as error:
            self.report({"ERROR"}, told_error(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class S2AG_OT_load_bone_map(_WithFile, OfCharacter, bpy.types.Operator, ImportHelper):
    """Take the bones of this character from a bone map, a file that Save writes"""

    bl_idname = "s2ag.load_bone_map"
    bl_label = "Load Bone Map"

    def work(self, armature, path):
        load(armature, path)
        self.report({"INFO"}, told("{name} has the bones of {file}", name=armature.name, file=Path(path).name))


class S2AG_OT_save_bone_map(_WithFile, OfCharacter, bpy.types.Operator, ExportHelper):
    """Write the bones of this character as a bone map, for characters of the same rig"""

    bl_idname = "s2ag.save_bone_map"
    bl_label = "Save Bone Map"
    bl_options = {"REGISTER"}

    def invoke(self, context, event):
        self.filepath = self.filepath or bpy.path.clean_name(character(context).name) + self.filename_ext
        return ExportHelper.invoke(self, context, event)

    def work(self, armature, path):
        save(armature, path)
        self.report({"INFO"}, told("Written: {path}", path=path))


class S2AG_OT_load_face_map(_WithFile, OfCharacter, bpy.types.Operator, ImportHelper):
    """Take the shape keys and bones of this character's face from a face map, a file that Save writes"""

    bl_idname = "s2ag.load_face_map"
    bl_label = "Load Face Map"

    def work(self, armature, path):
        facemaps.choose(armature, shapes.load(path))
        self.report({"INFO"}, told("{name} has the face of {file}", name=armature.name, file=Path(path).name))


class S2AG_OT_save_face_map(_WithFile, OfCharacter, bpy.types.Operator, ExportHelper):
    """Write the shape keys and bones of this character's face as a face map, to edit or for characters alike"""

    bl_idname = "s2ag.save_face_map"
    bl_label = "Save Face Map"
    bl_options = {"REGISTER"}

    def invoke(self, context, event):
        self.filepath = self.filepath or bpy.path.clean_name(character(context).name) + " face" + self.filename_ext
        return ExportHelper.invoke(self, context, event)

    def work(self, armature, path):
        found = facial.whole(armature)
        if found is None:
            raise RigUnusable(f"{armature.name} has no face that speaks.", "Give it shape keys or a jaw with a usual name.")
        shapes.save(path, found)
        self.report({"INFO"}, told("Written: {path}", path=path))


class S2AG_OT_reset_face_map(OfCharacter, bpy.types.Operator):
    """Go back to the face that is found by itself"""

    bl_idname = "s2ag.reset_face_map"
    bl_label = "Find Face"

    def execute(self, context):
        facemaps.choose(character(context), None)
        return {"FINISHED"}


CLASSES = (
    *(S2AG_OT_edit_bone_map, S2AG_OT_reset_bone_map, S2AG_OT_load_bone_map, S2AG_OT_save_bone_map),
    *(S2AG_OT_load_face_map, S2AG_OT_save_face_map, S2AG_OT_reset_face_map),
)
