"""The director: plans, performances and the packed corpus, on a talk of noise bursts and a small library made here."""

import json
import zlib
from collections import deque
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bodies import degrees
from captured import small_footage, wave_clip
from s2ag.core.learning.corpus import (
    build,
    captured_talk,
    directing,
    lexicon,
    library,
    pack,
    phrases,
    planning,
    rendering,
    repertoire,
    shaping,
    speakers,
    talk_features,
    variation,
)
from s2ag.core.learning.corpus.scene import Scene
from s2ag.core.learning.evaluate import kinematics, variety
from s2ag.core.learning.train.dataset import Corpus
from s2ag.core.motion import hand_channels, limits, rest, skeleton
from small_talks import small_speech

MATERIAL = Path(__file__).parents[3].parent / "shared" / "data"
needs_material = pytest.mark.skipif(not (MATERIAL / "smartbody").is_dir(), reason="../shared is absent")


def small_library() -> list[library.Gesture]:
    gestures = []
    for meaning, label in (("beat", "BeatMid"), ("list", "Chop"), ("offer", "Offer"), ("you", "You"), ("none", "Safe")):
        gestures.append(library._describe(wave_clip(f"Set/{label}Rt01"), "Set", label, meaning, False))
    return gestures + [gesture.mirrored() for gesture in gestures]


def word_vectors(words: list[str]) -> np.ndarray:
    """One direction for big things, another for every other word."""
    kin = [0 if word in ("big", "huge", "large", "gigantic") else zlib.crc32(word.encode()) for word in words]
    return np.stack([np.random.default_rng(seed).normal(size=40) for seed in kin])


@pytest.fixture(scope="module")
def gestures() -> list[library.Gesture]:
    return small_library()


@pytest.fixture(scope="module")
def scene() -> Scene:
    return Scene.of(small_speech())


def planned(performer: speakers.Performer, gestures, scene, seed: int = 0) -> list[planning.Stroke]:
    drawn = repertoire.Repertoire(performer, gestures)
    return planning.plan(drawn, lexicon.Lexicon(word_vectors), scene, np.random.default_rng(seed))


@pytest.fixture(scope="module")
def footage() -> captured_talk.Material:
    return small_footage()


def perform(performer, gestures, footage, scene, seed: int = 0) -> directing.Directed:
    drawn, following = repertoire.Repertoire(performer, gestures), shaping.Following.learn(footage.talk)
    return directing.perform(footage, following, drawn, lexicon.Lexicon(word_vectors), scene, np.random.default_rng(seed))


def test_words_near_to_listed_ones_share_their_meaning():
    meanings = lexicon.Lexicon(word_vectors)
    assert meanings.meaning("big") == meanings.meaning("gigantic") == "big"
    assert meanings.meaning("you") == "you" and meanings.meaning("quartz") is None and meanings.meaning("the") is None


def test_strokes_land_on_accents_and_phases_are_in_order(scene, gestures):
    times = np.array([accent.time for accent in scene.accents])
    for performer in speakers.PERFORMERS:
        strokes = planned(performer, gestures, scene)
        if performer.threshold < 0.55:
            assert strokes
        for stroke, following in zip(strokes, [*strokes[1:], None], strict=True):
            assert np.abs(times - planning.LEAD - stroke.emphasis).min() < 0.051
            assert stroke.onset <= stroke.ready <= stroke.emphasis <= stroke.end <= min(stroke.until) <= max(stroke.rest)
            if following is not None:
                assert following.onset >= stroke.emphasis


def test_main_accents_get_more_strokes_than_their_share(scene, gestures):
    mains = np.array([accent.time for accent in scene.accents if accent.main])
    strokes = [s.emphasis for p in speakers.PERFORMERS for s in planned(p, gestures, scene)]
    on_main = (np.abs(np.array(strokes)[:, None] - mains).min(1) < 0.15).mean()
    assert on_main > 1.2 * len(mains) / len(scene.accents)


