"""A seated character's hands come home to thighs or table, and nothing of an arm is in either; legs stay to the bit."""

from dataclasses import replace

import bpy
import found_rigs
import numpy as np
import people
import pytest
from bodies import performance
from s2ag.core import json_text
from s2ag.core.learning.evaluate import seated
from s2ag.core.motion import handshape, rest, skeleton
from s2ag.core.motion.hands import Hands
from s2ag.core.motion.motion import Motion
from s2ag.core.synthesis.idling import idle
from s2ag.rigs.goals import Options
from s2ag.rigs.proportions import SIDES, ArmOrigin
from s2ag.s2ag_blender import compat, program
from s2ag.s2ag_blender.characters import mannequin
from s2ag.s2ag_blender.keys.apply import apply_motion
from s2ag.s2ag_blender.render import seated_trial
from s2ag.s2ag_blender.render.seated_trial import Sitter
from s2ag.s2ag_blender.rig import body_shape, solver

pytestmark = pytest.mark.slow

WHO = {"mannequin": lambda shared: mannequin.build().armature, "human": lambda shared: people.armature("mixamo")}
WHO["rocketbox"] = lambda shared: found_rigs.rocketbox(shared, "Male_Adult_01")
SECONDS = 6


def low_hands():
    """Somebody who waits, whose weight shifts, and somebody who waves about, without hands of their own."""
    return idle(SECONDS, seed=3), Motion(performance(15 * SECONDS, size=0.3), fps=15.0)


def seat(sitter, **about):
    trunk = body_shape.read_trunk(sitter.item, sitter.bones, sitter.mapping)
    return solver.find_seat(sitter.item, sitter.bones, sitter.mapping, Options(**about), trunk)


def keyed(item, motion, **about):
    bpy.context.scene.render.fps = 15
    return apply_motion(item, motion, 1, options=Options(**about))


@pytest.mark.parametrize("who", WHO)
@pytest.mark.parametrize("table", [0.0, 0.2])
def test_hands_come_home_and_stay_out_of_thighs_and_table(shared, who, table):
    sitter = Sitter(WHO[who](shared))
    hips, before = sitter.hips(), sitter.posed()
    high = float(hips[2] + table) if table else 0.0
    edge = sitter.edge(high)
    for motion in low_hands():
        action = keyed(sitter.item, motion, table=high)
        legs = {f'"{sitter.bones.names[row]}"' for row in sitter.legs.rows()}
        assert not [curve for curve in compat.curves(action) if any(name in curve.data_path for name in legs)]
        lowest = []
        for frame in range(1, 15 * SECONDS, 11):
            depths, places = sitter.depth(frame)
            hands = places["hands"]
            assert depths["hands"] < 0.01, f"{1000 * depths['hands']:.0f} mm at frame {frame}"
            assert np.array_equal(sitter.posed(), before)
            lowest.append(hands[:, 2].min() - hips[2])
            over = hands[hips[1] - hands[:, 1] > edge, 2] if table else ()
            assert not len(over) or over.min() > high - 0.01, f"{over.min() - high:.3f} m at frame {frame}"
        if motion.pelvis is not None:  # who waits has the hands on thighs or table
            assert np.median(lowest) < table + 0.16


@pytest.mark.parametrize("who", WHO)
def test_forearms_of_arms_bent_close_to_the_trunk_stay_above_a_table(shared, who):
    """Elbows that hang to its top beyond its edge turn aside, but do not fly up to the shoulders."""
    sitter = Sitter(WHO[who](shared))
    arms = [[sitter.mapping.chains[f"{side}_{part}"][0] for part in ("upper_arm", "forearm")] for side in SIDES]
    shoulder, elbow = (sitter.item.matrix_world @ sitter.item.pose.bones[name].head for name in arms[0])
    high, bent = shoulder.z - 0.72 * (shoulder - elbow).length, rest.REST.copy()
    edge = sitter.edge(high)
    for (upper, fore), sign in zip(skeleton.ARMS, (1, -1), strict=True):
        bent[upper], bent[fore] = skeleton.normalize(np.array([[0.05 * sign, 1.0, 0.9], [-0.8 * sign, -0.5, 0.1]]))
    keyed(sitter.item, Motion(np.repeat(skeleton.normalize(bent)[None], 30, 0).astype(np.float32), fps=15.0), table=high)
    skin = sitter.depth(10)[1]["forearms"]
    assert np.minimum(high - skin[:, 2], sitter.ahead(skin) - edge).max() < 0.01
    for names in arms:
        shoulder, elbow = places(sitter.item, names, [10])[0]
        assert (shoulder - elbow)[2] > 0.5 * np.linalg.norm(shoulder - elbow)


