"""What is directed is there, what is not touched stays to the bit, and the same edits give the same take."""

import random
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from s2ag.core.editing import frame_ranges, gestures, provenance, regeneration, stroke_core, take_edits, targets
from s2ag.core.editing.director import Director
from s2ag.core.errors import UsageError
from s2ag.core.motion import skeleton
from s2ag.core.synthesis.session import Request, Session
from s2ag.core.synthesis.stages import Stages


@pytest.fixture(scope="module")
def request_(examples):
    return Request(examples / "hello.flac", transcript=examples / "hello.txt", seed=2, hands=1.0, stance=1.0)


@pytest.fixture
def after(director, request_):
    """The take after edits, and its warnings."""

    def run(*edits):
        result = director.direct(request_, list(edits))
        return result.motions[0], result.warnings

    return run


def touched(before, motion):
    """Frames in which anything differs."""
    parts = [motion.directions != before.directions, motion.pelvis.place != before.pelvis.place]
    parts += [getattr(motion.hands, name) != getattr(before.hands, name) for name in ("knuckles", "palms", "shape")]
    return np.flatnonzero(np.any([part.reshape(len(part), -1).any(1) for part in parts], axis=0))


def within(before, motion, *times, room=2.5):
    frames = touched(before, motion) / skeleton.FPS
    assert len(frames)
    assert min(times) - room < frames.min() and frames.max() < max(times) + room


def middle(base, hand=None):
    """A gesture with neighbours on both sides."""
    found = gestures.find_gestures(base)[2:-2]
    return max((one for one in found if hand in (None, one.hand)), key=lambda one: one.size)


def test_no_edits_are_the_take_itself(director, request_, base):
    plain = Session(cache="off").synthesize(request_).motions[0]
    assert not len(touched(plain, base))
    assert "edits" not in base.meta


@pytest.mark.parametrize("by", [-0.3, 0.3])
def test_a_moved_stroke_lands_where_it_was_moved_to(after, base, by):
    one = middle(base)
    motion, _ = after({"do": "move", "at": one.at, "to": one.at + by})
    assert targets.StrokeTarget(one.at + by, one.hand, one.size).miss(motion) <= 1
    within(base, motion, one.at, one.at + by)


