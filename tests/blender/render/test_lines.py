"""Lines for games, read back: an action a line by its name, at the rate asked for, that begins and ends in one pose."""

import json
from dataclasses import replace

import bpy
import numpy as np
import pytest
from s2ag.core.cli import lines as verb
from s2ag.core.errors import UsageError
from s2ag.core.motion import rest, skeleton, vrma
from s2ag.core.motion.motion import Motion
from s2ag.core.synthesis import hand_synthesis, idling
from s2ag.s2ag_blender import compat, program
from s2ag.s2ag_blender.characters.character import Character
from s2ag.s2ag_blender.render import lines, vrm_animation

pytestmark = pytest.mark.slow

FPS = 30


@pytest.fixture(scope="module")
def motions(tmp_path_factory):
    """Twenty short lines: waving arms from everywhere, settled, and one idle."""
    folder, paths = tmp_path_factory.mktemp("lines"), {}
    for number in range(19):
        moving = idling.idle(1.0 + 0.02 * number, seed=number, stillness=0.0)
        paths[f"line_{number:02d}"] = verb.settled(moving)
    paths["idle"] = replace(idling.idle(2.0, loop=True, fps=FPS), pelvis=None)
    for name, motion in paths.items():
        motion.save(folder / f"{name}.npz")
    return {name: str(folder / f"{name}.npz") for name in paths}


def write(motions, output, each=None, who="mannequin"):
    about = {"character": who, "gender": "female", "armature": None, "maps": [None, None], "fps": FPS}
    told = []
    about |= {"lines": motions, "settle": verb.SETTLE, "output": str(output), "each": each}
    result = lines.perform(about, program.EventWriter(told.append))
    assert result["root"] == {"mannequin": "hips", "human": "root"}[who]
    return result