def test_a_seed_is_a_performance_and_another_seed_another(scene, gestures, footage):
    performer = speakers.PERFORMERS[1]
    first, again, other = (perform(performer, gestures, footage, scene, seed).directions for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert variety.arms_apart(first, other) > 5


def test_what_was_shown_lately_is_not_drawn_again(gestures):
    pool = [replace(g, clip=replace(g.clip, name=f"Set/{k}")) for k, g in enumerate(gestures * 3)]
    drawn = repertoire.Repertoire(speakers.PERFORMERS[1], pool)
    memory, random = deque(maxlen=repertoire.MEMORY), np.random.default_rng(0)
    wish = repertoire.StrokeWish("both", -0.1, 0.5, False)
    names = [drawn.draw(random, repertoire.BEAT, wish, memory).name.rstrip("~") for _ in range(60)]
    assert all(name not in names[max(0, k - repertoire.MEMORY) : k] for k, name in enumerate(names))
    assert len(set(names)) > 15


def test_a_meaning_is_shown_by_its_own_clips(gestures):
    drawn = repertoire.Repertoire(speakers.PERFORMERS[0], gestures)
    random, wish = np.random.default_rng(0), repertoire.StrokeWish("right", 0.0, 0.5, False)
    assert {drawn.draw(random, "none", wish, deque(maxlen=8)).meaning for _ in range(20)} == {"none"}
    assert "none" in drawn.meanings() and "unknown" not in drawn.meanings()


def test_phrases_mean_what_their_words_do_not():
    found = phrases.find_phrases(["but", "i", "don't", "know", "it", "and", "on", "the", "other", "hand", "no", "idea"])
    assert {bearer: meaning for bearer, (meaning, _) in found.items()} == {3: "unknown", 8: "however", 11: "unknown"}
    assert not phrases.find_phrases(["i", "don't", "know"], [False, True, False]).get(1)
    assert set(phrases.PHRASES) <= set(library.ALL_MEANINGS) and library.ALL_MEANINGS[0] == repertoire.BEAT


def test_a_hand_is_preferred_when_asked_for(scene, gestures):
    performer = next(p for p in speakers.PERFORMERS if p.hand == "right" and p.both > 0.3)
    assert (
        performer.with_hand(0.1) is performer
        and performer.with_hand(-1).hand == "left"
        and performer.with_hand(1).hand == "right"
    )
    shown = [[s.hand for k in range(8) for s in planned(performer.with_hand(wish), gestures, scene, k)] for wish in (-1, 1)]
    hands = [np.bincount(each, minlength=3) for each in shown]
    assert hands[0][0] > hands[0][1] and hands[1][1] > hands[1][0]


def test_arms_turn_and_keep_their_length():
    directions = skeleton.normalize(np.random.default_rng(0).normal(size=(5, 3)))
    turned = variation.rotate_by_share(directions, np.array([0, 0.3, 0]), np.linspace(0, 1, 5))
    np.testing.assert_allclose(np.linalg.norm(turned, axis=-1), 1)
    np.testing.assert_allclose(turned[0], directions[0])
    assert np.allclose(turned[:, 1], directions[:, 1]) and not np.allclose(turned[-1], directions[-1])


def steered(scene, control, value):
    return replace(scene, controls=np.eye(5)[control] * value, heard=np.zeros_like(scene.heard))


def test_the_control_of_rate_gives_more_gestures_or_fewer(scene, gestures):
    counts = [
        sum(len(planned(speakers.PERFORMERS[1], gestures, steered(scene, 3, value), take)) for take in range(6))
        for value in (-1, 0, 1)
    ]
    assert counts[0] < counts[1] <= counts[2]


def mean_speed(bodies) -> float:
    """Metres a second of the wrists."""
    return float(np.mean([np.linalg.norm(np.diff(skeleton.wrists(body), axis=0), axis=-1) for body in bodies]) * skeleton.FPS)


def bodies_of(gestures, footage, scene, control, value):
    takes = range(6)
    return [perform(speakers.PERFORMERS[1], gestures, footage, steered(scene, control, value), k).directions for k in takes]


def test_arousal_is_seen_in_speed_height_and_posture(scene, gestures, footage):
    calm, usual, stirred = (bodies_of(gestures, footage, scene, 0, value) for value in (-1, 0, 1))
    assert mean_speed(calm) < 0.6 * mean_speed(usual) and mean_speed(stirred) > 1.3 * mean_speed(usual)
    heights = [np.mean([-skeleton.wrists(body)[..., 1].mean() for body in bodies]) for bodies in (calm, usual, stirred)]
    assert heights[0] + 0.05 < heights[1] < heights[2] - 0.03
    heads = [np.mean([body[:, 1, 1].mean() for body in bodies]) for bodies in (calm, stirred)]
    assert heads[0] > heads[1], "a calm head sinks"


def test_valence_opens_and_dominance_straightens(scene, gestures, footage):
    def posture(control, value):
        points = [skeleton.to_positions(body).mean(0) for body in bodies_of(gestures, footage, scene, control, value)]
        return np.mean(points, axis=0)

    valence, dominance = (posture(control, 1) - posture(control, -1) for control in (1, 2))
    for change in (valence, dominance):
        assert change[9, 0] - change[6, 0] > 0.05, "wrists farther apart"
    assert dominance[2, 2] < valence[2, 2] - 0.02, "the dominant lean back"


def test_what_is_heard_and_what_is_asked_add_up(scene, gestures, footage):
    heard = replace(scene, heard=np.full_like(scene.heard, 0.7), controls=np.zeros(5))
    asked = replace(scene, heard=np.zeros_like(scene.heard), controls=np.array([0.7, 0.7, 0.7, 0, 0]))
    np.testing.assert_allclose(heard.affect(np.arange(5.0)), asked.affect(np.arange(5.0)), atol=1e-6)
    assert np.abs(replace(asked, heard=np.ones_like(scene.heard)).affect(1.0)).max() == 1.5


def test_one_hand_leads_where_the_performer_has_it_so(scene, gestures, footage):
    def share(name):
        performer = next(p for p in speakers.PERFORMERS if p.name == name)
        bodies = [perform(performer, gestures, footage, scene, take).directions for take in range(4)]
        ways = sum(np.linalg.norm(np.diff(skeleton.wrists(body), axis=0), axis=-1).sum(0) for body in bodies)
        return ways[1] / ways.sum()

    assert share("stern") > 0.6 > share("warm host") > 0.4 > share("left-handed joker")


def test_some_strokes_show_what_the_words_do_not_say(scene, gestures, footage):
    people = enumerate(speakers.PERFORMERS)
    strokes = np.concatenate([perform(p, gestures, footage, scene, number).strokes for number, p in people])
    unsaid = strokes[:, 6] == 0
    assert 0.001 < unsaid.mean() < 0.15 and (strokes[unsaid, 3] > 0).all()
    assert (strokes[:, 3] == 0).mean() > 0.5, "beats are the rule"


def test_a_performance_moves_in_speech_and_rests_in_pauses(scene, gestures, footage):
    directed = perform(speakers.PERFORMERS[0], gestures, footage, scene)
    body = directed.directions
    assert body.shape == (int(scene.speech.duration * 15), 9, 3) and body.dtype == np.float32
    assert len(directed.hands) == len(body) and (np.diff(directed.strokes[:, 0]) >= 0).all()
    np.testing.assert_allclose(np.linalg.norm(body, axis=-1), 1, atol=1e-5)
    speed = kinematics.angular_speed(body)
    assert speed.max() < 900
    time = np.arange(len(speed)) / skeleton.FPS
    spoken = np.any([(time > begin) & (time < end) for begin, end in scene.prosody.phrases], axis=0)
    assert speed[spoken][:, [5, 8]].mean() > 1.5 * speed[-8:, [5, 8]].mean()  # the second hand goes home a second later
    assert not limits.backward_elbows(body).any()


def test_a_talk_without_words_is_performed_with_beats(gestures):
    spoken = replace(small_speech(), words=(), affect=np.full((1, 3), 0.5))
    silent = Scene.of(spoken)
    strokes = planned(speakers.PERFORMERS[1], gestures, silent)
    assert strokes and all(stroke.meaning == repertoire.BEAT for stroke in strokes if stroke.said)


def test_the_warp_meets_every_phase_and_never_runs_backwards():
    clip = wave_clip()
    gesture = library._describe(clip, "Set", "BeatMid", "beat", False)
    stroke = planning.Stroke(gesture, 1.0, 1.5, 2.0, 2.2, (2.5, 3.0), (3.2, 3.8), 1.0)
    at = rendering.warp(clip, stroke, np.array([1.0, 1.5, 2.0, 2.2, 3.0, 3.8]))
    np.testing.assert_allclose(at, [clip.onset, clip.ready, clip.emphasis, clip.end, clip.relax, clip.rest], atol=0.02)
    assert (np.diff(rendering.warp(clip, stroke, np.linspace(0, 5, 200))) >= -1e-9).all()


def test_performers_differ_and_have_names_people_understand():
    names = [performer.name for performer in speakers.PERFORMERS]
    assert len(set(names)) == len(names) == 24
    assert len({(p.size, p.gap, p.hand, p.height, p.rest, p.both, p.plane) for p in speakers.PERFORMERS}) == len(names)
    assert all(performer.description.endswith(".") for performer in speakers.PERFORMERS)
    assert sum(known["default"] for known in speakers.describe()) == 1


def test_every_performer_gets_a_fair_share_of_talks():
    counts = np.bincount(
        [p for index in range(240) for p, _ in build.performers_of_talk(index, 3)], minlength=len(speakers.PERFORMERS)
    )
    assert counts.min() > 0.8 * counts.mean()
    assert all(
        len(set(build.performers_of_talk(index, 8))) == 8 and len({p for p, _ in build.performers_of_talk(index, 8)}) == 6
        for index in range(50)
    )


def test_some_performances_are_steered_and_all_within_range():
    drawn = np.array([build.draw_controls(index, number, 0) for index in range(60) for number in range(6)])
    assert drawn.shape[1] == 5 and np.abs(drawn).max() <= 1
    assert 0.3 < (drawn == 0).all(1).mean() < 0.55
    np.testing.assert_array_equal(build.draw_controls(7, 3, 0), build.draw_controls(7, 3, 0))


def test_what_is_heard_is_kept_and_used_as_it_is(tmp_path):
    spoken = small_speech(1)
    first = talk_features.load_or_analyse(tmp_path, spoken)
    assert len(first.prosody.features) == len(first.tracks) == len(first.plain) == int(spoken.duration * 15)
    again = talk_features.load_or_analyse(tmp_path, replace(spoken, recorded=np.zeros_like(spoken.recorded)))
    assert again.prosody.accents == first.prosody.accents == Scene.of(spoken).accents
    np.testing.assert_array_equal(again.mfcc, first.mfcc)


def test_the_packed_corpus_is_what_training_reads(tmp_path):
    spoken = small_speech()
    talks = []
    for number in range(3):
        frames = 40 + number
        tracks = np.full((frames, 17), 0.5, np.float16)
        moves = [
            build.Performance(
                k,
                np.zeros(5, np.float32),
                np.tile(rest.REST, (frames, 1, 1)),
                np.full((frames, hand_channels.SIZE), 0.25, np.float32),
                np.array([[0.8, 1, 1.2, 2, 1, 0.5, k > 2]], np.float32),
                0.4,
            )
            for k in (number, number + 3)
        ]
        words = [("hello", 0.2, 0.5), ("world", 0.7, 1.0)]
        mfcc = talk_features.network_input(spoken.recorded[: 16000 * 3])
        accents = np.array([[1.0, 0.5, 1.0]], np.float32)
        heard = np.zeros((frames, 3), np.float16)
        talks.append(build.Talk(number, number, "noise", mfcc, tracks, tracks, words, accents, np.full(3, 0.5), heard, moves))
    figures = pack.save(talks, tmp_path / "corpus", 0)
    assert figures["recordings"] == 3 and figures["performances"] == 6 and figures["share of strokes on main accents"] == 1
    corpus = Corpus.load(tmp_path / "corpus")
    arrays = corpus.arrays
    assert corpus.extras.shape == (246, hand_channels.SIZE) and corpus.heard.shape == (123, 3)
    assert arrays["directions"].shape == (246, 9, 3) and arrays["starts"].tolist() == [0, 40, 80, 121, 162, 204, 246]
    assert arrays["frame_starts"].tolist() == [0, 40, 81, 123] and arrays["recording"].tolist() == [0, 0, 1, 1, 2, 2]
    assert arrays["split"].tolist() == [0, 0, 1, 1, 2, 2] and arrays["speaker"].tolist() == [0, 3, 1, 4, 2, 5]
    assert arrays["strokes"].shape == (6, 7) and arrays["strokes"][:, 0].tolist() == list(range(6))
    assert np.diff(arrays["stroke_starts"]).tolist() == [1] * 6 and corpus.meta["meanings"][0] == "beat"
    assert arrays["said"].tolist() == [False, True] * 3
    first = arrays["word_index"][:40]
    assert set(first.tolist()) == {-1, 0, 1} and first[4] == 0 and first[12] == 1 and first[20] == -1
    assert np.abs(arrays["vectors"].astype(float)).sum(axis=1).min() > 0
    assert len(corpus.speakers) == 24 and np.shape(corpus.speakers[0]["rest"]) == (9, 3)


@pytest.mark.slow
@needs_material
def test_a_tiny_corpus_is_built_from_the_command(tmp_path):
    """One talk in the cache, four performers; a second run gives the same motion."""
    from s2ag.core.learning.corpus.__main__ import main

    (tmp_path / "speech").mkdir()
    replace(small_speech(), index=0).save(tmp_path / "speech" / "0000.npz")
    command = ["--material", str(MATERIAL), "--out", str(tmp_path / "corpus"), "--hours", "0.001", "--workers", "1"]
    assert main(command) == 0
    first = np.load(tmp_path / "corpus" / "directions.npy")
    meta = json.loads((tmp_path / "corpus" / "meta.json").read_text())
    assert len(np.load(tmp_path / "corpus" / "speaker.npy")) == 4 and meta["recordings"][0]["speech"] == "0000.npz"
    assert degrees(first[:1].astype(float), first.astype(float)).max() > 20, "nobody gestured"
    assert main(command) == 0
    np.testing.assert_array_equal(np.load(tmp_path / "corpus" / "directions.npy"), first)


def test_missing_material_is_one_sentence_and_exit_2(tmp_path, capsys):
    from s2ag.core.learning.corpus.__main__ import main

    assert main(["--material", str(tmp_path), "--out", str(tmp_path / "out")]) == 2
    assert "holds no smartbody" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
