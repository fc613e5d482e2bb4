"""Keys a second: whole arrays at once against Blender's own call for each key; and a minute of motion onto a rig."""

import numpy as np
import pytest
from bodies import body, performance
from s2ag.core.motion import quaternion
from s2ag.core.motion.motion import Motion

bpy = pytest.importorskip("bpy")
pytest.importorskip("pytest_benchmark")

import rigging  # noqa: E402
from s2ag.s2ag_blender.keys import keyframes  # noqa: E402
from s2ag.s2ag_blender.keys.apply import apply_motion  # noqa: E402

FRAMES = 300
BONES = 10


@pytest.fixture
def rig():
    """An empty file with a rig, and rotations for ten of its bones."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    item = rigging.make_armature(body())
    steps = np.random.default_rng(0).normal(size=(FRAMES, BONES, 4)).cumsum(0) + [30.0, 0, 0, 0]
    steps /= np.linalg.norm(steps, axis=-1, keepdims=True)
    names = [bone.name for bone in item.pose.bones][:BONES]
    return item, {name: quaternion.continuous(steps[:, column]) for column, name in enumerate(names)}


def report(benchmark, keys):
    benchmark.extra_info["keys"] = keys
    benchmark.extra_info["keys_per_second"] = round(keys / benchmark.stats.stats.median)
    print(f"\n{benchmark.name}: {benchmark.extra_info['keys_per_second']:,} keys a second")


def test_bulk_keys(benchmark, rig):
    item, rotations = rig
    benchmark.pedantic(keyframes.write_action, ("bulk", item, rotations, np.arange(FRAMES)), rounds=5, warmup_rounds=1)
    report(benchmark, FRAMES * BONES * 4)


def test_keyframe_insert(benchmark, rig):
    item, rotations = rig

    def insert():
        item.animation_data_clear()
        for name, values in rotations.items():
            bone = item.pose.bones[name]
            for frame, rotation in enumerate(values):
                bone.rotation_quaternion = rotation
                bone.keyframe_insert("rotation_quaternion", frame=frame)

    benchmark.pedantic(insert, rounds=3, warmup_rounds=1)
    report(benchmark, FRAMES * BONES * 4)


def test_a_minute_onto_a_rig(benchmark, rig):
    """Everything from the motion to the keys: resampling to 24 frames a second, retargeting, curves."""
    item, _ = rig
    motion = Motion(performance(900))
    chains = body().chains
    action = benchmark.pedantic(apply_motion, (item, motion, 1), {"mapping": chains}, rounds=5, warmup_rounds=1)
    bones = sum(len(chain) for part, chain in chains.items() if not part.endswith("hand"))
    report(benchmark, int(action.frame_range[1]) * bones * 4)
