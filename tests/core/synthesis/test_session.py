import numpy as np
import pytest
from sounds import write_wav

torch = pytest.importorskip("torch")

from rounding import bound  # noqa: E402
from s2ag.core.errors import Cancelled, UnknownStyle, UsageError  # noqa: E402
from s2ag.core.model import checkpoint_metadata  # noqa: E402
from s2ag.core.motion import rest, skeleton  # noqa: E402
from s2ag.core.sound import audio  # noqa: E402
from s2ag.core.synthesis.session import Request, Session  # noqa: E402

FPS = skeleton.FPS


@pytest.fixture(scope="module")
def session():
    if not checkpoint_metadata.DEFAULT_CHECKPOINT.is_file():
        pytest.skip("no default checkpoint is shipped yet")
    return Session()


@pytest.fixture(scope="module")
def hello(session, examples):
    return session.synthesize(Request(examples / "hello.flac", transcript=examples / "hello.txt", takes=3, seed=7))


@pytest.fixture(scope="module")
def long_speech(examples, tmp_path_factory):
    """Forty seconds: the shipped recording three times with six seconds of digital silence before the last."""
    sound = audio.load(examples / "hello.flac")
    path = tmp_path_factory.mktemp("audio") / "länger.wav"
    samples = np.concatenate([sound, sound, np.zeros(6 * audio.SAMPLE_RATE, np.float32), sound])
    write_wav(path, samples)
    return path


def angles(a, b):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(-1)))


def rest_pose(session):
    return np.array(next(speaker["rest"] for speaker in session.styles() if speaker["default"]))


def speeds(directions):
    """Degrees a second between neighbouring frames, (frames - 1, 9)."""
    return angles(directions[1:], directions[:-1]) * FPS


def test_a_recording_becomes_unit_directions_of_its_length(hello, examples):
    seconds = len(audio.load(examples / "hello.flac")) / audio.SAMPLE_RATE
    for motion in hello.motions:
        assert motion.directions.shape == (int(seconds * FPS), 9, 3) and motion.directions.dtype == np.float32
        np.testing.assert_allclose(np.linalg.norm(motion.directions, axis=-1), 1, atol=1e-5)
    assert [word for word, _, _ in hello.words][:2] == ["Hello", "I"]
    assert set(hello.seconds) >= {"read audio", "align words", "extract MFCC", "generate"}


def test_performances_of_one_recording_in_one_batch_are_those_made_singly(session, hello, examples):
    recording = {"audio": examples / "hello.flac", "transcript": examples / "hello.txt"}
    names = [speaker["name"] for speaker in session.styles()]
    requests = [Request(**recording, takes=3, seed=7), Request(**recording, style=names[-1], pose=skeleton.MEAN, mirror=True)]
    together = session.synthesize_all(requests)
    assert [len(result.motions) for result in together] == [3, 1]
    singly = [*hello.motions, *session.synthesize(requests[1]).motions]
    for one, other in zip([motion for result in together for motion in result.motions], singly, strict=True):
        np.testing.assert_allclose(one.directions, other.directions, atol=bound(session.checkpoint))
        assert one.meta == other.meta and one.words == other.words
    with pytest.raises(UsageError, match="one recording"):
        session.synthesize_all([requests[0], Request(examples / "hello.flac", text="other words")])


def test_same_request_same_bytes_and_other_seeds_and_takes_differ(session, hello, examples):
    again = session.synthesize(Request(examples / "hello.flac", transcript=examples / "hello.txt", takes=3, seed=7))
    for first, second in zip(hello.motions, again.motions, strict=True):
        assert first.directions.tobytes() == second.directions.tobytes() and first.meta == second.meta
    assert not np.allclose(hello.motions[0].directions, hello.motions[1].directions, atol=1e-3)
    other = session.synthesize(Request(examples / "hello.flac", transcript=examples / "hello.txt", style="random", seed=8))
    assert not np.allclose(hello.motions[0].directions, other.motions[0].directions, atol=1e-3)


