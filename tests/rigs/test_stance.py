"""Weight that goes from foot to foot: feet stay, knees bend forwards, trunk and arms do as without."""

import handed
import numpy as np
import pytest
from bodies import BACKWARDS, Y_UP, degrees, performance, pose, turned_degrees
from s2ag.core.motion.pelvis import Pelvis
from s2ag.rigs import legs, stance
from s2ag.rigs.family import families
from s2ag.rigs.goals import Goals, Options
from s2ag.rigs.retarget import rotations
from s2ag.rigs.skeleton import character_frame
from skeletons import person

FAMILIES = {family.key: family for family in families()}
TALL = 0.93
"""Metres: the hips of the test's person."""


def stood(body, pelvis=None, frame=None, seed=3):
    """Bones, legs, goals and posed heads and orientations of a body, with ``pelvis`` or without."""
    body = body if frame is None else body.turned(frame)
    bones = body.bones(seed)
    own = character_frame(bones, body.mapping)
    found = legs.find(bones, body.mapping, own[2])
    goals = Goals(bones, body.mapping, performance(), options=Options(clear_body=False), pelvis=pelvis, legs=found)
    return bones, found, goals, *pose(bones, rotations(goals), goals.stood.places if goals.stood else None)


@pytest.mark.parametrize("frame", [None, Y_UP, BACKWARDS, Y_UP @ BACKWARDS], ids=["z-up", "y-up", "back", "y-up back"])
@pytest.mark.parametrize("key", ["mixamo", "unreal", "mpfb_default", "daz_genesis8", "vrm", "biped"])
def test_feet_stay_and_the_rest_does_as_without(key, frame):
    body = person(FAMILIES[key])
    pelvis = handed.pelvis(len(performance()))
    bones, found, goals, heads, turns = stood(body, pelvis, frame)
    _, _, _, plain, upright = stood(body, None, frame)
    assert [bones.names[leg.thigh] for leg in found.pair] == ["leg_left_0", "leg_right_0"]
    assert [bones.names[leg.foot] for leg in found.pair] == ["leg_left_2", "leg_right_2"]
    for leg in found.pair:
        below = [leg.foot, *(row for row in range(len(bones.names)) if leg.foot in bones.ancestors(row))]
        np.testing.assert_allclose(heads[:, below], np.tile(bones.heads[below], (len(heads), 1, 1)), atol=1e-6)
        assert turned_degrees(turns[:, leg.foot], bones.matrices[leg.foot, :3, :3]).max() < 1e-4
        hip, knee, ankle = (heads[:, row] for row in (leg.thigh, leg.shin, leg.foot))
        ahead = np.sum(((knee - hip) - 0.5 * (ankle - hip)) * -goals.frame[1], -1)
        assert (ahead > 0).all()
        for a, b in ((leg.thigh, leg.shin), (leg.shin, leg.foot)):
            length = np.linalg.norm(bones.heads[a] - bones.heads[b])
            np.testing.assert_allclose(np.linalg.norm(heads[:, a] - heads[:, b], axis=-1), length, atol=1e-6)
    upper = [bones.row(name) for part, chain in body.chains.items() for name in chain[-1:] if part != "torso" and name]
    assert turned_degrees(turns[:, upper], upright[:, upper]).max() < 1e-4  # arms and head are turned as without


@pytest.mark.parametrize("frame", [None, Y_UP @ BACKWARDS], ids=["z-up", "y-up back"])
def test_how_thighs_lean_is_told_as_seen_from_the_waist(frame):
    """So that hands that hang go with them: sidewards half-way down the thighs to a tenth, else to a half, as knees bend."""
    bones, found, goals, heads, _ = stood(person(FAMILIES["mixamo"]), handed.pelvis(len(performance())), frame)
    up, waist = goals.frame[2], bones.row(person(FAMILIES["mixamo"]).chains["torso"][0])
    middle, rest = (
        np.mean([heads[..., row, :] for leg in found.pair for row in (leg.thigh, leg.shin)], 0)
        for heads in (heads, bones.heads)
    )
    moved = (middle - heads[:, waist]) - (rest - bones.heads[waist])
    told = goals.stood.slope * ((bones.heads[waist] - rest) @ up)
    for axis, share in ((goals.frame[0], 0.1), (goals.frame[1], 0.5)):
        assert np.abs((moved - told) @ axis).max() < share * np.abs(moved @ axis).max()


def test_the_hips_go_where_the_pelvis_says():
    """As far as legs reach: what is asked sidewards and forwards comes whole, and they sink by no more than they must."""
    pelvis = handed.pelvis(len(performance()))
    bones, found, _, heads, _ = stood(person(FAMILIES["mixamo"]), pelvis)
    hips = np.mean([heads[:, leg.thigh] for leg in found.pair], 0) - np.mean([bones.heads[leg.thigh] for leg in found.pair], 0)
    tall = stance.height(bones, found, np.array([0, 0, 1.0]))
    assert tall == pytest.approx(TALL, abs=0.03)
    np.testing.assert_allclose(hips[:, 0], -tall * pelvis.place[:, 0], atol=1e-5)
    np.testing.assert_allclose(hips[:, 1], -tall * pelvis.place[:, 2], atol=1e-5)
    sunk = -tall * pelvis.place[:, 1] - hips[:, 2]
    assert (sunk > 0).all() and sunk.max() < 0.02


def test_no_departure_is_the_rest_pose_and_a_little_is_little():
    count = len(performance())
    _, _, goals, _, _ = stood(person(FAMILIES["mixamo"]), Pelvis(np.zeros((count, 3)), np.zeros((count, 3))))
    for turn in goals.stood.turned.values():
        np.testing.assert_allclose(turn, np.tile([1, 0, 0, 0], (count, 1)), atol=1e-6)
    np.testing.assert_allclose(next(iter(goals.stood.places.values())), 0, atol=1e-6)
    place = np.linspace(0, 0.05, count)[:, None] * [1, 0, 0]
    _, _, goals, _, _ = stood(person(FAMILIES["mixamo"]), Pelvis(place, 0 * place))
    for turn in goals.stood.turned.values():
        assert np.degrees(2 * np.linalg.norm(np.diff(turn, axis=0), axis=-1)).max() < 2.0


def test_without_a_spine_the_pelvis_does_not_turn():
    body = person(FAMILIES["mixamo"])
    body = type(body)(body.joints, {part: chain for part, chain in body.chains.items() if part != "torso"}, body.hips)
    bones, found, goals, heads, turns = stood(body, handed.pelvis(len(performance())))
    assert turned_degrees(turns[:, found.pelvis], bones.matrices[found.pelvis, :3, :3]).max() < 1e-4
    assert np.ptp(heads[:, found.pelvis], axis=0).max() > 0.05


def test_what_has_no_legs_stays():
    bones, found, goals, _, _ = stood(person(FAMILIES["mixamo"], legs=False), handed.pelvis(len(performance())))
    assert found is None and goals.stood is None


@pytest.mark.parametrize("key", FAMILIES)
def test_legs_are_found_on_every_family(key):
    body = person(FAMILIES[key])
    bones = body.bones(1)
    found = legs.find(bones, body.mapping, character_frame(bones, body.mapping)[2])
    assert {bones.names[leg.shin] for leg in found.pair} == {"leg_left_1", "leg_right_1"}
    assert degrees(bones.heads[found.pelvis][None], np.array([[0, 0, 1.0]])).max() < 10 or found.pelvis == 0
