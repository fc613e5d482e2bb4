"""A performance that somebody animated, with its speech, into a folder from which a network can learn: "learn from this"."""

import re
import shutil
from pathlib import Path

import bpy
import numpy as np

from ...core.errors import OutputUnwritable, S2agError, UsageError
from ...core.motion import skeleton
from ...core.motion.motion import Motion
from ...core.motion.readers import ten_joints
from ...rigs.plain import Bones, Mapping, character_frame
from ..keys.apply import scene_fps
from ..rig import handpicked, reading
from ..takes import drafts, sources
from ..takes.running import character
from ..translations import told, told_error

_STARTS = {"Neck": "neck", "Head": "head"}
_ARMS = {"Arm": "upper_arm", "ForeArm": "forearm"}


def capture(
    armature: bpy.types.Object, first: int | None = None, last: int | None = None, mapping: Mapping | dict | None = None
) -> Motion:
    """What the armature does from frame ``first`` to ``last`` (the scene's), whatever moves it, as a motion at 15 a second.

    Raises :class:`RigUnusable` where bones are unknown and :class:`UsageError` for an empty range. The scene ends up at the
    frame at which it was.
    """
    reading.require_armature(armature)
    scene = bpy.context.scene
    first, last = scene.frame_start if first is None else first, scene.frame_end if last is None else last
    if last - first < 1:
        raise UsageError(f"Frames {first} to {last} hold no motion.", "Choose a longer range.")
    bones = reading.read(armature)
    mapping = reading.resolve_mapping(armature, bones, mapping)
    joints = _joints(mapping, bones)
    frame = character_frame(bones, mapping)
    upright = np.stack([frame[0], frame[2], -frame[1]])  # left, up, front
    rate, before = scene_fps(scene), scene.frame_current_final
    count = max(int((last - first) / rate * skeleton.FPS) + 1, 2)
    places, turns = np.empty((count, len(joints), 3)), np.empty((count, len(joints), 3, 3))
    try:
        for number in range(count):
            at = min(first + number * rate / skeleton.FPS, float(last))
            scene.frame_set(int(at), subframe=at - int(at))
            evaluated = armature.evaluated_get(bpy.context.evaluated_depsgraph_get())
            for row, (name, end) in enumerate(joints.values()):
                bone = evaluated.pose.bones[name]
                places[number, row] = bone.tail if end else bone.head
                matrix = np.array(bone.matrix)[:3, :3] @ bones.matrices[bones.row(name)][:3, :3].T
                turns[number, row] = matrix / np.linalg.norm(matrix, axis=0)
    finally:
        scene.frame_set(int(before), subframe=before - int(before))
    posed = ten_joints.Posed(tuple(joints), places @ upright.T, upright @ turns @ upright.T)
    return Motion(ten_joints.directions(posed, where=f'Armature "{armature.name}"'), meta={"source": armature.name})


def save_take(armature, folder: str | Path, sound: str, transcript: str = "", name: str = "", text: str = "", **frames) -> Path:
    """Write the performance, its sound and its words to ``folder`` under one name, as ``s2ag data plain`` reads them.

    The sound starts with the first frame. Words are the file ``transcript`` or the ``text`` itself. Returns the motion's file.
    Raises :class:`S2agError`.
    """
    folder, source = Path(folder), Path(sound)
    if not source.is_file():
        raise UsageError(f"The recording {source} does not exist.", "Choose the speech that belongs to the action.")
    motion = capture(armature, **frames)
    action = armature.animation_data.action if armature.animation_data else None
    stem = re.sub(r"[^\w-]+", "_", name or (action.name if action else armature.name))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, folder / f"{stem}{source.suffix.lower()}")
        if transcript and Path(transcript).is_file():
            shutil.copyfile(transcript, folder / f"{stem}{Path(transcript).suffix}")
        elif text:
            (folder / f"{stem}.txt").write_text(text, "utf-8")
    except OSError as error:
        raise OutputUnwritable(f"{folder} cannot be written: {error.strerror}.", "Choose another folder.") from error
    motion.save(folder / f"{stem}.npz")
    return folder / f"{stem}.npz"


def _joints(mapping: Mapping, bones: Bones) -> dict[str, tuple[str, bool]]:
    """For every joint its bone, and whether it is the bone's end."""
    chains = mapping.chains
    torso = chains.get("torso", ())
    hips = mapping.hips or (torso[0] if torso else "")
    found = {"Hips": (hips, False)} if hips else {}
    if len(torso) > 1:
        found["Spine"] = (torso[len(torso) // 2], False)
    found |= {joint: (chains[part][0], False) for joint, part in _STARTS.items() if chains.get(part)}
    for side in ("left", "right"):
        title = side.title()
        found |= {f"{title}{joint}": (chains[f"{side}_{part}"][0], False) for joint, part in _ARMS.items()}
        hand = chains.get(f"{side}_hand")
        found[f"{title}Hand"] = (hand[0], False) if hand else (chains[f"{side}_forearm"][-1], True)
    return found


def spoken(armature, scene: bpy.types.Scene) -> dict:
    """What the panel says of a character's speech, as arguments of :func:`save_take`.

    Raises :class:`UsageError` for what is not chosen and :class:`AudioUnreadable` for what cannot be heard.
    """
    settings = armature.s2ag
    voice = sources.voice(settings, scene)
    words = sources.words(settings, "" if settings.audio_source == "MIXDOWN" else voice.path)
    span = {"first": round(voice.span.start), "last": scene.frame_end if voice.span.last is None else voice.span.last}
    said = {name: words.get(name, "") for name in ("transcript", "text")}
    return {"mapping": handpicked.chosen(settings), "sound": voice.path, **said, **span}


def is_animated(armature) -> bool:
    """Whether anything is keyed on the character."""
    data = armature.animation_data
    return data is not None and (data.action is not None or any(track.strips for track in data.nla_tracks))


class S2AG_OT_learn(bpy.types.Operator):
    """Save what this character does, with its speech, into a folder from which a network can be trained"""

    bl_idname = "s2ag.learn"
    bl_label = "Learn from This Action"

    directory: bpy.props.StringProperty(subtype="DIR_PATH", description="Folder of takes")

    @classmethod
    def poll(cls, context):
        armature = character(context)
        reason = ""
        if armature is None:
            reason = told("Select a character's armature")
        elif armature.mode == "EDIT":
            reason = told("Leave edit mode first")
        elif not is_animated(armature):
            reason = told("The character has no animation to learn from")
        else:
            reason = sources.missing(armature.s2ag, context.scene)
        if reason:
            cls.poll_message_set(reason)
        return not reason

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        armature = character(context)
        drafts.drop(armature)  # it is nobody's performance
        try:
            path = save_take(armature, bpy.path.abspath(self.directory), **spoken(armature, context.scene))
        except S2agError as error:
            self.report({"ERROR"}, told_error(error))
            return {"CANCELLED"}
        self.report({"INFO"}, told("{name} is saved; train with: s2ag data plain", name=path.name))
        return {"FINISHED"}
