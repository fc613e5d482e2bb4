"""People of chance, of whose films the capture learns: whole, skinned, and each another."""

import bpy
import numpy as np
import pytest
from s2ag.core.motion.skeleton import EDGE_NAMES
from s2ag.s2ag_blender.render import capture_people
from s2ag.s2ag_blender.rig import reading

pytest.importorskip("anny")


def test_people_of_chance_are_skinned_and_each_another():
    arms, heights = set(), set()
    for number in (0, 1, 5):
        armature = capture_people.build(number)
        mapping = reading.resolve_mapping(armature, reading.read(armature))
        assert set(EDGE_NAMES) <= set(mapping.chains)
        arms.add(round(armature.data.bones[mapping.chains["left_forearm"][0]].length, 4))
        meshes = [item for item in bpy.data.objects if item.type == "MESH"]
        assert {"Skin", "Clothes"} <= {item.name for item in meshes}
        for item in meshes:
            assert all(abs(sum(group.weight for group in one.groups) - 1) < 0.03 for one in item.data.vertices), item.name
        skin = np.array([one.co for one in bpy.data.objects["Skin"].data.vertices])
        assert abs(skin[:, 2].min()) < 1e-3
        heights.add(round(float(skin[:, 2].max()), 3))
    assert len(arms) == len(heights) == 3
