"""Live preview: a draft that follows the sliders and leaves no trace."""

import time

import bpy
import pytest
from acted import curves, press, same_curves, settle
from s2ag.s2ag_blender import provenance
from s2ag.s2ag_blender.keys import layers
from s2ag.s2ag_blender.takes import engine_requests, generate, preview, session

pytestmark = pytest.mark.slow


@pytest.fixture
def live(speaker):
    """A mannequin with the preview on and a warm engine."""
    engine_requests.engine(bpy.context).call("hello", {"warm": True})
    bpy.context.window_manager.s2ag.live = True
    yield speaker
    bpy.context.window_manager.s2ag.live = False


def test_off_unless_asked_for(speaker):
    speaker.s2ag.intensity = 0.5
    assert not preview._pending and preview.tick() is None


def test_a_slider_moves_the_draft_in_place(live):
    settle()
    draft = layers.draft_of(live)
    assert draft and live.animation_data.action == draft and not live.s2ag.takes
    before = curves(draft)
    live.s2ag.intensity = 0.3
    settle()
    assert layers.draft_of(live) == draft and not same_curves(before, curves(draft)) and len(bpy.data.actions) == 1


def test_switching_off_gives_back_what_was_there(live):
    bpy.context.window_manager.s2ag.live = False
    press(bpy.ops.s2ag.generate)
    take = live.animation_data.action
    bpy.context.window_manager.s2ag.live = True
    live.s2ag.style = "stern"
    settle()
    assert layers.draft_of(live) and live.animation_data.action != take
    bpy.context.window_manager.s2ag.live = False
    assert live.animation_data.action == take and list(bpy.data.actions) == [take]


def test_the_button_replaces_the_draft_by_a_take(live):
    settle()
    press(bpy.ops.s2ag.generate)
    assert [take.action for take in live.s2ag.takes] == list(bpy.data.actions) == [live.animation_data.action]


def test_the_figure_moves_while_a_slider_is_dragged(live):
    """A change at every look, faster than any draft: drafts come nevertheless, one after another."""
    settle()
    seen, began, step = [], time.monotonic(), 0
    while len(seen) < 3:
        assert time.monotonic() - began < 120, "no draft during the drag"
        step += 1
        live.s2ag.intensity = 0.2 + step % 100 / 100
        preview.tick()
        assert len(preview._jobs) <= 1
        found = curves(layers.draft_of(live))
        if not seen or not same_curves(seen[-1], found):
            seen.append(found)
        time.sleep(0.005)
    live.s2ag.intensity = 0.77
    settle()
    assert provenance.read(layers.draft_of(live))["intensity"] == pytest.approx(0.77)


def test_the_draft_of_a_long_recording_is_around_the_playhead(live, wave):
    settle()
    scene = bpy.context.scene
    for frame, frames in ((1, (1, 361)), (600, (420, 780)), (5000, (1080, 1440))):
        scene.frame_set(frame)
        planned = generate.plan(bpy.context, live, draft=True)
        generate.finish(planned, {"motions": [wave(60 * 15)]})
        place = layers.Place.of(layers.draft_of(live))
        assert (place.first, place.last) == pytest.approx(frames, abs=2)


def test_the_engine_is_at_the_next_draft_while_one_is_laid(live, monkeypatch):
    settle()
    laid, lay = [], generate.finish
    monkeypatch.setattr(generate, "finish", lambda *given: (laid.append(len(preview._jobs)), lay(*given)))
    live.s2ag.intensity = 0.5
    preview.tick()
    live.s2ag.intensity = 0.6
    settle()
    assert laid == [1, 0] and provenance.read(layers.draft_of(live))["intensity"] == pytest.approx(0.6)


def test_many_changes_are_one_request(live):
    settle()
    before = next(engine_requests.engine(bpy.context)._numbers)
    for step in range(20):
        live.s2ag.intensity = 0.5 + step / 40
    settle()
    assert next(engine_requests.engine(bpy.context)._numbers) - before == 2


def test_a_failing_draft_is_told_and_changes_nothing(live):
    settle()
    live.s2ag.style = "nobody"
    settle()
    assert any("nobody" in text for text, _ in session.messages(live))
    live.s2ag.style = "stern"
    settle()
    assert not session.messages(live)


def test_drafts_are_not_saved(live, tmp_path):
    settle()
    path = str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert not bpy.data.actions and not preview.is_on()


def test_a_draft_does_not_survive_another_file(live):
    settle()
    live.s2ag.style = "stern"
    bpy.ops.wm.read_factory_settings(use_empty=True)
    settle()
    assert not bpy.data.actions
