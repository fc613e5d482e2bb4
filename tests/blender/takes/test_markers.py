"""Words on the timeline."""

import bpy
from s2ag.s2ag_blender.takes import markers

WORDS = (("so", 0.0, 0.2), ("give", 0.5, 0.7), ("me", 1.0, 1.1), ("time", 2.0, 2.4))


def names(scene):
    return [(marker.name, marker.frame) for marker in scene.timeline_markers]


def test_one_marker_a_word_at_its_start():
    scene = bpy.context.scene
    scene.render.fps = 24
    assert markers.add(scene, WORDS, 10, "w:", 10) == 4
    assert names(scene) == [("w:so", 10), ("w:give", 22), ("w:me", 34), ("w:time", 58)]


def test_the_same_words_again_do_not_pile_up():
    scene = bpy.context.scene
    for _ in range(2):
        markers.add(scene, WORDS, 10, "w:", 10)
    assert len(names(scene)) == 4


def test_markers_of_others_and_of_other_lines_stay():
    scene = bpy.context.scene
    scene.timeline_markers.new("cut", frame=22)
    markers.add(scene, WORDS, 10, "w:", 10)
    markers.add(scene, WORDS[:1], 200, "w:", 200)
    markers.add(scene, WORDS, 10, "anna:", 10)
    assert len(names(scene)) == 10
    assert markers.remove(scene, "w:") == 5 and ("cut", 22) in names(scene) and len(names(scene)) == 5
    assert markers.remove(scene, "") == 0 and len(names(scene)) == 5


def test_only_the_chosen_frames_are_marked():
    scene = bpy.context.scene
    scene.render.fps = 24
    assert markers.add(scene, WORDS, 10, "w:", 20, 40) == 2
    assert names(scene) == [("w:give", 22), ("w:me", 34)]
    assert markers.add(scene, (), 10, "w:", 1) == 0