@pytest.mark.parametrize("who", WHO)
def test_hands_that_lie_on_a_table_do_not_touch(shared, who):
    """Else they are thrown up to get past each other when somebody moves them a little inwards."""
    sitter = Sitter(WHO[who](shared))
    found, placed = seat(sitter, table=float(sitter.hips()[2] + 0.2)), ArmOrigin(sitter.bones, sitter.mapping)
    for side, sign in SIDES.items():
        upper, fore, hand = placed.lengths[side]
        wrist, way = found.home(side, found.turn @ placed.shoulders[side], upper + fore)
        assert sign * wrist[0] > sign * (wrist + hand * skeleton.normalize(way))[0] > 0.05 * hand


def test_who_stands_or_is_told_to_stand_lets_the_hands_hang(shared):
    motion, item = low_hands()[0], mannequin.build().armature
    keyed(item, motion)
    standing = item.animation_data.action
    sitter = Sitter(item)

    assert seat(sitter) and seat(sitter, table=0.9).table is not None and seat(sitter, seated="OFF") is None
    for leg in sitter.legs.pair:
        sitter.turn(leg.thigh, sitter.left, 60.0)
    assert seat(sitter) is None and seat(sitter, seated="ON")
    upright = [bone for bone in item.pose.bones if bone.name in {sitter.bones.names[row] for row in sitter.legs.rows()}]
    for bone in upright:
        bone.matrix_basis.identity()
    again = keyed(item, motion, seated="OFF")
    curves = {(curve.data_path, curve.array_index): curve.evaluate(20) for curve in compat.curves(standing)}
    assert curves == {(curve.data_path, curve.array_index): curve.evaluate(20) for curve in compat.curves(again)}


def test_the_trial_sees_what_lies_in_a_thigh_and_in_a_table():
    sitter = Sitter(mannequin.build().armature)
    sitter.depth(1)
    (skin,) = [one for one in sitter._skins if one.faces]
    thighs = seated_trial.surface(skin.places()[skin.thighs], skin.faces)
    leg = sitter.legs.pair[0]
    ends = [np.array(sitter.item.pose.bones[sitter.bones.names[row]].head) for row in (leg.thigh, leg.shin)]
    middle = np.mean(ends, axis=0)
    assert seated_trial.depth(*thighs, middle[None]) > 0.04
    assert seated_trial.depth(*thighs, middle[None] + [[0, 0, 0.3]]) == 0
    beside = sitter.hips() + 0.28 * sitter.left + [0, 0, 0.1]  # 4 cm below the top of an arm rest, and from either side
    assert sitter.in_rests(np.array([beside, sitter.hips()]), float(sitter.hips()[2]) + 0.14) == pytest.approx(0.04, abs=0.001)

    hanging = keyed(sitter.item, low_hands()[0], seated="OFF")
    high = float(sitter.hips()[2]) + 0.2
    assert hanging and min(hand[2] for hand in sitter.depth(20)[1]["hands"]) < high - 0.1


