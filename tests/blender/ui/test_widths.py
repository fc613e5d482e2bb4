"""No text of the panels is cut where the sidebar is as wide as it is at first, in any language, by Blender's own letters."""

import sys

import bpy
import pytest
from acted import press
from measured import CONTENT, Measured, Setting, Text
from s2ag.s2ag_blender import registration, translations
from s2ag.s2ag_blender.rig import readiness
from s2ag.s2ag_blender.takes import bone_map_files, menu_items, stages
from s2ag.s2ag_blender.ui import gesture_panel, panel, subpanels

PANELS = [one for module in (panel, subpanels, gesture_panel) for one in registration.classes_of(module)]


@pytest.fixture(params=["en", *sorted(translations.LANGUAGES)])
def words(request, monkeypatch):
    """The words of a language; what is told is told in it."""
    table = translations.LANGUAGES.get(request.param, {}) | translations.STYLES.get(request.param, {})

    def told(text, **values):
        text = table.get(text, text)
        return text.format(**values) if values else text

    plain = translations.translate
    for name, module in list(sys.modules.items()):
        if name.startswith("s2ag.s2ag_blender.") and getattr(module, "translate", None) is plain:
            monkeypatch.setattr(module, "translate", told)
    return table


def cut(words):
    """Texts of all panels that do not fit, by panel."""
    found = {}
    for cls in PANELS:
        if issubclass(cls, bpy.types.Panel) and (not hasattr(cls, "poll") or cls.poll(bpy.context)):
            sheet = Measured(words)
            stand_in = type("Stand", (), {"layout": sheet, "draw_settings": getattr(cls, "draw_settings", None)})()
            cls.draw(stand_in, bpy.context)
            if sheet.cut():
                found[words.get(cls.bl_label, cls.bl_label)] = sheet.cut()
    return found


def test_before_anything_is_chosen(extension, words):
    assert not cut(words)
    bpy.ops.s2ag.add_mannequin()
    assert not cut(words)


@pytest.mark.parametrize("source", ["STRIP", "MIXDOWN", "FILE"])
def test_with_every_source(speaker, words, source):
    speaker.s2ag.audio_source = source
    for words_from in ("FILE", "BLOCK", "TYPED", "RECOGNISE"):
        speaker.s2ag.transcript_source = words_from
        assert not cut(words)


def test_with_a_take(speaker, words, examples):
    speaker.s2ag.audio = str(examples / "hello.flac")
    speaker.s2ag.add_markers, speaker.s2ag.style_second = True, "tired"
    bpy.context.scene.frame_end = 24
    press(bpy.ops.s2ag.generate)
    take = speaker.s2ag.takes[0]
    assert not cut(words)
    take.action.pose_markers[0].frame += 1
    speaker.s2ag.result, speaker.s2ag.curves = "LAYER", "FRAMES"
    assert not cut(words)


def test_with_bones_by_hand(speaker, words):
    press(bpy.ops.s2ag.edit_bone_map)
    assert speaker.s2ag.bone_map and not cut(words)
    names = [words.get(readiness.label(part), readiness.label(part)) for part in bone_map_files.ORDER]
    assert not [one for name in names for one in Text(name).cut(subpanels._NAME_SHARE * CONTENT)]


def test_every_kind_of_gesture_is_whole(words):
    inside = CONTENT - 30  # the frame of the list and its scroller
    for label in (*menu_items.labels().values(), "Left", "Right", "Both"):
        assert not Text(words.get(label, label)).cut((1 - gesture_panel._WORD_SHARE) * inside)


def test_every_style_and_stage_is_whole(extension, words):
    styles = [words.get(name.capitalize(), name.capitalize()) for name in menu_items.style_names()]
    assert not Setting("", styles, True).cut(CONTENT)
    told = [words.get(text, text) for text in stages.SHOWN.values()]
    many = [words.get(text, text) for text in ("{stage}: {count} takes", "Writing take {number} of {count}")]
    told += [many[0].format(stage=text, count=24) for text in told] + [many[1].format(number=24, count=24)]
    assert not [one for text in told for one in Text(text).cut(CONTENT - 20)]


def test_what_does_not_fit_is_found():
    sheet = Measured()
    sheet.label(text="A sentence that is far too long for the sidebar of anybody", icon="INFO")
    row = sheet.row()
    for text in ("Right Upper Arm", "Left Upper Arm", "Both Forearms"):
        row.label(text=text)
    assert [text for text, _ in sheet.cut()] == [sheet.inside[0].text, "Right Upper Arm", "Left Upper Arm", "Both Forearms"]
    lines = menu_items.wrap_text("word " * 30)
    assert not sheet.cut(1000) and len(lines) > 3 and all(menu_items.text_width(line) <= menu_items.ROOM for line in lines)