def test_a_deleted_stroke_is_gone(after, base):
    found = gestures.find_gestures(base)[2:-2]
    one = sorted(found, key=lambda one: one.size)[len(found) // 2]
    motion, _ = after({"do": "delete", "at": one.at})
    left = gestures.nearest_of(gestures.find_gestures(motion), one.at, 0.2)
    assert left is None or left.size < 0.5 * one.size
    within(base, motion, one.at)


def test_a_deletion_leaves_the_strokes_beside_it_where_they_are(after, base):
    """Those with a second around them that is nobody else's: what is beside them is not touched at all."""
    found = gestures.find_gestures(base)
    lone = [one for before, one, later in zip(found, found[1:], found[2:], strict=False)
            if before.hold < one.stroke - 0.2 and later.stroke > one.hold + 0.2]  # fmt: skip
    assert lone
    moved = []
    for one in lone:
        motion, _ = after({"do": "delete", "at": one.at})
        stayed = [
            gestures.nearest_of(gestures.find_gestures(motion), other.at, targets.LANDS) for other in found if other is not one
        ]
        moved.append(stayed.count(None))
    assert np.mean(moved) <= 1 and max(moved) <= 2, moved


@pytest.mark.slow
def test_a_phrase_is_performed_once_however_often_a_stroke_is_tried(director, request_, base, monkeypatch):
    performed, real = [], regeneration.Regenerator._generate
    monkeypatch.setattr(regeneration.Regenerator, "_generate", lambda *given: performed.append(1) or real(*given))
    found = gestures.find_gestures(base)[2:-2]
    for one in found:
        for asked in ({"size": 0.6}, {"hand": "left"}):
            performed.clear()
            director.direct(request_, [{"do": "change", "at": one.at, **asked}])
            assert 1 <= len(performed) <= 2  # the second where others give way


def test_what_is_performed_once_is_bent_to_another_core(director, request_, base):
    filler = regeneration.Regenerator(director.session, request_, Stages(lambda stage, value: None, lambda: False))
    one, held = middle(base), np.zeros(len(base.directions), bool)
    core = stroke_core.core_at(base, one, one.at)
    places = [frame_ranges.range_around([], core.first, core.last, len(base.directions))]
    performed = regeneration.speed_excess(base, filler.fill(base, places, core, 7, held)[0], places)
    other = stroke_core.blend_core(stroke_core.scale_core(core, 0.7, one.hand), base.directions[core.frames - 8], 0.5)
    assert not np.array_equal(other.directions, core.directions)
    bent = filler.fill(base, places, other, 7, held, again=True)[0]
    assert np.array_equal(bent.directions[other.frames], other.directions)
    frames = touched(base, bent)
    assert places[0][0] <= frames.min() and frames.max() < places[0][1]
    assert regeneration.speed_excess(base, bent, places) < performed + 0.5  # led to it, not jumped
    jumped = filler.fill(base, places, core, 7, held, again=True)[0].directions.copy()
    jumped[other.frames] = other.directions
    sudden = replace(bent, directions=jumped)
    assert regeneration.speed_excess(base, bent, places) <= regeneration.speed_excess(base, sudden, places)


def test_a_core_takes_more_or_less_time_and_comes_later(base):
    one = middle(base)
    core = stroke_core.core_at(base, one, one.at)
    shorter, longer = (stroke_core.stretch_core(core, one.at, base, slower) for slower in (0.6, 1.5))
    assert len(shorter.directions) < len(core.directions) < len(longer.directions)
    fastest = [gestures.wrist_speeds(part.directions).max() for part in (shorter, core, longer)]
    assert fastest == sorted(fastest, reverse=True)
    later = stroke_core.stretch_core(core, one.at, base, 1.0, later=3 / skeleton.FPS)
    assert later.first == core.first + 3
    assert np.abs(later.directions[:, 3:] - core.directions[:, 3:]).max() < 1e-5


def test_a_larger_stroke_goes_farther_behind_as_well_as_before(base):
    one = middle(base)
    core = stroke_core.core_at(base, one, one.at)
    made = stroke_core.scale_core(core, 1.5, one.hand)
    away = np.linalg.norm(skeleton.wrists(made.directions) - skeleton.wrists(core.directions), axis=-1).max(1)
    assert min(away[0], away[-1]) > 0.3 * max(away[0], away[-1])


@pytest.mark.parametrize("hand", gestures.HANDS)
def test_the_hand_that_was_asked_for_does_it(after, base, hand):
    others = [one for one in gestures.find_gestures(base)[2:-2] if one.hand != hand][:6]
    had = 0
    for one in others:
        motion, warnings = after({"do": "change", "at": one.at, "hand": hand})
        found = gestures.nearest_of(gestures.find_gestures(motion), one.at, targets.LANDS)
        assert warnings or found.hand == hand
        had += found is not None and found.hand == hand
        within(base, motion, one.at)
    assert had >= len(others) - 1  # now and then neighbours leave no room, which is told


@pytest.mark.parametrize("size", [0.6, 1.3])
def test_sizes_are_had(after, base, size):
    one = middle(base)
    motion, _ = after({"do": "change", "at": one.at, "size": size})
    made = gestures.nearest_of(gestures.find_gestures(motion), one.at, targets.LANDS)
    assert abs(made.size / (size * one.size) - 1) <= targets.SIZE


@pytest.mark.parametrize("kind", ["shrug", "big", "refusal", "me", "beat"])
def test_gestures_are_added_at_a_time(after, base, kind):
    times = [one.at for one in gestures.find_gestures(base)]
    room = int(np.argmax(np.diff(times)))  # where neighbours leave none, a warning says so
    at = 0.5 * (times[room] + times[room + 1])
    motion, _ = after({"do": "add", "at": at, "kind": kind})
    one = gestures.nearest_of(gestures.find_gestures(motion), at, targets.LANDS)
    assert one is not None and one.kind == kind
    within(base, motion, at)


def test_gestures_are_added_at_a_word(after, base):
    word, start, end = base.words[8]
    motion, _ = after({"do": "add", "word": word, "kind": "big"})
    first = next((begin, until) for text, begin, until in base.words if text == word)
    at = first[0] + 0.4 * (first[1] - first[0])
    assert gestures.nearest_of(gestures.find_gestures(motion), at, targets.LANDS).kind == "big"


def test_another_seed_makes_a_range_anew_and_nothing_else(after, base):
    made = [after({"do": "reroll", "from": 4.0, "to": 7.0, "seed": seed})[0] for seed in (1, 2, 1)]
    for motion in made:
        frames = touched(base, motion)
        assert frames.min() >= 4.0 * skeleton.FPS and frames.max() <= 7.0 * skeleton.FPS + 1
        assert len(frames) > 30
    assert len(touched(made[0], made[1])) > 30
    assert not len(touched(made[0], made[2]))


def test_a_pose_is_kept_whatever_is_edited_afterwards(after, base):
    pose = skeleton.normalize(base.directions[100] + 0.2 * np.roll(base.directions[100], 1, -1))
    edits = [{"do": "pose", "at": 80 / skeleton.FPS, "directions": pose.tolist()}]
    for more in ([], [{"do": "reroll", "from": 4.0, "to": 6.5}], [{"do": "add", "at": 5.6, "kind": "big"}]):
        motion, _ = after(*edits, *more)
        cosine = (motion.directions[80] * pose).sum(-1)
        assert np.degrees(np.arccos(np.clip(cosine, -1, 1))).max() < 0.5


def test_a_pose_that_is_far_is_reached_as_gently_as_the_take_moves(after, base):
    pose = base.directions[60].copy()
    aside = np.sign(base.directions[60, 4, 0])
    pose[4:6], pose[7:9] = (aside, 0.1, 0.1), (-aside, 0.1, 0.1)
    pose = skeleton.normalize(pose)
    motion, _ = after({"do": "pose", "at": 75 / skeleton.FPS, "directions": pose.tolist()})
    assert (motion.directions[75] * pose).sum(-1).min() > 1 - 1e-6
    assert regeneration.join_strain(base, motion, [(0, len(base.directions))]) <= 0.05
    within(base, motion, 75 / skeleton.FPS, room=3.2)


def test_a_hand_stays_at_its_place(after, base):
    place = [-0.3, -0.35, 0.35]
    motion, _ = after({"do": "place", "from": 5.0, "to": 6.0, "hand": "left", "place": place})
    wrist = skeleton.to_positions(motion.directions)[75:91, 6]
    assert np.linalg.norm(wrist - place, axis=-1).max() < 0.005
    within(base, motion, 5.0, 6.0)


def test_edits_follow_each_other_and_are_told(director, after, base):
    one = middle(base)
    edits = [{"do": "move", "at": one.at, "to": one.at + 0.3}, {"do": "change", "at": one.at + 0.3, "size": 0.7}]
    motion, _ = after(*edits)
    assert motion.meta["edits"] == edits
    fresh = Director(director.session).direct(Request(**vars_of(director, base)), edits).motions[0]
    assert not len(touched(motion, fresh))
    assert not len(touched(base, after()[0]))


def vars_of(director, base):
    """The request of a take by its provenance."""
    known = director.session._memory.heard[0][0][0]
    wanted = provenance.request_from_meta(base.meta, known, transcript=str(known).replace(".flac", ".txt"))
    return {name: getattr(wanted, name) for name in wanted.__dataclass_fields__}


@pytest.mark.parametrize(
    "edit",
    [
        {"do": "move", "at": 3.2, "to": 900.0},
        {"do": "delete", "at": 900.0},
        {"do": "add", "at": 900.0},
        {"do": "add", "at": 5.0, "kind": "somersault"},
        {"do": "add", "word": "xylophone"},
        {"do": "reroll", "from": 2.0, "to": 2.2},
        {"do": "pose", "at": 900.0, "directions": skeleton.REST.tolist()},
        {"do": "place", "from": 1.0, "to": 2.0, "hand": "left", "place": [-5.0, 0.0, 0.0]},
    ],
)
def test_what_cannot_be_done_is_told_with_its_number(after, edit):
    with pytest.raises(UsageError, match="Decision 1 ") as told:
        after(edit)
    assert told.value.remedy


def test_several_takes_are_not_directed(director, examples):
    with pytest.raises(UsageError):
        director.direct(Request(examples / "hello.flac", takes=2), [])


@pytest.mark.slow
def test_a_hundred_random_edits(director, request_, base, after):
    """A few miss, and each that does is told; nothing outside its phrase differs."""
    rng, missed, strains = random.Random(3), [], []
    found, kinds = gestures.find_gestures(base), list(director.session.vocabulary.gestures)
    for _ in range(100):
        one = rng.choice(found[1:-1])
        at = one.at
        do = rng.choice(["move", "delete", "change", "add"])
        edit = {"do": do, "at": at}
        if do == "move":
            edit["to"] = float(np.clip(at + rng.choice([-1, 1]) * rng.uniform(0.2, 0.8), 1.5, base.duration - 1.5))
        elif do == "change":
            what = rng.choice(["hand", "size", "kind"])
            choices = {"hand": gestures.HANDS, "size": [0.6, 0.8, 1.25, 1.4], "kind": kinds}
            edit[what] = rng.choice(choices[what])
        elif do == "add":
            at = edit["at"] = rng.uniform(2.0, base.duration - 2.0)
            edit["kind"] = rng.choice([gestures.BEAT, *kinds])
        motion, warnings = after(edit)
        aim = edit.get("to", at)
        frames = touched(base, motion) / skeleton.FPS
        assert len(frames) == 0 or (min(at, aim) - 2.5 < frames.min() and frames.max() < max(at, aim) + 2.5)
        there = gestures.nearest_of(gestures.find_gestures(motion), aim, targets.LANDS if do != "delete" else 0.2)
        if there is None if do != "delete" else there is not None and there.size > 0.5 * one.size:
            missed.append(edit)
            assert any("only near" in warning for warning in warnings)
        rows = touched(base, motion)
        strains.append(regeneration.speed_excess(base, motion, [(rows[0], rows[-1] + 1)]) if len(rows) else 0.0)
        assert strains[-1] < 0.01 or any("suddenly" in warning for warning in warnings)
    assert len(missed) <= 4, Counter(one["do"] for one in missed)
    print(f"{len(missed)} of 100 missed; beyond the take's own speed and acceleration at most {max(strains):.0%}")
    assert np.percentile(strains, 90) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("asked", [{"hand": "left"}, {"hand": "right"}, {"size": 0.6}, {"size": 1.4}])
def test_every_gesture_can_have_another_hand_and_size(after, base, asked):
    told = []
    for one in gestures.find_gestures(base)[2:-2]:
        if one.hand == asked.get("hand"):
            continue
        motion, warnings = after({"do": "change", "at": one.at, **asked})
        aim = targets.StrokeTarget(one.at, asked.get("hand", one.hand), one.size * asked.get("size", 1))
        if aim.miss(motion) > 1 or warnings:
            assert warnings and all("only near" in warning or "suddenly" in warning for warning in warnings), one
            told += [(one, warnings)] if aim.size >= 0.1 else []
    # Less than a tenth of a metre may be too slow to count as a gesture, and one that hardly has time may have to hurry.
    assert len(told) <= 0.2 * len(gestures.find_gestures(base)), told


def test_a_style_begins_where_it_is_asked_for(after, base):
    at, room = 0.5 * base.duration, int(skeleton.FPS)
    style = {"do": "style", "at": at, "style": "deadpan"}
    motion, warnings = after(style)
    rows = touched(base, motion)
    assert rows[0] >= int(at * skeleton.FPS) and rows[-1] > 0.9 * len(base.directions) and not warnings
    speed = [gestures.wrist_speeds(one.directions)[int(at * skeleton.FPS) + room :].max(1).mean() for one in (base, motion)]
    assert speed[1] < 0.9 * speed[0]
    assert regeneration.join_strain(base, motion, [(rows[0], rows[-1] + 1)]) < 0.5
    one = gestures.find_gestures(motion)[2]
    both, _ = after(style, {"do": "delete", "at": one.at})
    assert np.array_equal(both.directions[rows[0] + 60 :], motion.directions[rows[0] + 60 :])


def test_a_file_knows_the_styles_and_poses_of_its_edits(director, request_, after, base):
    one, two = [gesture for gesture in gestures.find_gestures(base) if 6 < gesture.at < 12][::3][:2]
    first = [{"do": "style", "at": 5.0, "style": "calm lecturer"}]
    first += [{"do": "pose", "at": 90 / skeleton.FPS, "directions": base.directions[88].tolist()}]
    reroll = {"do": "reroll", "from": one.at - 1.0, "to": two.at + 1.0, "seed": 4}
    before, together = after(*first)[0], after(*first, reroll)[0]
    apart, _ = take_edits.edit_take(director.session, before, [reroll], request_.audio, transcript=request_.transcript)
    assert len(touched(before, together)) and not len(touched(together, apart))


def test_spans_leave_neighbours_their_strokes():
    def gesture(at):
        return gestures.Gesture(at - 0.4, at - 0.2, at, at + 0.2, at + 0.3, at + 0.5, "left", "beat", 0.4, "")

    start, stop = frame_ranges.range_around([gesture(3.0), gesture(7.0)], 72, 78, 200)  # 4.8 to 5.2 s
    assert 3.2 * skeleton.FPS < start <= 72 - 6 and 78 + 6 < stop < 6.8 * skeleton.FPS + 1
    assert frame_ranges.range_around([], 2, 5, 10) == (0, 10)
    assert frame_ranges.merge_ranges([(20, 30), (5, 10), (12, 18)]) == [(5, 30)]
    assert frame_ranges.frame_mask([(1, 3)], 4).tolist() == [False, True, True, False]
