"""Who listens waits as captured people do, and answers now and then; who takes turns speaks in them and listens otherwise."""

import numpy as np
import pytest
from s2ag.core.editing import provenance
from s2ag.core.errors import UsageError
from s2ag.core.motion import limits, skeleton
from s2ag.core.sound import audio
from s2ag.core.synthesis import listener_response
from s2ag.core.synthesis.session import Request, Session
from s2ag.core.words import markup, speaker_turns
from s2ag.core.words.transcript import TimedTranscript
from sounds import write_wav


@pytest.fixture(scope="module")
def session():
    return Session(cache="off", remember=True)


@pytest.fixture(scope="module")
def speech(examples):
    return audio.load(examples / "hello.flac")


@pytest.fixture(scope="module")
def dialogue(speech, tmp_path_factory):
    """Two recordings: one speaks, then the other."""
    folder, half = tmp_path_factory.mktemp("dialogue"), speech[: 8 * audio.SAMPLE_RATE]
    for name, parts in (("anna", (half, 0 * half)), ("bert", (0 * half, half))):
        write_wav(folder / f"{name}.wav", np.concatenate(parts))
    return folder / "anna.wav", folder / "bert.wav"


def fast(motion):
    """Speed of the faster wrist in metres a second."""
    return np.linalg.norm(np.diff(skeleton.wrists(motion.directions), axis=0), axis=-1).max(1) * skeleton.FPS


def turning(motion, edges):
    """Radians a second by which directions of ``edges`` turn, on average at each frame."""
    return np.linalg.norm(np.diff(motion.directions[:, edges].astype(float), axis=0), axis=-1).mean(1) * skeleton.FPS


def test_who_listens_lives_and_answers(session, examples):
    made = [
        session.synthesize(Request(examples / "hello.flac", seed=seed, listen=True, face=1.0, hands=1.0)).motions[0]
        for seed in range(4)
    ]
    found = [answer for one in made for answer in one.meta["listens"]]
    assert 0 < len(found) < 4 * made[0].duration / 1.8
    assert sum(kind == "accept" for kind, _ in found) >= len(found) / 2
    for motion in made:
        # captured people who listen: arms 0.05 to 0.4, head 0.15 to 0.4, wrists at most 1 m/s
        assert 0.05 < np.mean(turning(motion, [4, 5, 7, 8])) < 0.4 and 0.1 < np.mean(turning(motion, [1, 2])) < 0.6
        assert turning(motion, range(9)).min() > 0.005 and fast(motion).max() < 1 and not motion.words
        assert motion.face.weights[:, 0].max() < 0.05
        assert not limits.backward_elbows(motion.directions).any()
        palms = motion.hands.palms.astype(float)
        assert np.linalg.norm(np.diff(palms, axis=0), axis=-1).max() * skeleton.FPS < 8
    again = session.synthesize(provenance.request_from_meta(made[3].meta, examples / "hello.flac")).motions[0]
    assert np.array_equal(again.directions, made[3].directions)
    assert not np.allclose(made[0].directions, made[1].directions, atol=0.01), "another seed waits otherwise"


@pytest.mark.parametrize("style", ["brisk presenter", "warm host"])
def test_palms_are_steady_where_a_style_rests_with_hands_before_the_body(session, speech, tmp_path, style):
    write_wav(tmp_path / "long.wav", np.tile(speech, 3))
    for seed in (0, 1):
        motion = session.synthesize(Request(tmp_path / "long.wav", style=style, seed=seed, listen=True, hands=1.0)).motions[0]
        palms = motion.hands.palms.astype(float)
        assert np.linalg.norm(np.diff(palms, axis=0), axis=-1).max() * skeleton.FPS < 8


def test_a_long_silence_in_a_talk_lives(session, speech, tmp_path):
    said, pause = speech[: 3 * audio.SAMPLE_RATE], np.zeros(9 * audio.SAMPLE_RATE, np.float32)
    write_wav(tmp_path / "pause.wav", np.concatenate([said, pause, said]))
    motion = session.synthesize(Request(tmp_path / "pause.wav", seed=1)).motions[0]
    arms = turning(motion, [4, 5, 7, 8])[6 * 15 : 11 * 15]
    assert 0.02 < np.mean(arms) < 0.3 and arms.min() > 0.005 and "listens" not in motion.meta


def test_two_recordings_take_turns(session, dialogue):
    anna, bert = dialogue
    one = session.synthesize(Request(anna, seed=1, hears=bert)).motions[0]
    other = session.synthesize(Request(bert, seed=1, hears=anna)).motions[0]
    assert one.duration == other.duration
    middle, room = len(one.directions) // 2, int(2 * skeleton.FPS)
    for motion, own, listens in ((one, slice(0, middle - room), slice(middle + room, None)),
                                 (other, slice(middle + room, None), slice(0, middle - room))):  # fmt: skip
        assert np.mean(fast(motion)[own]) > 2 * np.mean(fast(motion)[listens]) > 0.02
        assert motion.meta["listens"] and all(at > 7 if motion is one else at < 9 for _, at in motion.meta["listens"])


