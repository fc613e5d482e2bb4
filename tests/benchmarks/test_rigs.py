"""Frame-joints a second of the formula for plain skeletons; and what a frame costs where bones must be measured."""

import time

import handed
import numpy as np
import pytest
from bodies import body, performance
from hands import with_hands
from s2ag.core.motion.motion import Motion
from s2ag.core.motion.skeleton import EDGE_NAMES
from s2ag.rigs.goals import Goals
from s2ag.rigs.retarget import rotations
from solved import solve

pytest.importorskip("pytest_benchmark")

FRAMES = 900


@pytest.mark.benchmark(timer=time.process_time)  # a rate of the code, not of what else the machine does
def test_plain_solver(benchmark):
    """A minute at the motion's rate, all parts of the goals included: at least 100,000 frame-joints a second."""
    whole, motion = body(), performance(FRAMES)
    bones = whole.bones()
    result = benchmark.pedantic(solve, (bones, whole.mapping, motion), rounds=7, warmup_rounds=1)
    joints = FRAMES * sum(len(chain) for part, chain in whole.chains.items() if part in EDGE_NAMES)
    rate = joints / benchmark.stats.stats.median
    benchmark.extra_info |= {"frame_joints": joints, "frame_joints_per_second": round(rate)}
    print(f"\n{benchmark.name}: {rate:,.0f} frame-joints a second, {len(result)} bones")
    assert rate > 100_000


def test_hands_cost_at_most_as_much_as_the_rest(benchmark):
    """A minute onto a rig with fingers that the motion has, beside the same arms without: processor time.

    Hands come near to the trunk, as a talker's do, and now and then to each other; a walk of twice that size, whose hands
    lie in each other in a quarter of its frames, is no talker's.
    """
    motion, plain, whole = performance(FRAMES, size=0.4), body(), with_hands()

    def solved(figure, bones, hands):
        goals = Goals(bones, figure.mapping, motion, hands=hands)
        return rotations(goals) | goals.extras()

    def least(*arguments):
        times = []
        for _ in range(7):
            started = time.process_time()
            found = solved(*arguments)
            times.append(time.process_time() - started)
        return min(times), len(found)

    without, few = least(plain, plain.bones(), None)
    taken, many = least(whole, whole.bones(), handed.hands(motion))
    benchmark.pedantic(solved, args=(whole, whole.bones(), handed.hands(motion)), rounds=3)
    print(f"\n{many} bones with hands and fingers: {taken / without:.2f} times the processor time of {few} without")
    assert many > few + 25 and taken < 2 * without


def test_control_rig_solver(benchmark, tmp_path):
    """A frame of Rigify's human: everything from reading the rig to its keys, beside one evaluation of the rig as it is."""
    bpy = pytest.importorskip("bpy")
    import found_rigs
    import rigify_files
    from s2ag.s2ag_blender.keys.apply import apply_motion
    from s2ag.s2ag_blender.rig import controls

    item = found_rigs.opened(rigify_files.build(tmp_path)[1])
    bone, layer, updates = item.pose.bones["upper_arm_fk.L"], bpy.context.view_layer, []
    for turn in range(60):
        started = time.perf_counter()
        bone.rotation_quaternion = (1, 0.001 * turn, 0, 0)
        layer.update()
        updates.append(time.perf_counter() - started)
    bone.rotation_quaternion = (1, 0, 0, 0)
    update, motion = float(np.median(updates[10:])), Motion(performance(FRAMES // 6))
    evaluations, pose = [], controls.RigCopy.pose

    def counted(self, *arguments):
        evaluations.append(1)
        pose(self, *arguments)

    controls.RigCopy.pose = counted
    try:
        benchmark.pedantic(apply_motion, (item, motion, 1), {"report": print}, rounds=3)
    finally:
        controls.RigCopy.pose = pose
    frame = benchmark.stats.stats.median / len(motion.directions)
    benchmark.extra_info |= {
        "bones": len(item.data.bones),
        "milliseconds_per_frame": round(1e3 * frame, 2),
        "milliseconds_per_update": round(1e3 * update, 2),
        "evaluations_per_frame": round(len(evaluations) / 3 / len(motion.directions), 2),
    }
    print(f"\n{benchmark.name}: {benchmark.extra_info}")