def test_a_trial_tells_of_idle_and_talk_on_a_chair_and_at_a_table(voice, tmp_path):
    def run(module, job, progress):
        told = []
        return seated_trial.perform(json_text.read(job), program.EventWriter(told.append))

    rows = seated.trial(["mannequin"], [voice], run, seconds=3.0, keep=tmp_path)
    kinds, places = ("idle", "listen", "talk"), ("no table", "arm rests", "a table")
    assert [(row.at, row.kind) for row in rows] == [(at, kind) for at in places for kind in kinds]
    assert all(row.reached() and 29 <= len(row.depths["hands in table"]) <= 31 for row in rows)
    assert len(list(tmp_path.glob("mannequin-*.blend"))) == 9
    assert "reached by all" in seated.page(rows) and "| mannequin | talk | a table |" in seated.page(rows)
    high = rows[3].depths["forearms in arm rest"] + 0.02
    assert not replace(rows[3], depths={**rows[3].depths, "forearms in arm rest": high}).reached()
    deep = replace(rows[0], depths={**rows[0].depths, "hands in thigh": np.array([0.002, 0.02])})
    assert "20.0 mm, 50.00% deeper than 10" in seated.page([deep]) and "missed by mannequin (idle)" in seated.page([deep])


@pytest.mark.parametrize("who", WHO)
def test_arms_that_fall_at_a_table_are_laid_no_faster_than_they_fall(shared, who):
    """Hands that drop from wide gestures were snatched to the table within two frames."""
    rates = {}
    down = np.interp(np.arange(60) / 24, (1.0, 1.4), (0.0, 1.0))
    for table in (0.0, 0.2):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        sitter = Sitter(WHO[who](shared))
        high = float(sitter.hips()[2] + table) if table else 0.0
        motion = falling(3 * down**2 - 2 * down**3)
        bpy.context.scene.render.fps = 24
        about = Options(table=high) if table else Options(seated="OFF")
        apply_motion(sitter.item, motion, 1, options=about)
        wrists = [sitter.mapping.chains[f"{side}_hand"][0] for side in SIDES]
        rates[table] = np.linalg.norm(np.diff(places(sitter.item, wrists, range(1, 61)), axis=0), axis=-1).max() * 24
    assert rates[0.2] < 1.1 * rates[0.0], rates


def falling(down):
    """Arms that are held wide, forearms level, and come ``down`` (frames,) to where they hang."""
    wide = rest.REST.copy()
    for (upper, fore), sign in zip(skeleton.ARMS, (1, -1), strict=True):
        wide[upper], wide[fore] = skeleton.normalize(np.array([[0.7 * sign, 0.7, 0.2], [0.8 * sign, -0.1, 0.6]]))
    mixed = wide + down[:, None, None] * (rest.REST - wide)
    return Motion(skeleton.normalize(mixed).astype(np.float32), fps=24.0)


def places(item, names, frames):
    """Heads of bones in the scene on these frames."""
    found = []
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        found.append([item.matrix_world @ item.pose.bones[name].head for name in names])
    return np.array(found)


@pytest.mark.parametrize("who", WHO)
def test_fingertips_that_reach_beyond_a_tables_edge_stay_above(shared, who):
    """Hands are drawn back over the edge, a second at each place, so that at last only one finger is beyond it."""
    sitter = Sitter(WHO[who](shared))
    high, back = float(sitter.hips()[2] + 0.2), np.repeat(np.linspace(0.8, 1.8, 21), 15)
    edge, drawn = sitter.edge(high), np.repeat(rest.REST[None], len(back), 0)
    for (upper, fore), sign in zip(skeleton.ARMS, (1, -1), strict=True):
        drawn[:, upper] = np.stack([np.full_like(back, 0.1 * sign), np.ones_like(back), 0.6 - back], -1)
        drawn[:, fore] = [0.1 * sign, -0.2, 1.0]
    knuckles, palms = (np.broadcast_to(way, (len(back), 2, 3)) for way in ([0.0, 0.6, 0.8], [0.0, 0.8, -0.6]))
    shape = np.where([name.startswith("middle") for name in handshape.COLUMNS], 0.0, 80.0)
    hands = Hands.of(knuckles, palms, np.broadcast_to(shape, (len(back), 2, 12)))
    keyed(sitter.item, Motion(skeleton.normalize(drawn).astype(np.float32), fps=15.0, hands=hands), table=high)
    skins = [sitter.depth(frame)[1]["hands"] for frame in range(8, len(back), 15)]
    assert max(np.minimum(high - skin[:, 2], sitter.ahead(skin) - edge).max() for skin in skins) < 0.01