def test_a_transcript_with_names_tells_whose_turn_it_is(session, examples):
    words = (examples / "hello.txt").read_text().split()
    half = len(words) // 2
    text = f"ANNA: {' '.join(words[:half])}\nBERT: {' '.join(words[half:])}"
    anna, bert = (session.synthesize(Request(examples / "hello.flac", text=text, turn=who)) for who in ("Anna", "bert"))
    assert len(anna.words) + len(bert.words) == len(markup.parse(text).tokens)
    border = bert.words[0][1]
    assert anna.words[-1][2] <= border
    row = int(border * skeleton.FPS)
    assert np.mean(fast(anna.motions[0])[: row - 15]) > 2 * np.mean(fast(bert.motions[0])[: row - 15])
    assert np.mean(fast(bert.motions[0])[row + 15 :]) > 2 * np.mean(fast(anna.motions[0])[row + 30 :])
    with pytest.raises(UsageError, match="ANNA, BERT"):
        session.synthesize(Request(examples / "hello.flac", text=text, turn="Carl"))


def test_marks_count_the_words_of_one_speaker():
    text = "ANNA: One two.\nBERT: {big} three *four*."
    words = tuple((name, float(at), at + 0.5) for at, name in enumerate(("One", "two", "three", "four")))
    marks = tuple(markup.parse(text).marks)
    said, spans = speaker_turns.words_of_speaker(TimedTranscript(words, (1.0,) * 4, marks), None, text, "Bert")
    assert [word for word, *_ in said.words] == ["three", "four"]
    assert {(mark.kind, mark.first, mark.last) for mark in said.marks} == {("hint", 0, 2), ("stress", 1, 2)}
    assert spans.tolist() == [[1.75, 3.75]]


def test_answers_come_at_ends_of_phrases_that_are_heard():
    phrases = np.stack([np.arange(0, 400, 4.0), np.arange(3, 403, 4.0)], 1)
    hears = np.ones(405 * 15)
    found = listener_response.draw_responses(phrases, hears, 3)
    again = listener_response.draw_responses(phrases, hears, 3)
    assert 0.3 < len(found) / len(phrases) < 0.8 and [one[:2] for one in found] == [one[:2] for one in again]
    assert all(min(abs(one.at - end) for _, end in phrases) < 0.4 for one in found)
    assert listener_response.draw_responses(phrases, 0 * hears, 3) == []


def test_what_is_personal_is_answered_more():
    phrases, hears = np.stack([np.arange(0, 800, 8.0), np.arange(3, 803, 8.0)], 1), np.ones(805 * 15)
    words = [("I'm", at + 1, at + 1.5) for at in range(0, 800, 16)]  # in every second phrase
    found = listener_response.draw_responses(phrases, hears, 3, words)
    personal = [round((one.at - 3) / 8) % 2 == 0 for one in found]
    assert sum(personal) > 1.25 * (len(found) - sum(personal))
    size = [np.abs(one.numbers[:, :27]).max() for one in found]
    assert np.mean([a for a, own in zip(size, personal, strict=True) if own]) > 1.2 * np.mean(
        [a for a, own in zip(size, personal, strict=True) if not own]
    )


def test_a_text_tells_what_is_personal(session, examples):
    about = {"audio": examples / "hello.flac", "listen": True, "seed": 1}
    told = session.synthesize(Request(**about, transcript=examples / "hello.txt"))
    assert not told.words and told.motions[0].meta["listens"] != session.synthesize(Request(**about)).motions[0].meta["listens"]


def test_one_way_of_listening_at_a_time(dialogue):
    with pytest.raises(UsageError, match="several ways"):
        Request(dialogue[0], listen=True, hears=dialogue[1])


def yaw(directions):
    """Degrees ``(frames,)`` by which the head is turned to its left."""
    neck = directions[:, skeleton.EDGE_NAMES.index("neck")]
    return np.degrees(np.arctan2(-neck[:, 0], neck[:, 2]))


@pytest.mark.parametrize("toward", [40.0, -30.0])
@pytest.mark.parametrize("mirror", [False, True])
def test_who_listens_looks_at_who_speaks(session, dialogue, toward, mirror):
    anna, bert = dialogue
    same = {"seed": 1, "hears": bert, "face": 1.0, "mirror": mirror}
    straight = session.synthesize(Request(anna, **same)).motions[0]
    looking = session.synthesize(Request(anna, **same, toward=toward)).motions[0]
    turned = yaw(looking.directions) - yaw(straight.directions)
    seconds = np.arange(len(turned)) / skeleton.FPS
    assert np.median(turned[(seconds > 10) & (seconds < 15)]) == pytest.approx(toward, abs=3)
    speaking = np.median(turned[(seconds > 1) & (seconds < 6)]) / toward
    assert 0.3 < speaking < 0.7  # in pauses it listens
    assert np.abs(np.diff(turned)).max() * skeleton.FPS < 120
    others = [edge for edge in range(9) if edge not in skeleton.HEAD]
    assert np.array_equal(looking.directions[:, others], straight.directions[:, others])
    assert np.array_equal(looking.face.weights[:, 16:18], straight.face.weights[:, 16:18])  # eyes go with the head
    again = session.synthesize(provenance.request_from_meta(looking.meta, anna, hears=bert)).motions[0]
    assert np.array_equal(again.directions, looking.directions)


def test_the_other_recording_may_begin_later(session, dialogue, tmp_path):
    anna, bert = dialogue
    sound = audio.load(bert)
    write_wav(tmp_path / "late.wav", sound[3 * audio.SAMPLE_RATE :])
    together = session.synthesize(Request(anna, seed=1, hears=bert)).motions[0]
    later = session.synthesize(Request(anna, seed=1, hears=tmp_path / "late.wav", later=3.0)).motions[0]
    assert np.array_equal(later.directions, together.directions)


@pytest.mark.parametrize("wrong", [{"toward": 120.0}, {"toward": float("nan")}, {"later": float("inf")}])
def test_nobody_stands_or_begins_nowhere(wrong):
    with pytest.raises(UsageError):
        Request("a.wav", **wrong)
