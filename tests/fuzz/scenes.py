"""A scene that is changed while gestures are laid into it: between two slices of the work anything may happen to it.

``python tests/fuzz/scenes.py LOG COUNT [FIRST]``, where bpy is installed, tries the next numbers, as :mod:`situations` does.
Work must end in takes or in two sentences, leave nothing after an error, and be possible again afterwards.
"""

import collections
import contextlib
import io
import json
import os
import random
import sys
import tempfile
import traceback
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pairs
from s2ag.core.errors import S2agError
from s2ag.core.motion import skeleton
from s2ag.core.motion.motion import Motion
from s2ag.s2ag_blender.takes import generate

SETTINGS = (
    {}, {"result": "LAYER"}, {"add_markers": True}, {"take_count": 2}, {"curves": "FRAMES"}, {"start_pose": "CURRENT"},
    {"end_pose": "CURRENT"}, {"add_sound": False},
)  # fmt: skip


def performed(frames: int, seed: int) -> Motion:
    """A motion that waves, with two words."""
    directions = np.repeat(skeleton.MEAN_UNIT[None], frames, 0)
    directions[:, 5, 1] += np.sin(np.linspace(seed, 6 + seed, frames))
    words = (("hello", 0.0, 0.05), ("there", 0.05, 0.1))
    return Motion(skeleton.normalize(directions).astype(np.float32), words=words, meta={"style": "test"})


def mode(name: str) -> Callable:
    def change(armature) -> None:
        bpy.context.view_layer.objects.active = armature
        bpy.ops.object.mode_set(mode=name)

    return change


def edited(change: Callable) -> Callable:
    """``change(edit bones)`` in edit mode."""

    def do(armature) -> None:
        mode("EDIT")(armature)
        change(armature.data.edit_bones)
        mode("OBJECT")(armature)

    return do


def forearm(bones):
    return next(bone for bone in bones if "forearm" in bone.name.lower() or "lower_arm" in bone.name.lower())


def other_scene(armature) -> None:
    own = bpy.context.scene
    bpy.data.scenes.new("other")
    bpy.data.scenes.remove(own)


def other_data(armature) -> None:
    armature.data = bpy.data.armatures.new("empty")


def nan(armature) -> None:
    armature.pose.bones[0].location.x = float("nan")


def keyed(armature) -> None:
    for bone in armature.pose.bones[:5]:
        bone.keyframe_insert("rotation_quaternion", frame=3)


def tweaked(armature) -> None:
    action = bpy.data.actions.new("own")
    track = armature.animation_data_create().nla_tracks.new()
    track.strips.new("own", 1, action)
    track.is_solo = True


def no_sound(armature) -> None:
    for sound in list(bpy.data.sounds):
        bpy.data.sounds.remove(sound)


def undone(armature) -> None:
    bpy.ops.ed.undo_push(message="own")
    with contextlib.suppress(RuntimeError):
        bpy.ops.ed.undo()


