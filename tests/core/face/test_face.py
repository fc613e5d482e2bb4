"""Faces of the shipped example: when its closed lips close, at any frame rate, with words and without."""

import re
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from s2ag.core.face import animation, eyes, visemes
from s2ag.core.face import phones as phones_module
from s2ag.core.learning.evaluate import faces
from s2ag.core.learning.evaluate.faces import closure_times, closures_hit, lips_closed
from s2ag.core.motion import skeleton
from s2ag.core.motion.face import CHANNELS, MOUTH, RATE, VISEMES, Face, channel
from s2ag.core.motion.motion import Motion
from s2ag.core.motion.rhubarb_export import viseme_cues
from s2ag.core.sound import audio
from s2ag.core.words import transcript

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"
SHORTEST = 0.025


@lru_cache(maxsize=4)
def said(recording, words):
    sound = audio.load(recording)
    heard = transcript.timed_transcript(sound, text=words)
    return sound, heard


@pytest.fixture(scope="module")
def hello():
    return said(EXAMPLES / "hello.flac", (EXAMPLES / "hello.txt").read_text())


@pytest.fixture(scope="module")
def spoken(hello):
    sound, heard = hello
    return animation.analyse(sound, heard.words, heard.phones)


def still(seconds):
    return np.repeat(skeleton.REST[None], int(seconds * skeleton.FPS) + 1, 0)


def test_the_aligner_tells_sounds_that_fill_their_words(hello):
    _, heard = hello
    assert len(heard.phones) == len(heard.words) and all(heard.phones)
    for (_, start, end), phones in zip(heard.words, heard.phones, strict=True):
        edges = [edge for _, begin, stop in phones for edge in (begin, stop)]
        assert edges == sorted(edges) and abs(edges[0] - start) < 0.011
        assert all(b == a for a, b in zip(edges[1:-1:2], edges[2::2], strict=True)) and edges[-1] <= end + 0.2
    assert [phone for phone, *_ in heard.phones[2]] == ["M", "EY", "D"]


def test_sounds_of_words_with_times_alone_share_them_as_they_usually_would():
    shared = phones_module.phones_of_words((("voice", 1.0, 1.4), ("Zzyzx", 1.5, 2.0)))
    assert [phone for phone, *_ in shared[:3]] == ["V", "OY", "S"]
    assert shared[0][1] == 1.0 and shared[2][2] == pytest.approx(1.4)
    lengths = {phone: end - start for phone, start, end in shared[:3]}
    assert lengths["OY"] > lengths["S"] > lengths["V"] and len(shared) > 3


@pytest.mark.parametrize("fps", [24, 25, 29.97, 30, 60])
def test_closed_lips_close_within_a_frame(spoken, fps):
    face = animation.make_face(spoken, still(15))
    spans = closure_times(spoken.sounds)
    assert len(spans) == 8 and closures_hit(face, spans, fps) == 1


@pytest.mark.parametrize("fps", [12, 24, 60])
@pytest.mark.parametrize("start", [0.0, 0.31, 7.3])
def test_closed_lips_close_wherever_frames_lie(spoken, fps, start):
    face = animation.make_face(spoken, still(15))
    times = start + np.arange(int((14 - start) * fps)) / fps
    seen = times[lips_closed(face.at(times, fps))]
    for begin, end in face.closures[(face.closures[:, 0] > start) & (face.closures[:, 1] < times[-1])]:
        assert np.abs(seen - (begin + end) / 2).min() <= 0.5 / fps + 1e-6


def test_closed_lips_close_however_little_or_lazily_the_mouth_moves(spoken):
    for intensity, smoothness in ((0.1, 1.0), (2.0, 0.0)):
        face = animation.make_face(spoken, still(15), intensity=intensity, smoothness=smoothness)
        assert closures_hit(face, closure_times(spoken.sounds), 24) == 1
    small, large = (
        animation.make_face(spoken, still(15), intensity=size).weights[:, channel("JAW")].mean() for size in (0.3, 1.0)
    )
    assert small < 0.5 * large


def test_no_viseme_flickers(spoken):
    for smoothness in (0.0, 0.5):
        face = animation.make_face(spoken, still(15), smoothness=smoothness)
        widths = [width for column in face.weights[:, : len(VISEMES)].T for width in faces.half_widths(column)]
        assert len(widths) > 100 and min(widths) >= SHORTEST
        cues = viseme_cues(face)
        assert all(end - start >= SHORTEST for _, start, end in cues) and cues[0][1] == 0
        assert all(one[2] == other[1] and one[0] != other[0] for one, other in zip(cues, cues[1:], strict=False))


