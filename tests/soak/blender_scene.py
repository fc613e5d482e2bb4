"""A Blender that generates, directs, deletes, undoes and saves at random, with a scene that is not ours compared all the while.

``python tests/soak/blender_scene.py MINUTES [SEED]``, where bpy is installed, prints counts. The exit status is 1 if
anything that is not ours was changed or lost, if anything stayed after characters and takes were deleted, or if an
operator ended in an error of Python.
"""

import contextlib
import io
import os
import random
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import bpy
import numpy as np
from s2ag.s2ag_blender import compat

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests" / "helpers")]

VOLATILE = {
    *("rna_type", "users", "session_uid", "tag", "is_evaluated", "original", "id_data", "preview", "is_updated"),
    *("name_full", "is_updated_data", "is_runtime_data", "bound_box", "select", "is_missing", "is_dirty"),
    *("library_weak_reference", "is_embedded_data", "use_extra_user", "override_library", "asset_data", "packed_files"),
    "audio_codec",
}
"""What Blender itself changes, what names something elsewhere, and the codec that a film with a sound strip is given."""
OF_SCENES = {
    *("frame_current", "frame_current_final", "frame_float", "frame_subframe", "sync_mode", "objects", "collection"),
    *("view_layers", "sequence_editor", "sequence_editor_create", "timeline_markers", "tool_settings", "cursor", "depsgraph"),
    *("frame_end", "frame_start", "frame_preview_start", "frame_preview_end", "use_preview_range", "is_nla_tweakmode"),
}
"""What Generate changes by intention (its strip, markers, range, and sound in step), or where new objects are linked."""
DEPTH = 9
SKIPPED = {"window_managers", "screens", "workspaces", "libraries", "brushes", "palettes", "fonts", "linestyles"}


def values(item, depth: int = DEPTH, skip=frozenset(), seen=None):
    """All that an RNA struct holds, as nested tuples; other datablocks by name, and what links lead to once."""
    found, seen = [], set() if seen is None else seen
    if (key := (item.as_pointer(), item.bl_rna.identifier)) in seen:
        return ()
    seen.add(key)
    for prop in item.bl_rna.properties:
        name = prop.identifier
        if name in VOLATILE or name in skip or name.startswith(("s2ag", "bl_")):
            continue
        value = getattr(item, name, None)
        if prop.type == "POINTER":
            if isinstance(value, bpy.types.ID) and not value.is_embedded_data:
                value = (type(value).__name__, value.name)
            elif value is not None and depth:
                value = values(value, depth - 1, seen=seen)
            else:
                value = None
        elif prop.type == "COLLECTION":
            value = tuple(
                (type(one).__name__, one.name) if isinstance(one, bpy.types.ID) else values(one, depth - 1, seen=seen)
                for one in (value if depth else ())
                if one is not None
            )
        elif getattr(prop, "is_array", False):
            value = tuple(np.ravel([tuple(row) if hasattr(row, "__len__") else row for row in value]).tolist())
        elif isinstance(value, set):
            value = tuple(sorted(value))
        found.append((name, value))
    return tuple(found)


def scene_as_it_is(known: dict | None = None) -> dict:
    """Every datablock by kind and name, with all that it holds if it is ``known``; strips and markers of scenes one by one."""
    found = {}
    for kind in dir(bpy.data):
        blocks = getattr(bpy.data, kind)
        if kind in SKIPPED or not isinstance(blocks, bpy.types.bpy_prop_collection):
            continue
        for block in blocks:
            skip = OF_SCENES if kind == "scenes" else frozenset()
            found[kind, block.name] = values(block, skip=skip) if known is None or (kind, block.name) in known else ()
    for scene in bpy.data.scenes:
        for marker in scene.timeline_markers:
            found["marker", marker.name] = (marker.frame, marker.name)
        editor = scene.sequence_editor
        for strip in compat.sequencer_strips(editor) if editor else ():
            found["strip", strip.name] = (strip.type, strip.channel, strip.frame_start, strip.frame_final_duration, strip.mute)
    return found


