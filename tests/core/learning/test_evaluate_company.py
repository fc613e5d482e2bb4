"""Many performers at the same recordings: what a dull one reaches, the middle and the ends, recordings that are joined."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("scipy", reason="the engine is not installed")

from s2ag.core.learning.corpus import rotation  # noqa: E402
from s2ag.core.learning.evaluate import baselines, goals, human_recordings, performers, pictures, variety  # noqa: E402
from s2ag.core.learning.evaluate.measure import Case, measure  # noqa: E402
from s2ag.core.learning.evaluate.performers import Performance  # noqa: E402
from s2ag.core.learning.evaluate.talks import Talk  # noqa: E402
from s2ag.core.motion import rest, skeleton  # noqa: E402

SECONDS = 70
FRAMES = int(SECONDS * skeleton.FPS)


@pytest.fixture(scope="module")
def talk() -> Talk:
    """Noise that swells every two seconds, with a main accent on each swell, and a pause near its end."""
    time = np.arange(SECONDS * 16000) / 16000
    accents = np.array([[at, 0.8, 1] for at in np.arange(2.0, 60, 2.0)])
    words = tuple((f"word{row}", at - 0.5, at + 0.4) for row, (at, *_) in enumerate(accents))
    sound = (0.02 + np.sin(np.pi * (time + 1) / 2) ** 8) * np.random.default_rng(0).normal(0, 0.1, len(time))
    return Talk("talk", "talk", sound.astype(np.float32), words, accents)


def lively(talk: Talk, seed: int) -> np.ndarray:
    """Both arms swing another way at every accent ``(frames, 9, 3)``."""
    random = np.random.default_rng(seed)
    body = np.tile(rest.REST.astype(float), (FRAMES, 1, 1))
    for at in talk.main + random.normal(0, 0.25, len(talk.main)):
        here = slice(max(int((at - 0.9) * skeleton.FPS), 0), int((at + 0.9) * skeleton.FPS))
        lift = np.sin(np.pi * np.arange(here.stop - here.start) / (here.stop - here.start))[:, None] ** 2
        for edges in ((4, 5), (7, 8)):
            for edge in edges:
                body[here, edge] = rotation.rotate(rotation.from_vector(lift * random.normal(0, 1.2, 3)), body[here, edge])
    return skeleton.normalize(body + rest.idle_offsets(FRAMES, seed=seed))


def performance(talk: Talk, perform, clips=()) -> list[Performance]:
    return [Performance(Case(talk, perform(0), rest.REST), [perform(1), perform(3)], perform(2), clips)]


@pytest.fixture(scope="module")
def columns(talk) -> dict:
    casts = {"this": {f"performer {k}": performance(talk, lambda seed, k=k: lively(talk, 10 * k + seed)) for k in range(3)}}
    for name, perform in baselines.BASELINES.items():
        casts[name] = {name: performance(talk, lambda seed, perform=perform: perform(talk, rest.REST, seed))}
    return {name: performers.variety_column(cast) for name, cast in casts.items()}


def test_dull_performances_fail_the_goals_of_variety(columns):
    verdicts = goals.verdicts(columns, goals.VARIETY)
    for key in (
        "nearest_neighbour",
        "cells",
        "components",
        "most_repeated",
        "forearm_median_most",
        "seeds_apart",
        "seeds_places",
    ):
        assert verdicts[key]["dull"] == [], key
    for name in baselines.BASELINES:
        assert columns[name]["cells"] < 60 and columns[name]["components"] < 7 and columns[name]["seeds_apart"] < 5
    assert columns["one gesture"]["nearest_neighbour"] < 0.2 and columns["one gesture"]["first_axis"] > 0.9
    assert columns["this"]["nearest_neighbour"] > 0.5 and columns["this"]["seeds_apart"] > 5


def test_marks_come_from_what_dull_performances_reach(columns, talk):
    assert goals.verdicts(columns, goals.VARIETY)["forearm_median_least"]["dull"] == ["resting", "one gesture"]
    timed = {name: measure([Case(talk, perform(talk, rest.REST), rest.REST)]) for name, perform in baselines.BASELINES.items()}
    timed["directed"] = timed["this"] = measure([Case(talk, lively(talk, 0), rest.REST)])
    verdicts = goals.verdicts(timed)
    assert verdicts["main_accent"]["dull"] == ["one gesture"]  # who beats time on every accent is on time
    assert verdicts["pause_at_rest"]["dull"] == verdicts["through_body"]["dull"] == ["resting", "one gesture"]
    assert verdicts["strokes_a_minute"]["dull"] != ["resting", "one gesture"]


def test_the_middle_and_the_ends_of_performers(columns):
    each = [figures["forearm_median"] for figures in columns["this"]["performers"].values()]
    found = columns["this"]
    assert found["forearm_median"] == pytest.approx(np.median(each))
    assert (found["forearm_median_least"], found["forearm_median_most"]) == pytest.approx((min(each), max(each)))


def test_every_pair_of_seeds_counts(talk):
    one = performance(talk, lambda seed: lively(talk, seed))
    motions = [one[0].case.directions, *one[0].seeds]
    pairs = [variety.shared_stroke_places(motions[a], motions[b]) for a, b in ((0, 1), (0, 2), (1, 2))]
    found = performers.of_performer(one)
    assert found["seeds_places"] == pytest.approx(np.mean(pairs)) and found["takes_places"] != found["seeds_places"]
    assert found["follows_voice"] == pytest.approx(
        np.mean([variety.loudness_correlation(motion, talk.loudness) for motion in motions])
    )


def test_clips_are_counted_over_all_recordings(talk):
    one = performance(talk, lambda seed: baselines.one_gesture(talk, rest.REST, seed), ("a", "b", "b"))
    other = performance(talk, lambda seed: baselines.one_gesture(talk, rest.REST, seed), ("b",))
    assert performers.of_performer(one + other)["clip_share"] == pytest.approx(0.75)
    assert "clip_share" not in performers.of_performer(performance(talk, lambda seed: baselines.idle(talk, rest.REST, seed)))


def test_performers_from_calm_to_lively(talk):
    troupe = {
        "lively": performance(talk, lambda seed: lively(talk, seed)),
        "resting": performance(talk, lambda seed: baselines.idle(talk, rest.REST, seed)),
    }
    assert performers.rank_by_energy(troupe) == ["resting", "lively"]


def test_short_recordings_are_joined(talk):
    cut = replace(talk.cut(10.0), name="clip-0100")
    whole = human_recordings.join_recordings([cut, replace(cut, name="clip-0200")])
    assert whole.name == "clip, 2 joined" and len(whole.audio) == 16000 * (20 + human_recordings.PAUSE)
    assert len(whole.words) == 2 * len(cut.words) and whole.words[-1][1] == pytest.approx(
        cut.words[-1][1] + 10 + human_recordings.PAUSE
    )
    assert whole.main.tolist() == pytest.approx([*cut.main, *(cut.main + 10 + human_recordings.PAUSE)])
    assert human_recordings.join_recordings([cut]) is cut


def test_loudness_follows_the_sound(talk):
    assert talk.loudness.shape == (FRAMES,)
    assert talk.loudness[round(4.0 * skeleton.FPS)] > 4 * talk.loudness[round(5.0 * skeleton.FPS)]


@pytest.mark.slow
def test_the_director_performs_a_strangers_recording(shared, talk):
    from s2ag.core.learning.evaluate.director import Director

    teacher, name = Director(shared), "eager storyteller"
    ((first, hands, clips), (second, _, _)) = teacher.perform(talk.cut(20.0), [name], 2)[name]
    assert first.shape == second.shape == (300, 9, 3) and len(hands) == 300
    assert clips and not any(clip.endswith("~") for clip in clips)
    assert not np.allclose(first, second)


@pytest.mark.slow
def test_captured_motion_is_a_minute_of_clips_and_a_conversation(shared):
    found = human_recordings.captured_motion(shared)
    assert found["clips"].shape == (900, 9, 3) and 300 < len(found["conversation"]) < 400


def test_paths_and_films_are_drawn(talk, tmp_path):
    pytest.importorskip("matplotlib", reason="pictures need matplotlib")
    case = Case(talk, lively(talk, 0), rest.REST)
    pictures.wrist_paths(
        {"people": {"a": case.directions}, "ours": {"b": case.directions, "c": case.directions}}, tmp_path / "a.png"
    )
    pictures.film_sheet({"ours": case}, tmp_path / "b.png", seconds=1.0)
    assert all((tmp_path / name).stat().st_size > 5000 for name in ("a.png", "b.png"))