def read_back(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = FPS
    read = {".fbx": bpy.ops.import_scene.fbx, ".usd": bpy.ops.wm.usd_import}.get(path.suffix, bpy.ops.import_scene.gltf)
    read(filepath=str(path))
    assert not [item for item in bpy.data.objects if item.type == "MESH" and item.parent is not None]
    (armature,) = [item for item in bpy.data.objects if item.type == "ARMATURE"]
    return armature


def placed(armature, action, frames):
    """The heads of all bones at frames of an action, which plays from then on."""
    slots = getattr(action, "slots", None)
    armature.animation_data_create()
    compat.assign_action(armature, action, slots[0] if slots else None)
    for track in armature.animation_data.nla_tracks:
        track.mute = True
    rows = []
    for frame in frames:
        bpy.context.scene.frame_set(int(frame))
        rows.append([bone.head[:] for bone in armature.pose.bones])
    return np.array(rows)


def poses(armature, action, frames):
    names = [bone.name.replace("_", ".") for bone in armature.pose.bones]  # a name in USD has no dots
    rows = placed(armature, action, frames)[:, [names.index(name) for name in ("hand.L", "hand.R", "head")]]
    root = np.array(armature.matrix_world @ armature.pose.bones["hips"].matrix)
    return rows.reshape(len(rows), -1), root


@pytest.mark.parametrize("suffix", [".fbx", ".glb"])
def test_twenty_lines_come_back_from_one_file(motions, tmp_path, suffix):
    write(motions, tmp_path / f"lines{suffix}")
    armature = read_back(tmp_path / f"lines{suffix}")
    ends, roots = [], []
    for name, path in motions.items():
        (action,) = [one for one in bpy.data.actions if name in one.name]
        first, last = action.frame_range
        motion = Motion.load(path)
        assert abs((last - first) - (len(motion.directions) - 1) * FPS / motion.fps) <= 1.01
        placed, root = poses(armature, action, [first, last])
        assert np.abs(placed[0] - placed[1]).max() < 2e-3 * armature.pose.bones["head"].head.length
        ends += [placed[0]] if name != "idle" else []
        roots.append(root)
    assert np.ptp(ends, axis=0).max() < 2e-3 * armature.pose.bones["head"].head.length
    assert np.ptp(roots, axis=0).max() < 1e-4 * max(np.abs(roots).max(), 1)


@pytest.mark.parametrize("who", ["mannequin", "human"])
def test_who_holds_the_hands_together_until_the_end_is_back_in_the_same_pose(tmp_path, who):
    """Arms are kept out of each other for longer than they would touch."""
    still = np.repeat(rest.REST[None], 45, 0)
    folded = still.copy()
    folded[:, [5, 8]] = skeleton.normalize(np.array([[-1.0, 0.3, 0.5], [1.0, 0.3, 0.5]]) * np.sign(still[:, [4, 4], :1]))
    paths = {}
    for name, directions in (("stands", still), ("folds", folded)):
        paths[name] = str(tmp_path / f"{name}.npz")
        verb.settled(Motion(directions.astype(np.float32), hands=hand_synthesis.hanging_hands(directions))).save(paths[name])
    write(paths, tmp_path / "lines.glb", who=who)
    armature = read_back(tmp_path / "lines.glb")
    seen = {}
    for name in paths:
        (action,) = [one for one in bpy.data.actions if name in one.name]
        first, last = map(int, action.frame_range)
        seen[name] = placed(armature, action, [first, (first + last) // 2, last])
    assert np.abs(seen["folds"][1] - seen["stands"][1]).max() > 0.1
    assert np.abs(np.subtract([seen["folds"][0], seen["folds"][2]], seen["stands"][0])).max() < 1e-4


@pytest.mark.parametrize("kind", verb.EACH)
def test_a_file_for_each_line(motions, tmp_path, kind):
    few = {name: motions[name] for name in ("line_03", "idle")}
    write(few, tmp_path, kind)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(f"{name}.{kind}" for name in few)
    for name in few if kind in ("fbx", "glb", "usd") else ():
        armature = read_back(tmp_path / f"{name}.{kind}")
        action = armature.animation_data.action or armature.animation_data.nla_tracks[0].strips[0].action
        motion, (first, last) = Motion.load(few[name]), action.frame_range
        if kind != "usd" or bpy.app.version >= (4, 5):  # 4.2 gives what it imports from USD a name of its own
            assert name in action.name
        assert abs(last - first - (len(motion.directions) - 1) * FPS / motion.fps) <= 1.01
        placed, root = poses(armature, action, [first, last])
        assert np.abs(placed[0] - placed[1]).max() < 2e-3 * armature.pose.bones["head"].head.length
        assert np.abs(root - poses(armature, action, [(first + last) // 2])[1]).max() < 1e-4 * max(np.abs(root).max(), 1)


@pytest.mark.parametrize("who", ["mannequin", "human"])
def test_a_vrm_animation_moves_as_the_character_does(motions, tmp_path, who):
    write({"line_03": motions["line_03"]}, tmp_path, "vrma", who)
    document, binary = vrma.read_glb((tmp_path / "line_03.vrma").read_bytes())
    about = document["extensions"]["VRMC_vrm_animation"]
    nodes = {human: one["node"] for human, one in about["humanoid"]["humanBones"].items()}
    assert about["specVersion"] == "1.0" and set(vrma.NEEDED) <= set(nodes) and document["animations"][0]["name"] == "line_03"
    targets = {(one["target"]["node"], one["target"]["path"]) for one in document["animations"][0]["channels"]}
    assert targets == {(node, "rotation") for node in nodes.values()} | {(nodes["hips"], "translation")}
    tree = vrma.Tree(document, binary)
    seconds = tree.times[-1]
    assert abs(seconds * FPS - round(seconds * FPS)) < 1e-3 and abs(np.diff(tree.times) - 1 / FPS).max() < 1e-4
    (armature,) = [item for item in bpy.data.objects if item.type == "ARMATURE"]
    pairs = [(f"{side}{one}", f"{side}{end}") for side in ("left", "right") for one, end in vrma.LAID.items()]
    pairs = [pair for pair in pairs if nodes.keys() >= set(pair)]
    rest, moved = tree.heads(tree.rest), tree.heads(tree.turned)
    for one, end in [*pairs, ("neck", "head")]:
        at, to = nodes[one], nodes[end]
        seen = directed(np.broadcast_to(moved[to] - moved[at], (len(tree.times), 3)))
        names = document["nodes"][at]["name"], document["nodes"][to]["name"]
        for frame in (0, 9, 17):
            bpy.context.scene.frame_set(frame)
            x, y, z = directed(armature.pose.bones[names[1]].head - armature.pose.bones[names[0]].head)
            assert np.abs(seen[frame] - (x, z, -y)).max() < 0.02, (one, frame)
        if one != "neck":  # a T-pose at rest, as VRM defines it
            aside, thumb = (1 if one.startswith("left") else -1), "Thumb" in one
            wanted = [0, -1, 0] if one.endswith("Leg") else directed([aside, 0, 1]) if thumb else [aside, 0, 0]
            assert directed(rest[to] - rest[at]) @ wanted > 0.999, one
    for side in ("left", "right"):
        assert abs(directed(rest[nodes[f"{side}IndexProximal"]] - rest[nodes[f"{side}LittleProximal"]])[1]) < 1e-3  # palms down
    assert all(max(np.abs(node.get("rotation", [1.0]))) <= 1 for node in document["nodes"])  # by rounding, either
    hips = rest[nodes["hips"]]
    assert np.abs(hips[[0, 2]]).max() < 1e-4 and 0.8 < hips[1] < 1.1

    armature.location, armature.rotation_euler.z = (3.0, 1.0, 0.0), 2.0
    vrm_animation.write(bpy.context.scene, Character(armature, ()), tmp_path / "aside.vrma")
    again = vrma.Tree(*vrma.read_glb((tmp_path / "aside.vrma").read_bytes()))
    assert np.abs(np.subtract(again.heads(again.rest), rest)).max() < 1e-4
    assert np.abs(np.subtract(again.turned, tree.turned)).max() < 1e-4


def directed(vectors):
    return np.asarray(vectors) / np.linalg.norm(vectors, axis=-1, keepdims=True)


def test_what_has_no_legs_is_no_vrm_animation():
    with pytest.raises(UsageError, match="needs the bone hips"):
        vrma.from_glb(b"", {"head": "head"})


def test_a_line_leaves_and_reaches_rest():
    moving = idling.idle(3.0, seed=2, stillness=0.0)
    line = verb.settled(moving)
    assert line.pelvis is None and np.allclose(line.directions[[0, -1]], rest.REST, atol=1e-5)
    middle = slice(10, -10)
    assert np.allclose(line.directions[middle], moving.directions[middle], atol=1e-5)
    assert line.face.weights[0].max() == line.face.weights[-1].max() == 0


def test_what_a_game_is_told():
    about = json.loads(json.dumps(verb.describe(idling.idle(4.0, loop=True), FPS)))
    assert about["loop"] and about["frames"] == 4 * FPS + 1 and about["seconds"] == 4.0
    assert all(one["begin"] <= one["stroke"] <= one["hold"] <= one["end"] for one in about["events"])