def somebodys_scene(folder: Path) -> None:
    """Objects, actions, layers, sounds, strips, markers and texts that have nothing to do with us."""
    bpy.ops.wm.read_factory_settings()
    scene = bpy.context.scene
    cube, camera = bpy.data.objects["Cube"], bpy.data.objects["Camera"]
    for number, thing in enumerate((cube, camera)):
        for frame in (1, 10, 40):
            thing.location.x += number + 0.5
            thing.keyframe_insert("location", frame=frame)
    track = cube.animation_data.nla_tracks.new()
    track.strips.new("pushed", 1, cube.animation_data.action)
    camera.data.keyframe_insert("lens", frame=5)
    cube.shape_key_add(name="Basis")
    cube.shape_key_add(name="Own").value = 0.25
    bpy.ops.object.armature_add(location=(3, 0, 0))
    other = bpy.context.object
    other.pose.bones[0].keyframe_insert("rotation_quaternion", frame=3)
    other["mine"] = 4.5
    cube.constraints.new("COPY_LOCATION").target = other
    bpy.data.texts.new("notes").write("keep this")
    scene.timeline_markers.new("own marker", frame=7)
    bpy.data.images.new("picture", 4, 4).pack()
    editor = scene.sequence_editor_create()
    compat.sequencer_strips(editor).new_sound("music", str(folder / "music.wav"), 5, 12)
    for block in (*bpy.data.actions, *bpy.data.texts, *bpy.data.images):
        block.use_fake_user = True
    scene.render.fps, scene.frame_end = 24, 400
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"))
    bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath)  # without what nobody uses


def write_voices(folder: Path) -> list[str]:
    """Pieces of speech, silence, and a bark."""
    from s2ag.core.sound import audio
    from sounds import write_wav

    speech = audio.load(ROOT / "examples" / "hello.flac")
    made = {"music": speech[::-1][:32000], "one": speech[:48000], "two": speech[30000:70000], "bark": speech[8000:11200]}
    made["silence"] = np.zeros(24000)
    for name, samples in made.items():
        write_wav(folder / f"{name}.wav", samples)
    return [str(folder / f"{name}.wav") for name in made if name != "music"]


class Soak:
    """A Blender at work, and what is known of its scene."""

    def __init__(self, folder: Path, seed: int):
        self.chance, self.folder = random.Random(seed), folder
        self.done, self.refused, self.wrong, self.seed, self.pressed = Counter(), Counter(), [], seed, []
        self.voices = write_voices(folder)
        somebodys_scene(folder)
        bpy.context.scene.frame_set(1)
        self.before = scene_as_it_is()

    def compare(self, after: str, only_ours_gone: bool = False) -> None:
        """Note what of somebody's scene is not as it was; with ``only_ours_gone`` also what there is beside it."""
        bpy.context.scene.frame_set(1)  # somebody's objects move
        now = scene_as_it_is(self.before)
        for key, value in self.before.items():
            if now.get(key) != value:
                self.note(f"after {after}: {key} {'is lost' if key not in now else difference(value, now[key])}")
        if only_ours_gone:
            for key in now.keys() - self.before.keys():
                self.note(f"after {after}: {key} was left, {holders(*key)}")

    def note(self, wrong: str) -> None:
        self.wrong.append(wrong)
        print("WRONG", f"seed {self.seed}", wrong, self.pressed, flush=True)

    def press(self, name: str, **options) -> None:
        """Call one of our operators where it can be called."""
        operator = getattr(bpy.ops.s2ag, name)
        self.pressed.append(name)
        if not operator.poll():
            self.refused[name] += 1
            return
        try:
            with contextlib.redirect_stderr(io.StringIO()):
                operator(**options)
            self.done[name] += 1
        except RuntimeError as error:
            self.refused[name] += 1
            if "Traceback" in str(error) or "Python:" in str(error):
                self.note(f"{name} {options}: {str(error)[-1500:]}")

    def ours(self) -> list:
        return [one for one in bpy.data.objects if one.type == "ARMATURE" and one.name != "Armature"]

    def step(self) -> None:
        """Do one thing that a user may do."""
        chance, ours = self.chance, self.ours()
        if not ours or (len(ours) < 2 and chance.random() < 0.05):
            self.press("add_mannequin")
            return
        armature = chance.choice(ours)
        bpy.context.view_layer.objects.active = armature
        armature.select_set(True)
        bpy.context.scene.frame_set(chance.randrange(1, 60))
        kind = chance.random()
        if kind < 0.3:
            armature.s2ag.audio = chance.choice(self.voices)
            armature.s2ag.start_frame = chance.choice((1, 1, 11, -5, 200))
            for name in chance.sample(("intensity", "seed", "variation", "hands", "rate"), 2):
                if name in armature.s2ag.bl_rna.properties:
                    prop = armature.s2ag.bl_rna.properties[name]
                    low, high = (prop.soft_min, prop.soft_max) if prop.type == "FLOAT" else (0, 99)
                    setattr(armature.s2ag, name, chance.uniform(low, high) if prop.type == "FLOAT" else chance.randrange(99))
            self.press("generate")
        elif kind < 0.8:
            self.press(*self.direct(armature))
        else:
            self.file(chance.choice(("undo", "redo", "save", "reload", "delete")), armature)

    def direct(self, armature) -> tuple[str]:
        """The name of an operator on takes or gestures, of a take that is chosen at random."""
        if len(armature.s2ag.takes):
            armature.s2ag.active_take = self.chance.randrange(len(armature.s2ag.takes))
        return (self.chance.choice((
            "keep_take", "delete_take", "delete_others", "recall_take", "fit_range", "reroll", "delete_gesture", "add_gesture",
            "rest_range", "keep_pose", "flip_version", "drop_versions", "follow_sound", "key_heard", "show_markers",
            "remove_markers", "apply_markers", "style_from", "cancel",
        )),)  # fmt: skip

    def file(self, what: str, armature) -> None:
        """Undo, redo, save, load again, or delete a character."""
        self.done[what] += 1
        self.pressed.append(what)
        if what in ("undo", "redo"):
            with contextlib.suppress(RuntimeError):  # there may be nothing to undo
                getattr(bpy.ops.ed, what)()
        elif what == "save":
            bpy.ops.wm.save_mainfile()
        elif what == "reload":
            bpy.ops.wm.save_mainfile()
            bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath)
        else:
            self.delete(armature)
        if what != "undo" and what != "redo":
            bpy.ops.ed.undo_push(message=what)

    def delete(self, armature) -> None:
        """Delete a character as a user does, its takes first."""
        bpy.context.view_layer.objects.active = armature
        own = [one for one in armature.users_collection if one.name.startswith("Mannequin")]
        for _ in range(len(armature.s2ag.takes)):
            self.press("delete_take")
        for one in [*armature.children_recursive, armature]:
            bpy.data.objects.remove(one)
        for collection in own:
            bpy.data.collections.remove(collection)

    def end(self) -> None:
        """Delete all that is ours, save and load, and look at what is left."""
        for armature in self.ours():
            self.delete(armature)
        editor = bpy.context.scene.sequence_editor
        strips = compat.sequencer_strips(editor)
        for strip in [one for one in strips if one.name != "music"]:  # sounds stay with the scene: they may be in use by now
            strips.remove(strip)
        bpy.ops.outliner.orphans_purge(do_recursive=True)
        bpy.ops.wm.save_mainfile()
        bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath)
        self.compare("the end", only_ours_gone=True)


