"""Blender's habits while a take is directed: a quiet console, counts and reports that are right, one bar, a bin that asks."""

import re
from types import SimpleNamespace

import bpy
import pytest
from acted import Sheet, drawn, now, press
from s2ag.core.settings import CURVES
from s2ag.s2ag_blender import registration
from s2ag.s2ag_blender.takes import generate, gesture_edits, operator_base, session
from s2ag.s2ag_blender.ui import decisions, gesture_panel, panel, subpanels, take_ops

PANELS = [gesture_panel.S2AG_PT_directing, decisions.S2AG_PT_decisions, panel.S2AG_PT_gestures]
PANELS += [one for one in registration.classes_of(subpanels) if issubclass(one, bpy.types.Panel)]
EDITS = {
    "change_gesture": {"size": 1.3}, "add_gesture": {"kind": "point"}, "style_from": {"style": "stern"}, "feeling_from": {},
    "change_decision": {"number": 0, "size": 0.7}, "switch_decision": {"number": 0},
}  # fmt: skip


class Noted(Sheet):
    """A sheet that also notes bars, what buttons are pressed with, and the dots beside a character's settings."""

    def __init__(self, drawn=None, above=(), notes=None):
        super().__init__(drawn, above)
        self.notes = {"bars": [], "buttons": [], "dots": {}} if notes is None else notes
        self.use_property_decorate = bool(above) and above[-1].use_property_decorate

    def column(self, **_):
        return Noted(self.drawn, (*self.above, self), self.notes)

    row = box = split = column

    def progress(self, **about):
        super().progress(**about)
        self.notes["bars"].append(about)

    def operator(self, name, text=None, **about):
        button = super().operator(name, **about)
        self.notes["buttons"].append((name, text, button))
        return button

    def operator_menu_enum(self, name, prop, text=None, **_):
        return self.operator(name, text)

    def prop(self, settings, name, text=None, **about):
        super().prop(settings, name, text, **about)
        if settings == bpy.data.objects["Mannequin"].s2ag:
            self.notes["dots"][name] = self.use_property_decorate


def sheet():
    """What all panels note as they are drawn now."""
    noted = Noted()
    for cls in PANELS:
        if not hasattr(cls, "poll") or cls.poll(bpy.context):
            cls.draw(type("Stand", (), {"layout": noted, "draw_settings": getattr(cls, "draw_settings", None)})(), bpy.context)
    return noted.notes


def applied():
    """The texts of the button that applies markers."""
    return [text for name, text, _ in sheet()["buttons"] if name == "s2ag.apply_markers"]


@pytest.mark.slow
@pytest.mark.usefixtures("sound_system")
def test_the_console_stays_quiet_and_a_report_says_what_changed(speaker, take, capfd):
    bpy.context.scene.frame_set(180)
    for name, asked in EDITS.items():
        assert press(getattr(bpy.ops.s2ag, name), **asked) == {"FINISHED"}
        sheet()
        last = bpy.context.window_manager.operators[-1].properties
        read = [getattr(one, prop.identifier) for one in (last, speaker.s2ag) for prop in one.bl_rna.properties]
        assert read and "" not in [getattr(last, prop.identifier) for prop in last.bl_rna.properties if prop.type == "ENUM"]
    told = [line for line in "".join(capfd.readouterr()).splitlines() if line.strip()]
    assert not [line for line in told if not line.startswith(("Info: ", "Warning: "))], told
    said = [line.removeprefix("Info: ") for line in told if line.startswith("Info: ")]
    assert len(said) == len(EDITS) and not [line for line in said if "gestures for" in line], said
    counts = [re.findall(r"(\d+) gestures before, (\d+) now", line) for line in said]
    assert any(counts) and all(before != now for found in counts for before, now in found), said  # told where it changes
    assert said[0].startswith("× 1.3, ") and said[1].startswith("Added, ") and said[-1].startswith("Off: "), said


def test_apply_counts_what_will_change(speaker, take):
    shown = gesture_edits.shown_gestures(take, bpy.context.scene)
    assert not applied()
    for one, by in ((shown[2], 5), (shown[6], -5), (shown[8], 3)):
        take.pose_markers[one.name].frame += by
    take.pose_markers[shown[8].name].frame -= 3  # and back
    for one in (shown[4], shown[10]):
        take.pose_markers.remove(take.pose_markers[one.name])
    take.pose_markers.new("of the user").frame = 20
    assert applied() == ["Apply Moved Markers (4)"]
    assert press(bpy.ops.s2ag.apply_markers) == {"FINISHED"} and not applied()
    gone, *moved = gesture_edits.edits_of(now(speaker))
    assert gone["at"] == [shown[4].at, shown[10].at] and [one["at"] for one in moved] == [shown[2].at, shown[6].at]


def test_the_bin_names_what_it_deletes_and_asks_where_it_is_more_than_one(speaker, take, capfd):
    speaker.s2ag.takes[0].title, asked = "the good one", []

    def confirm(operator, event, title):
        asked.append(title)
        return {"RUNNING_MODAL"}

    def pressed():
        """What the bin does in a window; without one, Blender would not ask."""
        context = SimpleNamespace(
            active_object=speaker, view_layer=bpy.context.view_layer, window_manager=SimpleNamespace(invoke_confirm=confirm)
        )
        return take_ops.S2AG_OT_delete_take.invoke(SimpleNamespace(execute=lambda context: {"FINISHED"}), context, None)

    assert pressed() == {"FINISHED"} and not asked
    bpy.context.scene.frame_set(180)
    press(bpy.ops.s2ag.delete_gesture)
    assert pressed() == {"RUNNING_MODAL"} and asked == ["Delete the good one with its 2 versions?"]
    capfd.readouterr()
    press(bpy.ops.s2ag.delete_take)
    assert "Info: the good one is deleted" in "".join(capfd.readouterr()) and not speaker.s2ag.takes and not bpy.data.actions


def test_one_bar_shows_progress_and_the_wheel_scrolls_meanwhile(speaker):
    run = session.Run(bpy.context, speaker, generate.plan(bpy.context, speaker))
    assert len(sheet()["bars"]) == 1
    assert "live" in drawn(panel.S2AG_PT_gestures)  # where the button was is as much as before: nothing below moves
    wheel = SimpleNamespace(type="WHEELDOWNMOUSE", value="PRESS")
    running = SimpleNamespace(_run=run, shares_events=False)
    assert operator_base.ModalOperator.modal(running, bpy.context, wheel) == {"PASS_THROUGH"}
    run.cancel()
    run.end()
    assert not sheet()["bars"]


def test_what_can_be_keyed_has_a_dot_beside_it_and_nothing_else_takes_keys(speaker):
    speaker.s2ag.style_second = "stern"
    dots = sheet()["dots"]
    assert {name for name, dot in dots.items() if dot} == set(CURVES) and len(dots) > 30
    assert {prop.identifier for prop in speaker.s2ag.bl_rna.properties if prop.is_animatable} == set(CURVES)


def test_a_hand_can_point_from_the_panel(speaker):
    press(bpy.ops.s2ag.generate)
    buttons = [(text, button) for name, text, button in sheet()["buttons"] if name == "s2ag.keep_place"]
    assert [(text, button.pointing) for text, button in buttons] == [("Hand at Object", None), ("Point", True)]
