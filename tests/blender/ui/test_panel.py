"""The panel at a glance: what gesturing takes is above the button, nothing is claimed too early, menus have all of it."""

import bpy
from acted import Sheet, active, drawn, press
from s2ag.s2ag_blender import registration
from s2ag.s2ag_blender.rig import readiness
from s2ag.s2ag_blender.takes import generate, menu_items, operator_base, session
from s2ag.s2ag_blender.ui import gesture_panel, panel, presets, subpanels

FIRST = {"audio_source", "audio", "transcript_source", "transcript", "style_pick", "s2ag.generate", "live"}


def words(shown):
    return [what for what in shown if what not in FIRST and not what.startswith("s2ag")]


def test_above_the_fold_are_recording_words_style_and_the_button(speaker, examples):
    shown = drawn(panel.S2AG_PT_gestures)
    assert [what for what in shown if what in FIRST] == [
        *("audio_source", "audio", "transcript_source", "transcript", "style_pick", "s2ag.generate", "live")
    ]
    assert "No words: the audio alone gestures" in shown and len(shown) < 16
    speaker.s2ag.audio = str(examples / "hello.flac")
    assert "hello.txt beside it has the words" in drawn(panel.S2AG_PT_gestures)


def test_nothing_is_claimed_before_there_is_a_recording(figure):
    readiness.readiness_of(figure)
    assert words(drawn(panel.S2AG_PT_gestures)) == [
        *(figure.name, "9 of 9 parts"),
        *menu_items.wrap_text(menu_items.style_description(figure.s2ag)),
        "Choose a recording",
    ]


def test_why_the_button_is_grey_stands_right_below_it(speaker):
    def below():
        shown = list(drawn(panel.S2AG_PT_gestures))
        return shown[shown.index("s2ag.generate") + 1]

    assert below() == "live"
    for name, value, reason in (
        ("audio", "gone.wav", "The recording is not there"),
        ("audio_source", "STRIP", "The sequencer has no sound strip"),
        ("audio_source", "MIXDOWN", "The sequencer has nothing to hear"),
    ):
        setattr(speaker.s2ag, name, value)
        assert not bpy.ops.s2ag.generate.poll() and below() == reason
    bpy.ops.object.mode_set(mode="EDIT")
    assert below() == "Leave edit mode first"


def test_a_preview_that_can_show_nothing_cannot_be_switched_on_but_off(speaker):
    def switch():
        sheet = Sheet()
        panel.draw_button(sheet, bpy.context)
        return dict(sheet.drawn)["live"].enabled

    assert switch()
    speaker.s2ag.audio = ""
    assert not switch()
    bpy.context.window_manager.s2ag.live = True
    assert switch()
    bpy.context.window_manager.s2ag.live = False


def test_a_rig_that_cannot_gesture_says_so_once(extension):
    bpy.ops.object.armature_add()
    problem = readiness.readiness_of(bpy.context.active_object).problem
    shown = list(drawn(panel.S2AG_PT_gestures))
    lines = menu_items.wrap_text(problem)
    assert [what for what in shown if what in lines] == lines and shown.index(lines[0]) == shown.index("s2ag.generate") + 1


def test_what_hangs_on_a_character_and_what_is_selected_with_it_choose_it(figure):
    """An imported FBX leaves the empty that came last active, and everything selected."""
    foot, camera = (bpy.data.objects.new("Other", data) for data in (None, bpy.data.cameras.new("Eye")))
    for item in (foot, camera):
        bpy.context.collection.objects.link(item)
    foot.parent = figure
    bpy.context.view_layer.objects.active = foot
    assert operator_base.character(bpy.context) == figure and "audio" in drawn(panel.S2AG_PT_gestures)
    bpy.context.view_layer.objects.active = camera
    assert operator_base.character(bpy.context) == figure  # still selected
    bpy.ops.script.execute_preset(filepath=bpy.utils.preset_find("Lecture", presets.FOLDER), menu_idname="S2AG_PT_presets")
    assert figure.s2ag.style == "calm lecturer"
    figure.select_set(False)
    assert operator_base.character(bpy.context) is None


def test_a_part_that_is_missing_is_named(figure):
    press(bpy.ops.s2ag.edit_bone_map)
    figure.s2ag.bone_map["left_clavicle"].bones = ""
    shown = " ".join(drawn(panel.S2AG_PT_gestures))
    assert "8 of 9 parts" in shown and "Not found: Clavicle L." in shown