def test_provenance_names_what_it_was_made_from(session, hello):
    meta = hello.motions[1].meta
    assert meta["seed"] == 7 and meta["take"] == 1 and meta["checkpoint"] == session.checkpoint.hash
    assert list(meta["style"].values()) == [1.0]


@pytest.mark.slow
def test_speakers_differ(session, examples):
    made = {
        style["name"]: session.synthesize(Request(examples / "hello.flac", style=style["name"])).motions[0].directions
        for style in session.styles()
    }
    assert len(made) >= 6
    names = list(made)
    apart = [angles(made[a], made[b])[:, [4, 5, 7, 8]].mean() for i, a in enumerate(names) for b in names[:i]]
    assert np.median(apart) > 5


def test_audio_alone_still_gestures(session, examples):
    result = session.synthesize(Request(examples / "hello.flac"))
    assert not result.words
    forearms = speeds(result.motions[0].directions)[:, [5, 8]]
    assert np.percentile(forearms, 90) > 20


@pytest.mark.slow
def test_seams_cannot_be_seen(session, long_speech):
    """At the joins of windows the fastest edge is no faster than elsewhere, and acceleration is in the clip's range.

    Joins are a tenth of a take: that the fastest moment of one lies there says nothing, but of several."""
    from s2ag.core.model import windows

    ratios = []
    for seed in range(5):
        directions = session.synthesize(Request(long_speech, seed=seed)).motions[0].directions
        window, seeds = session.checkpoint.window
        joins = windows.window_starts(len(directions), window, seeds)[1:]
        assert len(joins) >= 3
        near = np.unique([join + offset for join in joins for offset in range(-1, seeds + 1)])
        speed, jolt = speeds(directions).max(1), np.abs(np.diff(directions, 2, axis=0)).max((1, 2))
        away = np.setdiff1d(np.arange(len(jolt)), near)
        ratios.append([track[near].max() / track[away].max() for track in (speed, jolt)])
    assert np.all(np.median(ratios, axis=0) <= 1.05), ratios


def test_hands_rest_in_silence_and_are_never_frozen(session, long_speech, examples):
    directions = session.synthesize(Request(long_speech)).motions[0].directions
    spoken = 2 * len(audio.load(examples / "hello.flac")) / audio.SAMPLE_RATE
    quiet = slice(int((spoken + 3) * FPS), int((spoken + 5) * FPS))
    assert angles(directions[quiet], rest_pose(session))[:, [4, 5, 7, 8]].max() < 8
    assert speeds(directions).max(1).min() > 0.05


def test_a_given_pose_starts_the_performance_and_mirroring_mirrors(session, examples):
    raised = rest.REST.copy()
    raised[8] = skeleton.normalize(np.array([0.2, 0.5, 0.7], np.float32))
    plain, posed, mirrored = (
        session.synthesize(Request(examples / "hello.flac", **options)).motions[0].directions
        for options in ({}, {"pose": raised}, {"mirror": True})
    )
    assert angles(posed[0, 8], raised[8]) < 8
    assert angles(plain[0], rest_pose(session)).max() < 8
    np.testing.assert_array_equal(mirrored, skeleton.mirror(plain))


def test_impossible_requests_are_refused_in_one_sentence(session, examples):
    poses = [{"pose": np.zeros(3)}, {"pose": np.zeros((9, 3))}, {"pose": [[1, 2], [3]]}, {"pose": [["a"] * 3] * 9}]
    for options in [{"takes": 0}, {"intensity": -1}, {"seed": -1}, {"text": "a", "transcript": "b"}, *poses]:
        with pytest.raises(UsageError):
            Request(examples / "hello.flac", **options)
    with pytest.raises(UnknownStyle):
        session.synthesize(Request(examples / "hello.flac", style="nobody"))
    with pytest.raises(Cancelled):
        session.synthesize(Request(examples / "hello.flac"), cancelled=lambda: True)
