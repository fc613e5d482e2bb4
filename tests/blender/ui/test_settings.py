"""What is set in the panel reaches the engine: styles, sliders, words."""

import bpy
import pytest
from acted import drawn, press
from s2ag.core import styles, user_folders
from s2ag.core.errors import UsageError
from s2ag.core.model import checkpoint_metadata
from s2ag.s2ag_blender import provenance
from s2ag.s2ag_blender.engine import engine_state
from s2ag.s2ag_blender.takes import engine_requests, generate, menu_items, sources
from s2ag.s2ag_blender.ui import properties


@pytest.fixture
def shipped(monkeypatch):
    """Makes a checkpoint the shipped one."""

    def make(path):
        monkeypatch.setattr(checkpoint_metadata, "DEFAULT_CHECKPOINT", path)

    yield make
    menu_items._read_checkpoint.cache_clear()


def test_sliders_of_a_checkpoint_with_controls(figure, shipped, random_checkpoint):
    shipped(random_checkpoint)
    assert properties.control_names() == list(styles.CONTROLS) and properties.style_names() == ["calm one", "lively one"]
    shown = drawn()
    assert all(shown[name] for name in (*styles.CONTROLS, "intensity"))


def test_sliders_are_grey_with_the_reason_where_the_checkpoint_has_none(figure, shipped, plain_checkpoint):
    shipped(plain_checkpoint)
    shown = drawn()
    assert not any(shown[name] for name in styles.CONTROLS)
    assert shown["intensity"] and any("checkpoint" in text for text in shown)


def test_a_missing_checkpoint_does_not_break_the_panel(figure, shipped, tmp_path):
    shipped(tmp_path / "none.safetensors")
    assert properties.style_names() == [] and not drawn()["arousal"]

def test_weights_are_chosen_by_their_name(speaker, random_checkpoint, monkeypatch):
    monkeypatch.setenv(user_folders.ENVIRONMENT_VARIABLE, str(random_checkpoint.parent))
    engine_requests.stop_engine()  # the next one knows the folder
    speaker.s2ag.checkpoint = random_checkpoint.stem
    assert menu_items.style_names(speaker.s2ag) == ["calm one", "lively one"]
    speaker.s2ag.style = "lively one"
    press(bpy.ops.s2ag.generate)
    told = provenance.read(speaker.animation_data.action)
    assert told["checkpoint"] == checkpoint_metadata.describe(random_checkpoint)["hash"]


def test_the_style_menu_reads_and_writes_the_style(figure):
    kept = figure.s2ag
    names = menu_items.style_names()
    assert kept.style_pick in names and menu_items.style_description(kept)
    kept.style_pick = "stern"
    assert kept.style == "stern" and menu_items.style_expression(kept) == "stern"
    kept.style_second_pick, kept.style_mix = "tired", 0.4
    assert menu_items.style_expression(kept) == "stern:0.6+tired:0.4"
    kept.style_second_pick = menu_items.NOBODY
    assert kept.style_second == "" and menu_items.style_expression(kept) == "stern"
    kept.style_pick = "random"
    assert menu_items.style_expression(kept) == "random" and not menu_items.can_blend(kept)
    kept.style_pick = menu_items.WRITTEN
    assert menu_items.is_written(kept) and "style" in drawn()


def test_the_style_menu_has_an_order(figure, random_checkpoint):
    items = menu_items.style_items(figure.s2ag, bpy.context)
    below = [one[1] for one in items if not one[0]]
    assert below == list(menu_items.TEMPERAMENTS)[:-1] and [one[0] for one in items[:2]] == ["random", menu_items.WRITTEN]
    numbers = {one[0]: one[-1] for one in items if one[0]}
    names = menu_items.style_names()
    assert [numbers[name] for name in [*names, "random", menu_items.WRITTEN]] == list(range(len(names) + 2))
    figure.s2ag.style_pick = "tour guide"
    assert figure.s2ag.style == "tour guide"
    figure.s2ag.checkpoint = str(random_checkpoint)  # of two styles that no heading names
    assert [one[0] for one in menu_items.style_items(figure.s2ag, bpy.context)][2:] == ["calm one", "lively one"]


def test_sliders_reach_the_action(speaker, random_checkpoint):
    speaker.s2ag.checkpoint = str(random_checkpoint)
    speaker.s2ag.valence, speaker.s2ag.rate = -0.5, 1.0
    assert bpy.ops.s2ag.generate() == {"FINISHED"}
    told = provenance.read(speaker.animation_data.action)
    assert told["affect"] == {"arousal": 0.0, "valence": -0.5, "dominance": 0.0}
    assert (told["rate"], told["hand"]) == (1.0, 0.0)


def test_sliders_that_the_checkpoint_lacks_are_left_out_and_told(speaker, plain_checkpoint):
    speaker.s2ag.checkpoint = str(plain_checkpoint)
    speaker.s2ag.arousal = 0.5
    outcome = generate.wait(bpy.context, generate.plan(bpy.context, speaker))
    assert "sliders were left out" in outcome.warnings[0] and speaker.animation_data.action


def test_words_typed_in_a_block_beside_and_none(figure, tmp_path, voice):
    kept = figure.s2ag
    recording = tmp_path / "line.wav"
    recording.write_bytes(voice.read_bytes())
    kept.audio = str(recording)
    assert "transcript" not in engine_requests.request(kept)
    for suffix, words in ((".srt", "1\n00:00:00,000 --> 00:00:01,000\nhello there"), (".txt", "hello there")):
        beside = recording.with_suffix(suffix)
        beside.write_text(words)
        sources._cache.clear()
        assert engine_requests.request(kept)["transcript"] == str(beside)
        assert f"line{suffix} beside it has the words" in drawn()
    kept.transcript_source, kept.typed = "TYPED", "good day"
    assert engine_requests.request(kept)["text"] == "good day" and "language" not in engine_requests.request(kept)
    kept.language = "de"
    assert engine_requests.request(kept)["language"] == "de"
    kept.transcript_source = "BLOCK"
    with pytest.raises(UsageError, match="text block"):
        engine_requests.request(kept)
    kept.transcript_block = bpy.data.texts.new("lines")
    kept.transcript_block.write("from the editor")
    assert engine_requests.request(kept)["text"] == "from the editor"
    kept.transcript_source = "NONE"
    assert not {"text", "transcript"} & set(engine_requests.request(kept))


def test_words_that_the_engine_recognises(speaker, examples):
    """Where the engine has the extra, words come by themselves; where it has not, one sentence says how to add it."""
    speaker.s2ag.audio, speaker.s2ag.transcript_source = str(examples / "hello.flac"), "RECOGNISE"
    speaker.s2ag.add_markers = True
    told = engine_requests.request(speaker.s2ag)
    assert told["recognise"] and not {"text", "transcript"} & set(told)
    shown = " ".join(drawn())
    if engine_state.has_recogniser(bpy.context) is False:
        assert "The engine has no speech recognizer yet" in shown and not bpy.ops.s2ag.generate.poll()
        assert "recognise]" in shown
        return
    assert "English speech only" in shown
    try:
        bpy.ops.s2ag.generate()
    except RuntimeError as error:
        (line,) = str(error).strip().splitlines()
        assert "recogniser is not installed" in line and 'pip install "s2ag[recognise]"' in line
        assert not bpy.data.actions and "s2ag.open_log" in drawn()
        return
    names = [marker.name.lower() for marker in bpy.context.scene.timeline_markers]
    assert len(names) > 20
