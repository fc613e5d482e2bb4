import bpy
import numpy as np
import pytest
import rigging
from bodies import degrees, performance
from s2ag.core.motion import skeleton
from s2ag.core.motion.motion import Motion
from s2ag.rigs import bvh
from s2ag.s2ag_blender.keys.apply import apply_motion
from s2ag.s2ag_blender.rig import reading

ENDS = {
    "torso": "Neck",
    "neck": "Head",
    "left_clavicle": "LeftArm",
    "left_upper_arm": "LeftForeArm",
    "left_forearm": "LeftHand",
}
ENDS |= {edge.replace("left", "right"): end.replace("Left", "Right") for edge, end in ENDS.items()}
PAIRS = {edge: (start, ENDS[edge]) for edge, start in bvh.JOINT_OF_EDGE.items() if edge in ENDS}


@pytest.fixture
def imported(tmp_path):
    """A motion, and the armature that Blender's own importer makes of its BVH file."""
    motion = Motion(performance(40, size=1.2), 24.0)
    bvh.save(motion, tmp_path / "take.bvh")
    bpy.ops.import_anim.bvh(filepath=str(tmp_path / "take.bvh"))
    return motion, bpy.context.object


def test_blenders_importer_shows_the_same_directions(imported, record_property):
    motion, item = imported
    frames = range(0, 40, 3)
    found = rigging.directions(item, PAIRS, [1 + frame for frame in frames])
    world = np.array(item.matrix_world)[:3, :3]
    assert len(found) == 8
    for edge, along in found.items():
        wanted = rigging.in_blender(motion.directions[list(frames), skeleton.EDGE_NAMES.index(edge)])
        error = degrees(along @ world.T, wanted).max()
        record_property(edge, float(error))
        assert error < 0.01
    rest = np.array(item.data.bones["Head"].tail_local - item.data.bones["Head"].head_local)
    crown = rigging.turned(item, "Head", [1 + frame for frame in frames]) @ rest @ world.T
    assert degrees(crown, rigging.in_blender(motion.directions[list(frames), 2])).max() < 0.01


def test_an_imported_file_can_be_gestured_with_again(imported):
    _, item = imported
    mapping = reading.resolve_mapping(item, reading.read(item))
    assert mapping.family == "mixamo" and mapping.warnings == ()
    again = Motion(performance(20, seed=9), 24.0)
    apply_motion(item, again, 1)
    pairs = {edge: PAIRS[edge] for edge in ("left_upper_arm", "right_forearm")}
    found = rigging.directions(item, pairs, [1, 10, 20])
    frame = np.array(item.matrix_world)[:3, :3]
    for edge, along in found.items():
        wanted = rigging.in_blender(again.directions[[0, 9, 19], skeleton.EDGE_NAMES.index(edge)])
        assert degrees(along @ frame.T, wanted).max() < 0.01