def holders(kind: str, name: str) -> str:
    """What keeps a datablock in the file."""
    block = getattr(bpy.data, kind)[name] if hasattr(bpy.data, kind) else None
    if block is None:
        return "by nothing"
    named = [f"{type(one).__name__} {one.name}" for one in bpy.data.user_map(subset=[block])[block]]
    return f"used by {named}{', with a fake user' if block.use_fake_user else ''}, {block.users} in all"


def difference(one, other, path: str = "") -> str:
    """The first place where two nested tuples differ."""
    if isinstance(one, tuple) and isinstance(other, tuple) and len(one) == len(other):
        for number, (left, right) in enumerate(zip(one, other, strict=True)):
            if left != right:
                named = isinstance(left, tuple) and len(left) == 2 and isinstance(left[0], str)
                return difference(left, right, f"{path}/{left[0] if named else number}")
    return f"{path}: {str(one)[:200]} is {str(other)[:200]}"


def main() -> None:
    """Soak for as many minutes, in rounds that each begin with somebody's scene and end with it."""
    import s2ag

    minutes, seed = float(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0
    end, rounds, steps, wrong, done = time.monotonic() + 60 * minutes, 0, 0, [], Counter()
    s2ag.register()
    with tempfile.TemporaryDirectory() as name:
        os.environ["S2AG_CACHE"] = str(Path(name) / "cache")
        while time.monotonic() < end:
            soak = Soak(Path(name), seed + rounds)
            for number in range(40):
                soak.step()
                steps += 1
                if number % 8 == 7:
                    soak.compare(f"step {number} of round {rounds}")
                if time.monotonic() > end:
                    break
            soak.end()
            rounds, done, wrong = rounds + 1, done + soak.done, wrong + soak.wrong
            print(f"{rounds} rounds, {steps} steps, {len(wrong)} wrong, {dict(done)}, refused {dict(soak.refused)}", flush=True)
    sys.stdout.flush()
    os._exit(bool(wrong))


if __name__ == "__main__":
    main()