CHANGES: dict[str, Callable] = {
    "nothing": lambda armature: None,
    "fps": lambda armature: setattr(bpy.context.scene.render, "fps", 60),
    "fps_base": lambda armature: setattr(bpy.context.scene.render, "fps_base", 1e-5),
    "bone deleted": edited(lambda bones: bones.remove(forearm(bones))),
    "bone renamed": edited(lambda bones: setattr(forearm(bones), "name", "other")),
    "bones deleted": edited(lambda bones: [bones.remove(bone) for bone in list(bones)]),
    "bone added": edited(lambda bones: setattr(bones.new("own"), "tail", (0, 0, 1))),
    "bone without parent": edited(lambda bones: setattr(forearm(bones), "parent", None)),
    "bone turned": edited(lambda bones: setattr(forearm(bones), "roll", 1.5)),
    "bones of no length": edited(lambda bones: [setattr(bone, "tail", bone.head) for bone in bones]),
    "character deleted": lambda armature: bpy.data.objects.remove(armature),
    "character renamed": lambda armature: setattr(armature, "name", "ä" * 40),
    "character unlinked": lambda armature: [one.objects.unlink(armature) for one in armature.users_collection],
    "character hidden": lambda armature: armature.hide_set(True),
    "character of no size": lambda armature: setattr(armature, "scale", (0, 0, 0)),
    "other data": other_data,
    "no number": nan,
    "other scene": other_scene,
    "edit mode": mode("EDIT"),
    "pose mode": mode("POSE"),
    "rest position": lambda armature: setattr(armature.data, "pose_position", "REST"),
    "mode of rotation": lambda armature: setattr(forearm(armature.pose.bones), "rotation_mode", "XYZ"),
    "locked": lambda armature: setattr(forearm(armature.pose.bones), "lock_rotation", (True, True, True)),
    "constraint": lambda armature: forearm(armature.pose.bones).constraints.new("COPY_ROTATION"),
    "keyed": keyed,
    "no animation": lambda armature: armature.animation_data_clear(),
    "solo": tweaked,
    "actions deleted": lambda armature: [bpy.data.actions.remove(one) for one in list(bpy.data.actions)],
    "actions renamed": lambda armature: [setattr(one, "name", "x") for one in bpy.data.actions],
    "takes cleared": lambda armature: armature.s2ag.takes.clear(),
    "no sound": no_sound,
    "no sequencer": lambda armature: bpy.context.scene.sequence_editor_clear(),
    "no meshes": lambda armature: [bpy.data.objects.remove(one) for one in list(bpy.data.objects) if one.type == "MESH"],
    "undo": undone,
    "purge": lambda armature: bpy.ops.outliner.orphans_purge(do_recursive=True),
    "file": lambda armature: bpy.ops.wm.read_factory_settings(use_empty=True),
    "saved": lambda armature: bpy.ops.wm.save_as_mainfile(filepath=os.path.join(tempfile.gettempdir(), "a.blend")),
    "frame": lambda armature: bpy.context.scene.frame_set(1000),
    "markers": lambda armature: bpy.context.scene.timeline_markers.clear(),
    "result": lambda armature: setattr(armature.s2ag, "result", "LAYER"),
}
GONE = {"character deleted", "file", "bones deleted", "other data"}
"""Changes after which nothing can be made of the character any more."""
UNDONE: dict[str, Callable] = {
    "fps_base": lambda armature: setattr(bpy.context.scene.render, "fps_base", 1.0),
    "character unlinked": lambda armature: bpy.context.scene.collection.objects.link(armature),
    "character of no size": lambda armature: setattr(armature, "scale", (1, 1, 1)),
    "no number": lambda armature: setattr(armature.pose.bones[0].location, "x", 0.0),
    "edit mode": mode("OBJECT"),
}


def situation(number: int) -> dict:
    """What is tried under ``number``: settings, whether there is a take already, and what happens after some slices."""
    chance = random.Random(f"scene {number}")
    found = {"settings": chance.randrange(len(SETTINGS)), "before": chance.random() < 0.4, "frames": chance.choice((2, 3, 46))}
    found |= {"changes": chance.sample(list(CHANGES), chance.choice((1, 1, 1, 2))), "moment": chance.random()}
    return found | {"ends": chance.choice(("goes on",) * 5 + ("cancelled",))}


def take(armature, found: dict, between: Callable[[int], object]):
    """Plan a run and lay it, with ``between(number)`` before each of its slices; return its outcome."""
    with contextlib.suppress(RuntimeError):  # it may be in no view layer by now
        bpy.context.view_layer.objects.active = armature
    planned = generate.plan(bpy.context, armature)
    count = SETTINGS[found["settings"]].get("take_count", 1)
    slices = generate.finish_in_slices(planned, {"motions": [performed(found["frames"], one) for one in range(count)]})
    number = 0
    while True:
        if between(number) == "cancelled":
            slices.close()
            return None
        number += 1
        try:
            next(slices)
        except StopIteration as done:
            return done.value


