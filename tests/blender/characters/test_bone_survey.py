"""``s2ag rig`` as a user meets it, and bone maps on the way from a file to keys."""

import json

import bpy
import numpy as np
import pytest
import rigging
import simple_heads
import skeletons
from bodies import Body, body
from s2ag.core.cli.main import main
from s2ag.core.errors import RigUnusable
from s2ag.core.motion import skeleton
from s2ag.core.motion.face import CHANNELS, Face
from s2ag.core.motion.motion import Motion
from s2ag.rigs import maps
from s2ag.rigs.family import families
from s2ag.s2ag_blender import compat
from s2ag.s2ag_blender.characters import loading
from s2ag.s2ag_blender.program import EventWriter
from s2ag.s2ag_blender.render.job import Job, Performer, perform
from s2ag.s2ag_blender.rig import reading

pytestmark = pytest.mark.slow

MIXAMO = next(family for family in families() if family.key == "mixamo")


def scaled(figure: Body) -> Body:
    """Metres to the centimetres that the rigging helper works in."""
    return Body({name: (100 * np.asarray(at), above) for name, (at, above) in figure.joints.items()}, {})


def scattered() -> Body:
    """A person whose bones hang on nothing, which neither names nor positions explain."""
    figure = body("A")
    names = {name: f"part {place}" for place, name in enumerate(figure.joints)}
    return Body(
        {names[name]: (at, None) for name, (at, above) in figure.joints.items()},
        {part: tuple(names[name] for name in chain) for part, chain in figure.chains.items()},
        names["hips"],
    )


def saved(tmp_path, *figures: Body):
    """A .blend file with an armature for every body, called Rig, Rig.001 and so on."""
    for figure in figures:
        rigging.make_armature(figure)
    path = tmp_path / "rigs.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return path


@pytest.fixture
def quiet(capsys):
    """A function that forgets what Blender said while it saved."""
    return capsys.readouterr


def command(*arguments) -> int:
    return main([str(argument) for argument in arguments])


def test_a_known_rig_is_shown_and_saved(tmp_path, capsys, quiet):
    path = saved(tmp_path, scaled(skeletons.person(MIXAMO, "A", "rig:")))
    quiet()
    assert command("rig", path, "--save", tmp_path / "map.json") == 0
    told = capsys.readouterr()
    lines = told.out.splitlines()
    assert lines[0].startswith("Rig: Mixamo, Ready Player Me, ")
    assert "torso            rig:Spine, rig:Spine1, rig:Spine2  name" in lines
    assert "right forearm    rig:RightForeArm                   name" in lines
    assert told.err == f"s2ag: note: {tmp_path / 'map.json'} holds what was found.\n"
    assert maps.load(tmp_path / "map.json").chains["left_upper_arm"] == ("rig:LeftArm",)
    assert command("rig", path, "--map", tmp_path / "map.json") == 0
    assert "right forearm    rig:RightForeArm                   map" in capsys.readouterr().out.splitlines()


def test_an_unknown_rig_is_told_saved_filled_in_and_then_gestures(tmp_path, wave, capsys):
    figure = scattered()
    path = saved(tmp_path, figure)
    file = tmp_path / "map.json"
    assert command("rig", path, "--save", file) == 2
    told = capsys.readouterr()
    assert "left upper arm   -      missing   nothing is called so or lies where it should be" in told.out.splitlines()
    assert 'Armature "Rig" has no bones that look like arms' in told.err.splitlines()[-1]
    written = json.loads(file.read_text("utf-8"))
    assert written["left_upper_arm"] == []
    file.write_text(json.dumps(written | {"hips": figure.hips} | figure.chains), "utf-8")
    assert command("rig", path, "--map", file) == 0
    assert "left upper arm   part 8                  map" in capsys.readouterr().out.splitlines()

    wave(8).save(tmp_path / "motion.npz")
    job = Job((Performer((str(tmp_path / "motion.npz"),), character=str(path), map=str(file)),), (str(tmp_path / "out.blend"),))
    result = perform(job, EventWriter(lambda line: None))
    action = bpy.data.objects["Rig"].animation_data.action
    keyed = {curve.data_path.split('"')[1] for curve in compat.curves(action)}
    assert {name for part in ("left_upper_arm", "right_forearm") for name in figure.chains[part]} <= keyed
    assert result["outputs"] == [str(tmp_path / "out.blend")]