def test_the_recording_and_the_words_beside_it_are_named(speaker, examples):
    speaker.s2ag.audio, fields = str(examples / "hello.flac"), {}

    class Fields(Sheet):
        def column(self, **_):
            return self

        row = column

        def prop(self, settings, name, placeholder="", **_):
            fields[name] = placeholder
            super().prop(settings, name)

    sheet = Fields()
    panel.draw_voice(sheet, speaker.s2ag, bpy.context.scene)
    panel.draw_words(sheet, speaker.s2ag, bpy.context)
    assert fields["transcript"] == "hello.txt" and "hello.flac" in active(sheet)
    speaker.s2ag.audio = "//hello.flac"  # the field shows all of it
    assert "hello.flac" not in drawn(panel.S2AG_PT_gestures)


def test_progress_is_told_wherever_it_was_started(speaker):
    """In the panel that has a button for it, and in the status bars of all windows until it ends."""
    told, run = [], session.Run(bpy.context, speaker, generate.plan(bpy.context, speaker))
    window = type("Window", (), {"workspace": type("Space", (), {"status_text_set": told.append})})
    windows = type("Context", (), {"window_manager": type("Manager", (), {"windows": [window]})})
    operator_base.announce(windows, run)
    assert {"Getting ready", "s2ag.cancel"} <= set(drawn(panel.S2AG_PT_gestures))
    run.cancel()
    operator_base.announce(windows, run)
    run.end()
    operator_base.announce(windows, None)
    assert told == ["Getting ready (0%), Esc cancels", "Cancelling (0%), Esc cancels", None]


def test_a_button_leads_to_the_tab(extension):
    bpy.ops.wm.read_factory_settings()
    s2ag_area = next(area for area in bpy.data.screens["Layout"].areas if area.type == "VIEW_3D")
    s2ag_area.spaces.active.show_region_ui = False
    press(bpy.ops.s2ag.show_panel)
    assert any(area.spaces.active.show_region_ui for area in bpy.context.window.screen.areas if area.type == "VIEW_3D")


def test_every_setting_is_in_some_panel(speaker):
    """What moved out of the first panel is in one below it."""
    speaker.s2ag.style_second, speaker.s2ag.add_markers, speaker.s2ag.result = "stern", True, "LAYER"
    shown = drawn()
    every = {prop.identifier for prop in speaker.s2ag.bl_rna.properties if not prop.is_hidden} - {"rna_type", "name"}
    inside = {"style", "style_second", "takes", "active_take", "bone_map"}  # behind what shows them
    other = {"sound_strip", "transcript_block", "typed"}  # of other sources
    directed = {"target"}  # in the panel of a take's gestures
    assert every - inside - other - directed <= set(shown)


def test_what_buttons_do_is_in_menus_too(figure):
    """Blender's search looks through the menus."""

    def entries(name):
        sheet = Sheet()
        for draw in getattr(bpy.types, name)._dyn_ui_initialize():
            if draw.__module__.startswith("s2ag."):
                draw(type("Stand", (), {"layout": sheet})(), bpy.context)
        return active(sheet)

    in_menus = set(entries("VIEW3D_MT_object_animation")) | set(entries("VIEW3D_MT_armature_add"))
    pressed = {what for what in drawn() if what.startswith("s2ag.")} | {"s2ag.keep_take", "s2ag.remove_markers"}
    assert pressed <= in_menus | {"s2ag.open_log"} and "live" in in_menus
    bpy.context.view_layer.objects.active = None
    assert set(entries("VIEW3D_MT_object_animation")) == {"s2ag.show_panel"}


def test_the_tab_says_what_it_is_for(extension):
    every = [panel.S2AG_PT_gestures, *[one for one in registration.classes_of(subpanels) if issubclass(one, bpy.types.Panel)]]
    assert {one.bl_category for one in every} == {"Gestures"}
    assert {one.bl_parent_id for one in every[1:]} == {"S2AG_PT_gestures"}


def test_what_is_done_with_takes_comes_right_below_them(extension):
    directing = gesture_panel.S2AG_PT_directing
    others = [one for one in registration.classes_of(subpanels) if hasattr(one, "bl_order")]
    assert subpanels.S2AG_PT_takes.bl_order < directing.bl_order
    assert all(one.bl_order > directing.bl_order for one in others if one is not subpanels.S2AG_PT_takes)
