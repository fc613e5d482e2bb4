"""The extension as a user has it: registered, its operators run, nothing broken by what fails."""

import bpy
import numpy as np
import pytest
import s2ag
from s2ag.core import catalogue, skeleton, styles
from s2ag.core.errors import UsageError, WorkerFailed
from s2ag.core.motion import Motion
from s2ag.s2ag_blender import client, compat, gesture, keyframes, operators, panel, properties


@pytest.fixture
def extension():
    s2ag.register()
    yield
    s2ag.unregister()


@pytest.fixture
def engine():
    """A Python that can run the engine, beside a checkpoint to run."""
    try:
        client.find_interpreter()
    except WorkerFailed as error:
        pytest.skip(str(error))


@pytest.fixture
def figure(extension):
    assert bpy.ops.s2ag.add_mannequin() == {"FINISHED"}
    return bpy.context.active_object


def test_registering_twice_leaves_nothing_behind():
    for _ in range(2):
        s2ag.register()
        assert hasattr(bpy.types, "S2AG_PT_gestures") and hasattr(bpy.types.Object, "s2ag")
        s2ag.unregister()
        assert not hasattr(bpy.types, "S2AG_PT_gestures") and not hasattr(bpy.types.Object, "s2ag")


def test_adding_a_character_selects_its_armature(figure):
    assert figure.type == "ARMATURE" and figure.select_get()
    assert operators.character(bpy.context) == figure


def test_the_button_waits_for_a_character_and_a_recording(extension):
    assert not bpy.ops.s2ag.generate.poll()
    bpy.ops.s2ag.add_mannequin()
    assert not bpy.ops.s2ag.generate.poll()
    bpy.context.active_object.s2ag.audio = "voice.wav"
    assert bpy.ops.s2ag.generate.poll()


def test_a_recording_becomes_one_action_and_one_sound_strip(figure, engine, examples):
    figure.s2ag.audio = str(examples / "hello.flac")
    figure.s2ag.transcript = str(examples / "hello.txt")
    figure.s2ag.start_frame = 11
    assert bpy.ops.s2ag.generate() == {"FINISHED"}
    action = figure.animation_data.action
    assert [action] == list(bpy.data.actions)
    assert action.frame_range[0] == 11 and action.frame_range[1] > 300
    strips = compat.sequencer_strips(bpy.context.scene.sequence_editor)
    assert [strip.type for strip in strips] == ["SOUND"] and round(strips[0].frame_start) == 11


@pytest.mark.parametrize("wrong", [{"audio": "missing.wav"}, {"style": "nobody"}])
def test_what_fails_changes_nothing(figure, engine, examples, wrong):
    figure.s2ag.audio = str(examples / "hello.flac")
    for name, value in wrong.items():
        setattr(figure.s2ag, name, value)
    with pytest.raises(RuntimeError, match=r"Choose|Check|Styles|Name"):
        bpy.ops.s2ag.generate()
    editor = bpy.context.scene.sequence_editor
    assert not bpy.data.actions and not (editor and list(compat.sequencer_strips(editor)))


def test_a_recording_that_is_gone_when_the_keys_come_still_gestures(figure, tmp_path):
    figure.s2ag.audio = str(tmp_path / "moved away.wav")
    motion = Motion(np.tile(skeleton.MEAN_UNIT, (30, 1, 1)))
    warnings = gesture.key(bpy.context, figure, {"motions": [motion], "warnings": ["first"]})
    assert figure.animation_data.action
    assert warnings[0] == "first" and "sound strip is not" in warnings[-1]


class Sheet:
    """A layout that notes what is drawn on it; properties that do not exist cannot be drawn."""

    def __init__(self, drawn=None, above=()):
        self.drawn = [] if drawn is None else drawn
        self.above, self.active = above, True

    def column(self, **_):
        return Sheet(self.drawn, (*self.above, self))

    row = column

    def panel(self, name, default_closed=False):
        return self.column(), self.column()

    def prop(self, settings, name, **_):
        assert name in settings.bl_rna.properties
        self.drawn.append((name, self))

    def label(self, text="", icon=""):
        self.drawn.append((text, self))

    def operator(self, name, **_):
        self.drawn.append((name, self))