@pytest.mark.parametrize("phase", [0.0, 0.003, 0.007])
def test_no_viseme_flickers_between_two_closures_however_near(phase):
    for gap in np.arange(0.01, 0.15, 0.005):
        end = 0.6 + gap + phase
        said = [("M", 0.5, 0.55 + phase), ("EH", 0.55 + phase, end), ("B", end, end + 0.08), ("AA", end + 0.08, end + 0.2)]
        weights, shut = visemes.mouth_weights(said, np.zeros(120), 2.0, 0.0)
        widths = [width for column in weights[:, : len(VISEMES)].T for width in faces.half_widths(column)]
        assert min(widths) >= SHORTEST and all((shut[:, 0] <= t + 0.01).any() for t in (0.5, end))


def test_lips_get_round_before_the_sound_and_rest_in_pauses(spoken):
    weights = animation.make_face(spoken, still(15)).weights
    (start, _) = next((begin, end) for phone, begin, end in spoken.sounds if phone == "OY")
    early, before = (weights[int((start - ahead) * RATE), channel("OH")] for ahead in (0.25, 0.05))
    assert before > 0.12 and before > 2 * early
    assert weights[int(4.68 * RATE), : len(MOUTH)].max() < 0.05  # between "still" and "When"


def test_the_jaw_follows_loudness(spoken):
    quiet = animation.FaceSpeech(spoken.sounds, spoken.loudness - 15, spoken.phrases, spoken.questions, spoken.accents)
    loud, soft = (animation.make_face(one, still(15)).weights[:, channel("JAW")] for one in (spoken, quiet))
    assert soft.mean() < 0.75 * loud.mean()


def test_the_same_seed_is_the_same_face_and_another_blinks_otherwise(spoken):
    first, again, other = (animation.make_face(spoken, still(15), seed) for seed in (3, 3, 4))
    assert (first.weights == again.weights).all()
    assert (first.weights[:, : len(MOUTH)] == other.weights[:, : len(MOUTH)]).all()
    assert (first.weights[:, channel("BLINK_LEFT")] != other.weights[:, channel("BLINK_LEFT")]).any()


def test_weights_are_weights(spoken):
    face = animation.make_face(spoken, still(15), affect={"valence": 1.0, "arousal": -1.0}, intensity=2.0)
    weights = face.weights.copy()
    looking = [channel("LOOK_LEFT"), channel("LOOK_UP")]
    assert np.abs(weights[:, looking]).max() <= 1
    weights[:, looking] = 0
    assert weights.min() >= 0 and weights.max() <= 1 and np.isfinite(weights).all()
    assert animation.make_face(spoken, still(15), affect={"valence": -1.0}).weights[:, channel("FROWN")].mean() > 0.2


def test_blinks_come_as_often_as_people_s_and_eyes_lead_the_head(hello):
    sound, heard = hello
    spoken = animation.analyse(np.tile(sound, 8), [(w, s + k * len(sound) / 16000, e + k * len(sound) / 16000) for k in range(8)
                                             for w, s, e in heard.words])  # fmt: skip
    face = animation.make_face(spoken, still(120))
    shut = face.weights[:, channel("BLINK_LEFT")] > 0.5
    rate = (np.diff(shut.astype(int)) > 0).sum() / face.duration * 60
    assert 15 <= rate <= 40  # 26 are usual in conversation (Bentivoglio et al. 1997)
    looking = np.abs(face.weights[:, channel("LOOK_LEFT")]) * 30 < 5
    assert 0.4 < looking.mean() < 0.95
    turned = still(15)
    turned[30:90, 1] = skeleton.normalize(np.array([-0.6, -0.7, 0.4]))  # the head is turned left from two to six seconds
    short = animation.analyse(*hello[:1], hello[1].words, hello[1].phones)
    plain, led = (animation.make_face(short, one, 5).weights[:, channel("LOOK_LEFT")] for one in (still(15), turned))
    assert led[220:550].mean() < plain[220:550].mean() - 0.1  # what is looked at stays in sight


def test_gaze_goes_before_the_head_while_eyes_turn_back():
    time = np.arange(15 * skeleton.FPS + 1) / skeleton.FPS
    turning = still(15)
    turning[:, skeleton.EDGE_NAMES.index("neck"), 0] = 0.3 * np.sin(1.2 * time)
    turning = skeleton.normalize(turning)
    quiet = animation.FaceSpeech((), np.full(1500, -30.0), np.zeros((0, 2)), (), ())
    face, head = animation.make_face(quiet, turning), eyes.head_angles(turning, 1500)[:, 0]
    assert 20 <= faces.behaviour(face, quiet, turning)["gaze_before_head_ms"] <= 300
    assert np.corrcoef(face.weights[:, channel("LOOK_LEFT")], head)[0, 1] < -0.8


