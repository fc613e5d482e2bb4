"""Small habits of the panel: marks from a menu, fingers in the bone map, subtypes, and what the bin deletes."""

import bpy
import pytest
from acted import drawn, press
from s2ag.core.words import hints
from s2ag.s2ag_blender.rig import readiness
from s2ag.s2ag_blender.ui import marks, panel, subpanels


@pytest.fixture
def figure(extension):
    bpy.ops.s2ag.add_mannequin()
    return bpy.context.view_layer.objects.active


def test_marks_are_written_where_the_words_are(figure):
    settings = figure.s2ag
    assert "s2ag.insert_mark" not in drawn(panel.S2AG_PT_gestures) and not bpy.ops.s2ag.insert_mark.poll()
    settings.transcript_source, settings.typed = "TYPED", "so I thought"
    assert "s2ag.insert_mark" in drawn(panel.S2AG_PT_gestures)
    press(bpy.ops.s2ag.insert_mark, mark="{question}")
    assert settings.typed == "so I thought {question}"
    settings.transcript_source, settings.transcript_block = "BLOCK", bpy.data.texts.new("words")
    settings.transcript_block.write("now ")
    press(bpy.ops.s2ag.insert_mark, mark="[pause]")
    assert settings.transcript_block.as_string().strip() == "now [pause]"


def test_every_mark_of_the_menu_is_one_that_transcripts_know():
    names = [name for name, *_ in marks.mark_items()]
    known = {f"{{{name}}}" for name in (*hints.HINTS, *hints.SIZES, *hints.REST, *hints.SIDES)}
    assert set(names) - known == {"*", "[pause]", "{as usual}"} and set(names) >= {f"{{{name}}}" for name in hints.HINTS}


def test_the_bone_map_names_the_fingers(figure):
    hands = readiness.readiness_of(figure).hands
    assert [row.part for row in hands] == ["left_fingers", "right_fingers"]
    assert all(row.found and len(row.bones) == 5 and set(row.bones) <= set(figure.data.bones.keys()) for row in hands)
    assert f"{hands[0].bones[0]} … {hands[0].bones[-1]}" in drawn(subpanels.S2AG_PT_bone_map)


def test_frames_and_factors_have_their_subtypes(figure):
    properties = figure.s2ag.bl_rna.properties
    assert {properties[name].subtype for name in ("start_frame", "blend_in", "blend_out")} == {"TIME"}
    for operator in (bpy.ops.s2ag.change_gesture, bpy.ops.s2ag.add_gesture, bpy.ops.s2ag.change_decision):
        assert operator.get_rna_type().properties["size"].subtype == "FACTOR"
