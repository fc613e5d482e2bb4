"""Writes hand-made animation of a character, with its speech, as training data, and puts styles into the user's folder."""

import re
import shutil
import subprocess
import time
from collections.abc import Generator
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...core import child_process, own_styles
from ...core.errors import OutputUnwritable, UsageError
from ...core.files import scratch_folder
from ...core.motion import skeleton
from ...core.motion.motion import Motion
from ...core.motion.readers import ten_joints
from ...core.settings import names_with
from ...rigs.skeleton import Mapping, character_frame
from ..datablocks import ArmatureObject, current_context
from ..engine import client
from ..keys.apply import scene_fps
from ..rig import chosen_bones, reading
from . import sources

_NECK_JOINTS = {"Neck": "neck", "Head": "head"}
"""Joint of :mod:`ten_joints` -> the part whose first bone starts there; :data:`_ARM_JOINTS` likewise without the side."""
_ARM_JOINTS = {"Arm": "upper_arm", "ForeArm": "forearm"}


def capture(
    armature: ArmatureObject, first: int | None = None, last: int | None = None, mapping: Mapping | dict | None = None
) -> Motion:
    """Sample the evaluated pose of the armature from frame ``first`` to ``last`` (default: the scene's) at 15 fps.

    Includes constraints, drivers and other animation. Raises :class:`RigUnusable` if bones are unknown, and
    :class:`UsageError` for an empty range. Restores the scene's current frame."""
    reading.require_armature(armature)
    context = current_context()
    scene = context.scene
    first, last = scene.frame_start if first is None else first, scene.frame_end if last is None else last
    if last - first < 1:
        raise UsageError(f"Frames {first} to {last} hold no motion.", "Choose a longer range.")
    bones = reading.read(armature)
    resolved = reading.resolve_mapping(armature, bones, mapping)
    joints = _bones_of_joints(resolved)
    frame = character_frame(bones, resolved)
    upright = np.stack([frame[0], frame[2], -frame[1]])  # left, up, front
    rate, before = scene_fps(scene), scene.frame_current_final
    count = max(int((last - first) / rate * skeleton.FPS) + 1, 2)
    positions, rotations = np.empty((count, len(joints), 3)), np.empty((count, len(joints), 3, 3))
    try:
        for number in range(count):
            at = min(first + number * rate / skeleton.FPS, float(last))
            scene.frame_set(int(at), subframe=at - int(at))
            evaluated = armature.evaluated_get(context.evaluated_depsgraph_get())
            assert evaluated.pose is not None
            for row, (name, at_tail) in enumerate(joints.values()):
                bone = evaluated.pose.bones[name]
                positions[number, row] = bone.tail if at_tail else bone.head
                matrix = np.array(bone.matrix)[:3, :3] @ bones.matrices[bones.row(name)][:3, :3].T
                rotations[number, row] = matrix / np.linalg.norm(matrix, axis=0)
    finally:
        scene.frame_set(int(before), subframe=before - int(before))
    posed = ten_joints.Posed(tuple(joints), positions @ upright.T, upright @ rotations @ upright.T)
    return Motion(ten_joints.directions(posed, where=f'Armature "{armature.name}"'), meta={"source": armature.name})


def save_take(
    armature: ArmatureObject, folder: str | Path, sound: str, transcript: str = "", name: str = "", text: str = "",
    **frames: Any
) -> Path:  # fmt: skip
    """Write the animation, its sound and its words to ``folder`` under one name, as ``s2ag data plain`` reads them.

    The sound starts at the first frame. Words are the file ``transcript`` or the ``text`` itself; ``frames`` are further
    arguments of :func:`capture`. Returns the path of the motion. Raises :class:`S2agError`."""
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


def style_in_slices(path: str | Path, weights: str, python: str | None) -> Generator[float, None, str]:
    """Put the style of a file into the user's folder, or learn it from a motion in the engine's Python; return its name.

    ``weights`` is the hash of those that shall perform it. Yields wherever Blender may draw. Raises :class:`S2agError`."""
    path = Path(path)
    if path.suffix.lower() == own_styles.SUFFIX:
        style = own_styles.read(path)
        if style["weights"] == weights:
            own_styles.write(style, own_styles.path_of(style["name"]))
            return style["name"]
    arguments = [str(path)] if path.suffix.lower() == own_styles.SUFFIX else [str(path), "--name", path.stem.replace("_", " ")]
    yield from command_in_slices(["learn", *arguments], python)
    return own_styles.read(path)["name"] if path.suffix.lower() == own_styles.SUFFIX else arguments[-1]


def command_in_slices(arguments: list[str], python: str | None) -> Generator[float, None, list[str]]:
    """Run a command of the engine's Python that tells shares; yield the share that is done, return its notes.

    Raises :class:`UsageError` with what it says where it fails; it ends when this is closed."""
    command = [*client.engine_command("core.cli.main", python), *arguments, "--shares"]
    with scratch_folder() as folder, (folder / "told").open("w+b") as told:
        ends = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": told}
        process = subprocess.Popen(command, env=child_process.environment(), **ends, **child_process.own_group_options())
        try:
            while process.poll() is None:
                shares = re.findall(r"(\d+)%\n", (folder / "told").read_text("utf-8", "replace"))
                yield int(shares[-1]) / 100 if shares else 0.0
                time.sleep(0.02)
        finally:
            child_process.kill_tree(process)
        text = (folder / "told").read_text("utf-8", "replace").replace("s2ag: ", "")
    lines = [line for line in text.splitlines() if line and not line.endswith("%")]
    if process.returncode:
        raise UsageError(" ".join(lines[-1:]) or "The engine stopped.", "")
    return [line.removeprefix("note: ") for line in lines]


def _bones_of_joints(mapping: Mapping) -> dict[str, tuple[str, bool]]:
    """Return for every joint of :mod:`ten_joints` its bone, and whether it is at the bone's tail."""
    chains = mapping.chains
    torso = chains.get("torso", ())
    hips = mapping.hips or (torso[0] if torso else "")
    joints = {"Hips": (hips, False)} if hips else {}
    if len(torso) > 1:
        joints["Spine"] = (torso[len(torso) // 2], False)
    joints |= {joint: (chains[part][0], False) for joint, part in _NECK_JOINTS.items() if chains.get(part)}
    for side in ("left", "right"):
        title = side.title()
        joints |= {f"{title}{joint}": (chains[f"{side}_{part}"][0], False) for joint, part in _ARM_JOINTS.items()}
        hand = chains.get(f"{side}_hand")
        joints[f"{title}Hand"] = (hand[0], False) if hand else (chains[f"{side}_forearm"][-1], True)
    return joints


def speech_of(armature: ArmatureObject, scene: bpy.types.Scene) -> dict[str, Any]:
    """Return the character's speech by the settings of its panel, as arguments of :func:`save_take`.

    Raises :class:`UsageError` where nothing is chosen, and :class:`AudioUnreadable` for an unreadable recording."""
    settings = armature.s2ag
    voice = sources.find_voice(settings, scene)
    words = sources.words_parameters(settings, "" if settings.audio_source == "MIXDOWN" else voice.path)
    span = {"first": round(voice.span.start), "last": scene.frame_end if voice.span.last is None else voice.span.last}
    texts = {name: words.get(name, "") for name in names_with(alternatives="words")}
    return {"mapping": chosen_bones.mapping_of_settings(settings), "sound": voice.path, **texts, **span}


def is_animated(armature: ArmatureObject) -> bool:
    """Return whether the character has an action or NLA strips."""
    data = armature.animation_data
    return data is not None and (data.action is not None or any(track.strips for track in data.nla_tracks))
