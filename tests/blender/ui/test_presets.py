"""Presets of a character's manner, by Blender's own preset system."""

import ast
from pathlib import Path

import bpy
import pytest
import s2ag
from s2ag.core.model import checkpoint_metadata
from s2ag.s2ag_blender.ui import presets

SHIPPED = sorted((Path(__file__).resolve().parents[3] / "presets" / presets.FOLDER).glob("*.py"))
OWN_RIG = {"torso_strength", "head_strength", "clavicle_strength", "palms", "hands"}
"""What suits a rig rather than a manner; the shipped presets leave it alone."""


@pytest.fixture
def figure():
    s2ag.register()
    bpy.ops.s2ag.add_mannequin()
    yield bpy.context.object
    s2ag.unregister()


@pytest.fixture
def saved(figure):
    """Saves a preset under a name and returns its file; the files are removed afterwards."""
    files = []

    def save(name):
        assert bpy.ops.s2ag.preset_add(name=name) == {"FINISHED"}
        files.append(Path(bpy.utils.preset_find(name.replace(" ", "_"), presets.FOLDER)))
        return files[-1]

    yield save
    for path in files:
        path.unlink(missing_ok=True)


def load(path):
    return bpy.ops.script.execute_preset(filepath=str(path), menu_idname="S2AG_PT_presets")


def values(figure):
    return {name: getattr(figure.s2ag, name) for name in presets.VALUES}


def test_a_preset_that_was_saved_is_loaded_as_it_was(figure, saved):
    settings = figure.s2ag
    settings.style, settings.style_second, settings.style_mix = "stern", "warm host", 0.25
    settings.arousal, settings.hand, settings.intensity, settings.mirror = -0.75, 0.5, 1.25, True
    settings.torso_strength, settings.audio, settings.start_frame = 0.5, "talk.wav", 33
    kept = values(figure)
    path = saved("my manner")
    for name, value in kept.items():
        other = {str: "tired", float: 0.125, bool: False}[type(value)]
        setattr(settings, name, other)
    settings.audio, settings.start_frame = "other.wav", 44
    assert load(path) == {"FINISHED"}
    assert values(figure) == kept
    assert (settings.audio, settings.start_frame) == ("other.wav", 44)  # the recording is no manner


def test_a_preset_goes_to_the_armature_of_the_active_mesh(figure, saved):
    figure.s2ag.intensity = 0.5
    path = saved("half")
    figure.s2ag.intensity = 1.0
    mesh = next(item for item in bpy.data.objects if item.type == "MESH" and item.find_armature() == figure)
    bpy.context.view_layer.objects.active = mesh
    load(path)
    assert figure.s2ag.intensity == 0.5


def test_a_preset_can_be_removed_but_not_a_shipped_one(figure, saved):
    path = saved("passing")
    assert bpy.ops.s2ag.preset_add(name="passing", remove_name=True) == {"FINISHED"} and not path.exists()
    assert bpy.ops.s2ag.preset_add(name="Lecture") == {"CANCELLED"}  # the name is taken
    assert all(path.is_file() for path in SHIPPED)


def test_nothing_to_keep_without_a_character(figure):
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    assert not bpy.ops.s2ag.preset_add.poll()


def test_what_a_preset_holds_exists(figure):
    assert set(presets.VALUES) <= set(figure.s2ag.bl_rna.properties.keys())


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_presets_are_plain_assignments_of_good_values(figure, path):
    assigned = {}
    for node in ast.parse(path.read_text("utf-8")).body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Attribute):
            assigned[node.targets[0].attr] = ast.literal_eval(node.value)
        else:
            assert ast.unparse(node) in ("import bpy", presets.SETTINGS)
    missing = set(presets.VALUES) - OWN_RIG - set(assigned)
    assert not missing, f"give every shipped preset a line for {', '.join(sorted(missing))}"
    assert set(assigned) == set(presets.VALUES) - OWN_RIG
    assert load(path) == {"FINISHED"}
    for name, value in assigned.items():
        assert getattr(figure.s2ag, name) == (pytest.approx(value) if isinstance(value, float) else value)
    known = {speaker["name"] for speaker in checkpoint_metadata.describe()["speakers"]}
    assert {assigned["style"], assigned["style_second"]} - {""} <= known


def test_blender_finds_between_four_and_six_shipped_presets(figure):
    assert 4 <= len(SHIPPED) <= 6
    assert [path for folder in bpy.utils.preset_paths(presets.FOLDER) for path in Path(folder).glob("Lecture.py")]


def test_presets_hold_what_they_ever_held():
    manner = "style style_second style_mix intensity arousal valence dominance rate hand meaning hands mirror speed smoothing"
    assert set(presets.VALUES) >= {*manner.split(), *OWN_RIG}
