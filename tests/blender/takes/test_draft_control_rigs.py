"""Drafts on a control rig: next to the take that is made at the end."""

import bpy
import found_rigs
import pytest
from acted import apart, pose, settle
from s2ag.s2ag_blender.rig import reading
from s2ag.s2ag_blender.takes import drafts, engine_requests, generate

pytestmark = pytest.mark.slow


@pytest.fixture
def actor(extension, rigify_saved, engine, examples):
    """The control rig with ten seconds of speech, and a warm engine."""
    item = found_rigs.opened(rigify_saved[1])
    bpy.context.view_layer.objects.active = item
    item.s2ag.audio, item.s2ag.range, item.s2ag.curves = str(examples / "hello.flac"), "SCENE", "FRAMES"
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 240
    engine_requests.engine(bpy.context).call("hello", {"warm": True})
    yield item
    bpy.context.window_manager.s2ag.live = False


def test_a_draft_is_next_to_the_take(actor):
    mapping = reading.resolve_mapping(actor, reading.read(actor))
    seen = [name for chain in mapping.chains.values() for name in chain] + ["DEF-forearm.L", "DEF-hand.R", "DEF-spine.003"]

    def shown():
        return [{name: found[name] for name in seen} for found in (pose(actor, frame) for frame in (5, 47, 101, 163, 222))]

    planned = generate.plan(bpy.context, actor, draft=True)
    result = engine_requests.call(bpy.context, planned.params)
    generate.finish(planned, result)
    drafted = shown()
    drafts.drop(actor)
    generate.finish(generate.plan(bpy.context, actor), result)
    assert max(apart(one, other) for one, other in zip(drafted, shown(), strict=True)) < 1.5


def test_the_switches_of_the_rig_come_back_with_the_draft(actor):
    parent = actor.pose.bones["upper_arm_parent.L"]
    parent["IK_FK"] = 0.0
    stood = pose(actor, 30)
    bpy.context.window_manager.s2ag.live = True
    settle()
    assert apart(stood, pose(actor, 30)) > 5 and parent["IK_FK"] == 1.0
    actor.s2ag.intensity = 0.7
    settle()
    bpy.context.window_manager.s2ag.live = False
    assert parent["IK_FK"] == 0.0 and not bpy.data.actions and apart(stood, pose(actor, 30)) < 0.1