def begin(folder: Path, found: dict):
    """A new file with a character that has what it needs."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with contextlib.redirect_stdout(io.StringIO()):
        bpy.ops.s2ag.add_mannequin()
    armature = bpy.context.active_object
    armature.s2ag.audio = str(folder / "voice.wav")
    for name, value in SETTINGS[found["settings"]].items():
        setattr(armature.s2ag, name, value)
    if found["before"]:
        take(armature, found, lambda number: None)
    return armature


def attempt(folder: Path, number: int, lengths: dict) -> str:
    """What is wrong with how a situation ended."""
    found = situation(number)
    key = found["settings"], found["before"], found["frames"]
    armature = begin(folder, found)
    if key not in lengths:  # how many slices there are
        counted = []
        take(armature, found, counted.append)
        lengths[key] = len(counted)
        armature = begin(folder, found)
    moment, uid = int(found["moment"] * (lengths[key] + 1)) - 1, armature.session_uid

    def between(slice_number: int):
        if slice_number != max(moment, 0):
            return None
        for name in found["changes"]:
            current = next((one for one in bpy.data.objects if one.session_uid == uid), None)
            if current is not None:
                with contextlib.suppress(RuntimeError, TypeError, ReferenceError):  # what a mode or an earlier change forbids
                    CHANGES[name](current)
        return found["ends"]

    takes = len(armature.s2ag.takes)
    known = {one.session_uid for one in bpy.data.actions}
    try:
        if moment < 0:
            between(0)
        outcome = take(armature, found, between if moment >= 0 else lambda number: None)
    except S2agError as error:
        outcome = None
        if not (error.message and error.remedy):
            return f"its sentences are {error.message!r} and {error.remedy!r}"
    except ReferenceError:
        if moment < 0 and set(found["changes"]) & GONE:
            return ""  # the harness plans with a character that is gone
        raise
    armature = next((one for one in bpy.data.objects if one.session_uid == uid), None)
    made = {one.session_uid for one in bpy.data.actions} - known
    wrong = []
    own = {one.session_uid for one in bpy.data.actions if one.name == "own" or one.name.startswith("ownA")}
    if outcome is None:
        ours = [one.name for one in bpy.data.actions if one.session_uid in made - own and "s2ag" in one]
        wrong += [f"{ours} were left"] if ours else []
        wrong += ["a take was left"] if armature and len(armature.s2ag.takes) > takes else []
    elif armature is not None:
        wrong += ["a take has no action"] if any(one.action is None for one in list(armature.s2ag.takes)[:1]) else []
    return "\n".join(wrong) or again(armature, found)


def again(armature, found: dict) -> str:
    """What is wrong with a run after all has been put in order."""
    if armature is None or set(found["changes"]) & GONE:
        return ""
    try:
        for name in found["changes"]:
            with contextlib.suppress(RuntimeError):
                UNDONE.get(name, lambda armature: None)(armature)
        mode("OBJECT")(armature)
    except (RuntimeError, ReferenceError):
        return ""
    try:
        take(armature, found, lambda number: None)
    except S2agError as error:
        return "" if error.message and error.remedy else f"afterwards its sentences are {error.message!r} and {error.remedy!r}"
    return ""


def main() -> None:
    """Go on where the log ends."""
    import s2ag
    import situations

    log, count = Path(sys.argv[1]), int(sys.argv[2])
    number, fell, tried = situations.known(log)
    if sys.argv[3:]:
        number, log = int(sys.argv[3]), Path(os.devnull)
        print(situation(number))
    s2ag.register()
    lengths: dict[tuple, int] = {}
    with log.open("a", encoding="utf-8") as told, tempfile.TemporaryDirectory() as folder:
        tempfile.tempdir = folder
        pairs.write_wav(Path(folder) / "voice.wav", pairs.SOUNDS["speech"](3200))
        for one in range(number, number + count):
            if one % 50 == 0:
                told.write(f"trying {one}\n")
                told.flush()
            try:
                wrong = attempt(Path(folder), one, lengths)
            except Exception as error:  # whatever escapes is what is looked for
                wrong = "".join(traceback.format_exception(error, limit=-8))
            tried["scene"] += 1
            fell += bool(wrong)
            if wrong:
                told.write(f"FELL {one} {situation(one)}\n{wrong}\n")
                print(f"FELL {one} {situation(one)}\n{wrong}\n", flush=True)
            if one % 50 == 49 or one == number + count - 1:
                told.write(json.dumps({"next": one + 1, "fell": fell, "tried": tried}) + "\n")
    print(json.dumps({"next": number + count, "fell": fell, "tried": collections.Counter(tried)}))
    sys.stdout.flush()
    os._exit(bool(fell))


if __name__ == "__main__":
    main()