def test_speakers_look_at_the_listener_as_often_as_people(hello):
    sound, heard = hello
    length = len(sound) / 16000
    words = [(word, start + k * length, end + k * length) for k in range(8) for word, start, end in heard.words]
    spoken = animation.analyse(np.tile(sound, 8), words)
    told = faces.behaviour(animation.make_face(spoken, still(120)), spoken, still(120))
    assert told["gaze_as_phrases_begin"] < 0.5 < 0.7 < told["gaze_as_phrases_end"]
    assert 0.28 <= told["gaze_at_listener"] <= 0.7  # Kendon 1967


def test_a_face_survives_files_mirrors_and_other_rates(spoken, tmp_path):
    motion = Motion(still(14), face=animation.make_face(spoken, still(14)))
    motion.save(tmp_path / "a.npz")
    back = Motion.load(tmp_path / "a.npz")
    assert np.abs(back.face.weights - motion.face.weights).max() < 1e-6
    assert back.face.sounds == motion.face.sounds and back.face.meta == motion.face.meta
    assert back.resampled(24).face is back.face and back.frames(slice(3)).face is None
    once, twice = motion.mirrored().face, motion.mirrored().mirrored().face
    assert (twice.weights == motion.face.weights).all()
    assert (once.weights[:, channel("LOOK_LEFT")] == -motion.face.weights[:, channel("LOOK_LEFT")]).all()
    Motion(still(1)).save(tmp_path / "b.npz")
    assert Motion.load(tmp_path / "b.npz").face is None


def test_a_face_of_another_version_is_read_by_the_names_of_its_channels(spoken):
    kept = animation.make_face(spoken, still(15)).arrays()
    about = str(kept["face_about"]).replace('"SMILE"', '"SNEER"')
    face = Face.read({**kept, "face_about": about})
    assert not face.weights[:, channel("SMILE")].any() and face.weights[:, channel("JAW")].any()
    for broken in ({"face": kept["face"][:, 1:]}, {"face_closures": [[np.nan, 1]]}, {"face_about": "[]"}):
        with pytest.raises((ValueError, TypeError)):
            Face.read({**kept, **broken})


def test_nothing_said_is_a_face_at_rest():
    face = animation.make_face(animation.analyse(np.zeros(32000, np.float32)), still(2))
    assert len(face.weights) == 200 and not face.weights[:, : len(MOUTH)].any() and not len(face.closures)
    assert face.frames(24).shape == (48, len(CHANNELS))


def test_from_sound_alone_most_closed_lips_close(hello, spoken):
    face = animation.make_face(animation.analyse(hello[0]), still(15))
    assert face.meta["from_sound"]
    assert all(closures_hit(face, closure_times(spoken.sounds), fps) >= 0.6 for fps in (24, 60))


@pytest.mark.parametrize("name", ["p001", "p002"])
def test_people_reading_sonnets(shared, name):
    text = re.sub(r"<head>.*?</head>|<[^>]+>", " ", (shared / f"speech/{name}.xhtml").read_text(), flags=re.DOTALL)
    sound, heard = said(shared / f"speech/{name}.mp3", " ".join(text.split()))
    spoken = animation.analyse(sound, heard.words, heard.phones)
    face, spans = animation.make_face(spoken, still(55)), closure_times(spoken.sounds)
    alone = animation.make_face(animation.analyse(sound), still(55))
    for fps in (24, 60):
        assert closures_hit(face, spans, fps) >= 0.95
        assert closures_hit(alone, spans, fps) >= 0.6
    assert min(faces.shortest_viseme(face), faces.shortest_viseme(alone)) >= SHORTEST
    told = faces.behaviour(face, spoken, still(55))
    assert told["jaw_with_loudness"] > 0.4 and 12 <= told["blinks_a_minute"] <= 40


def test_tracks_of_a_single_sound_are_exact():
    weights, shut = visemes.mouth_weights([("M", 0.5, 0.6)], np.zeros(100))
    assert shut.tolist() == [[0.5, pytest.approx(0.59)]]
    assert (weights[50:60, MOUTH.index("PP")] == 1).all() and weights[40, MOUTH.index("PP")] < 0.05