def test_a_face_is_saved_edited_and_then_speaks(tmp_path, capsys, quiet):
    armature = rigging.make_armature(scaled(skeletons.person(MIXAMO, "A")))
    simple_heads.named_keys(armature, ("jawOpen", "mouthPucker", "mouthFunnel", "mouthPressLeft", "Wink"))
    path = saved(tmp_path)
    file = tmp_path / "face.json"
    quiet()
    assert command("rig", path, "--save-face", file) == 0
    told = capsys.readouterr()
    assert "face: ARKit 52, 4 keys, 2 bones" in told.out and told.err.endswith(f"{file} holds the face that was found.\n")
    assert any(line.split() == ["blinks", "missing"] for line in told.out.splitlines())
    content = json.loads(file.read_text("utf-8"))
    assert content["keys"]["jawOpen"] == {"JAW": 0.5}
    content["keys"] |= {"Wink": {"BLINK_LEFT": 1, "BLINK_RIGHT": 1}, "jawOpen": {"JAW": 0.25}}
    file.write_text(json.dumps(content), "utf-8")
    assert command("rig", path, "--face-map", file) == 0
    assert any(line.split() == ["blinks", "Wink"] for line in capsys.readouterr().out.splitlines())

    weights = np.zeros((100, len(CHANNELS)), np.float32)
    weights[:, [CHANNELS.index("JAW"), CHANNELS.index("BLINK_LEFT")]] = 0.8
    motion = Motion(np.repeat(skeleton.REST[None], 16, 0), face=Face(weights, np.zeros((0, 2))))
    motion.save(tmp_path / "motion.npz")
    one = Performer((str(tmp_path / "motion.npz"),), character=str(path), face_map=str(file))
    perform(Job((one,), (str(tmp_path / "out.blend"),)), EventWriter(lambda line: None))
    (key,) = bpy.data.shape_keys
    bpy.context.scene.frame_set(5)
    shown = key.evaluated_get(bpy.context.evaluated_depsgraph_get()).key_blocks
    assert shown["jawOpen"].value == pytest.approx(0.2, abs=1e-3) and shown["Wink"].value == pytest.approx(0.8, abs=1e-3)


def test_no_face_no_face_map(tmp_path, capsys, quiet):
    path = saved(tmp_path, scaled(skeletons.person(MIXAMO, "A")))
    quiet()
    assert command("rig", path, "--save-face", tmp_path / "face.json") == 2
    assert "has no face that speaks" in capsys.readouterr().err and not (tmp_path / "face.json").exists()
    (tmp_path / "face.json").write_text('{"face_map": 1, "keys": {"jawOpen": {"EAR": 1}}}', "utf-8")
    assert command("rig", path, "--face-map", tmp_path / "face.json") == 2
    told = capsys.readouterr()
    assert "shows by 'jawOpen' what no face does" in told.err and not told.out


def test_a_map_with_a_wrong_bone_is_told_before_anything_happens(tmp_path, capsys):
    path = saved(tmp_path, scaled(skeletons.person(MIXAMO, "A")))
    file = tmp_path / "map.json"
    file.write_text(json.dumps({"left_upper_arm": "LeftAram", "left_forearm": "LeftForeArm"}), "utf-8")
    assert command("rig", path, "--map", file) == 2
    told = capsys.readouterr()
    assert "left upper arm   LeftAram     missing   no such bone" in told.out.splitlines()
    assert told.err.endswith('no bone "LeftAram" for the left upper arm. Did you mean "LeftArm"?\n')
    file.write_text("{", "utf-8")
    for arguments in (("rig", path), ("animate", tmp_path / "none.wav", "--character", path, "-o", tmp_path / "a.blend")):
        assert command(*arguments, "--map", file) == 2
        told = capsys.readouterr()
        assert "is no JSON" in told.err and not told.out


def test_a_file_with_several_armatures(tmp_path, capsys, quiet):
    path = saved(tmp_path, scattered(), scaled(skeletons.quadruped()), scaled(skeletons.person(MIXAMO, "A")))
    quiet()
    assert command("rig", path) == 0
    assert capsys.readouterr().out.startswith("Rig.002: Mixamo")
    assert command("rig", path, "--armature", "Rig.001") == 2
    assert 'Armature "Rig.001" stands on four legs' in capsys.readouterr().err
    assert command("rig", path, "--armature", "Nobody") == 2
    assert "Choose one of: Rig, Rig.001, Rig.002." in capsys.readouterr().err


def test_a_map_chooses_among_several_armatures(tmp_path):
    figure = scattered()
    for one in (scaled(skeletons.quadruped()), figure, scaled(skeletons.person(MIXAMO, "A"))):
        rigging.make_armature(one)
    assert loading.choose_armature("it").name == "Rig.002"
    assert loading.choose_armature("it", mapping=figure.mapping).name == "Rig.001"


def test_several_that_cannot_gesture(tmp_path):
    rigging.make_armature(scattered())
    rigging.make_armature(scaled(skeletons.quadruped()))
    with pytest.raises(RigUnusable, match="No armature of it has arms: Rig, Rig.001") as caught:
        loading.choose_armature("it")
    assert "--armature" in caught.value.remedy


def test_what_is_no_character(tmp_path, capsys, quiet):
    bpy.ops.mesh.primitive_cube_add()
    path = tmp_path / "cube.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    quiet()
    for arguments, told in (
        (("rig", path), "cube.blend holds no armature"),
        (("rig", tmp_path / "none.blend"), "does not exist"),
        (("rig", "nobody"), "There is no character"),
        (("rig",), "CHARACTER"),
        (("rig", path, "--map", tmp_path / "none.json"), "does not exist"),
        (("rig", path, "--save", tmp_path / "no" / "map.json"), "The folder"),
    ):
        assert command(*arguments) == 2
        said = capsys.readouterr()
        assert told in said.err and len(said.err.splitlines()) == 1 and not said.out


def test_a_survey_changes_nothing():
    item = rigging.make_armature(scaled(skeletons.person(MIXAMO, "A")))
    before = [tuple(map(tuple, bone.matrix_local)) for bone in item.data.bones], item.animation_data, len(bpy.data.actions)
    mapping, refusal = reading.survey(item)
    assert refusal is None and mapping.family == "mixamo"
    after = [tuple(map(tuple, bone.matrix_local)) for bone in item.data.bones], item.animation_data, len(bpy.data.actions)
    assert before == after