def drawn(armature):
    """What the panel shows: ``{property, operator or text: whether it is active}``."""
    sheet = Sheet()

    class Panel:
        layout = sheet
        _draw_affect = staticmethod(panel.S2AG_PT_gestures._draw_affect)
        _draw_run = staticmethod(panel.S2AG_PT_gestures._draw_run)

    panel.S2AG_PT_gestures.draw(Panel(), bpy.context)
    return {what: all(layout.active for layout in (*where.above, where)) for what, where in sheet.drawn}


@pytest.fixture
def shipped(monkeypatch):
    """Makes a checkpoint the shipped one."""

    def make(path):
        monkeypatch.setattr(catalogue, "DEFAULT", path)
        properties._described.cache_clear()

    yield make
    properties._described.cache_clear()


def test_sliders_of_a_checkpoint_with_controls(figure, shipped, random_checkpoint):
    shipped(random_checkpoint)
    assert properties.control_names() == list(styles.CONTROLS) and properties.style_names() == ["calm one", "lively one"]
    shown = drawn(figure)
    assert all(shown[name] for name in (*styles.CONTROLS, "intensity", "s2ag.generate"))


def test_sliders_are_grey_with_the_reason_where_the_checkpoint_has_none(figure, shipped, plain_checkpoint):
    shipped(plain_checkpoint)
    shown = drawn(figure)
    assert not any(shown[name] for name in styles.CONTROLS)
    assert shown["intensity"] and any("checkpoint" in text for text in shown)


def test_a_missing_checkpoint_does_not_break_the_panel(figure, shipped, tmp_path):
    shipped(tmp_path / "none.safetensors")
    assert properties.style_names() == [] and not drawn(figure)["arousal"]


def test_sliders_are_saved_with_the_character(figure, tmp_path):
    figure.s2ag.arousal, figure.s2ag.hand, figure.s2ag.rate = 0.8, -2.0, 0.25
    path, name = str(tmp_path / "scene.blend"), figure.name
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    kept = bpy.data.objects[name].s2ag
    kept.audio = "voice.wav"
    told = gesture.request(kept)
    assert told["affect"] == {"arousal": 0.8, "valence": 0.0, "dominance": 0.0}
    assert (told["hand"], told["rate"]) == (-1.0, 0.25)  # sliders end at -1
    assert all(kept.bl_rna.properties[name].description for name in styles.CONTROLS)


def test_sliders_reach_the_action(figure, engine, examples, random_checkpoint):
    figure.s2ag.audio = str(examples / "hello.flac")
    figure.s2ag.valence, figure.s2ag.rate = -0.5, 1.0
    params = {**gesture.request(figure.s2ag), "checkpoint": str(random_checkpoint)}
    result = gesture._loaded(gesture.engine(bpy.context).call("synthesize", params))
    gesture.key(bpy.context, figure, result)
    told = keyframes.provenance(figure.animation_data.action)
    assert told["affect"] == {"arousal": 0.0, "valence": -0.5, "dominance": 0.0}
    assert (told["rate"], told["hand"]) == (1.0, 0.0)


def test_sliders_that_the_checkpoint_lacks_are_an_error_that_changes_nothing(figure, engine, examples, plain_checkpoint):
    figure.s2ag.audio = str(examples / "hello.flac")
    figure.s2ag.arousal = 0.5
    params = {**gesture.request(figure.s2ag), "checkpoint": str(plain_checkpoint)}
    with pytest.raises(UsageError, match="no control of arousal"):
        gesture.engine(bpy.context).call("synthesize", params)
    assert not bpy.data.actions
