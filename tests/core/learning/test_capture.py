"""Motion from films: cleaning of what an estimator saw, films and their cuts, what is told where the estimator is missing."""

import subprocess
from pathlib import Path

import numpy as np
import pytest
from s2ag.core.cli.main import main
from s2ag.core.errors import CorpusUnreadable, EngineMissing, UsageError
from s2ag.core.files import sha256
from s2ag.core.learning.capture import body, estimator, film, filmed, hands, motion, people, smoothing, trial, weights
from s2ag.core.learning.capture.landmarks import Landmarks
from s2ag.core.learning.own_style import filming
from s2ag.core.motion import skeleton
from s2ag.core.motion.motion import Motion
from seen_bodies import COUNT, RATE, apart, performed, seen

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture
def exact(monkeypatch, tmp_path):
    """Without what was learned about an estimator that errs: the one of these tests does not."""
    monkeypatch.setattr(weights, "FILE", tmp_path / "none.npz")
    weights.forget()
    yield
    monkeypatch.undo()
    weights.forget()


@pytest.mark.parametrize("turn", [0, 30])
def test_arms_are_those_that_were_seen_wherever_the_camera_stands(exact, turn):
    directions = performed()
    made, notes = motion.clean(seen(directions, turn))
    assert notes == [] and made.meta["unseen"] == [] and made.fps == 15
    assert np.percentile(apart(made, directions), 95) < 6


def test_a_camera_whose_place_is_told_is_not_estimated():
    """Also by the network and its map of views, which a body without a face misleads."""
    directions = performed()
    found = seen(directions, 30)
    told, guessed = (motion.clean(found, camera)[0] for camera in ((30.0, 0.0), None))
    assert np.median(apart(told, directions)) < np.median(apart(guessed, directions))
    assert told.meta["camera"] == [30.0, 0.0] and told.meta["gaze"] is None
    pose = body.read(found, np.tile(np.eye(3), (COUNT, 1, 1)))
    assert pose.camera == pytest.approx((0.0, 0.0))


def test_the_estimated_place_of_the_camera_is_kept(exact):
    assert motion.clean(seen(performed(), 30))[0].meta["camera"][0] == pytest.approx(30, abs=1)


def test_a_point_that_leaps_and_noise_do_not_move_the_arm(exact):
    directions, random = performed(), np.random.default_rng(1)
    found = seen(directions)
    found.world[:] += random.normal(0, 0.01, found.world.shape)
    found.world[60, 15] += [0.3, -0.4, 0.3]
    made, _ = motion.clean(found)
    assert apart(made, directions)[28:33].max() < 12
    speed = np.linalg.norm(np.diff(made.directions[:, 5], axis=0), axis=-1).max() * 15
    assert speed == pytest.approx(0.8 * 2 * np.pi, rel=0.35)  # the stroke is as quick as it was


def test_what_is_not_seen_rests_and_is_told(exact):
    found = seen(performed())
    found.pose[40:100, 15, 3] = 0.1
    made, notes = motion.clean(found)
    (span,) = made.meta["unseen"]
    assert span == pytest.approx([40 / RATE, 100 / RATE], abs=0.15) and "seconds show no body" in notes[0]
    rest = skeleton.REST[list(skeleton.ARM_EDGES)]
    assert np.allclose(made.directions[35, skeleton.ARM_EDGES][:2], rest[:2], atol=0.05)
    found.pose[:, 15, 3] = 0.1
    with pytest.raises(CorpusUnreadable):
        motion.clean(found)


def test_a_cut_parts_scenes_with_cameras_of_their_own(exact):
    first, second = seen(performed(60)), seen(performed(60), 25)
    changes = np.zeros(COUNT)
    changes[60] = 0.4
    names = ("pose", "world", "left", "right", "face")
    joined = {name: np.concatenate([getattr(first, name), getattr(second, name)]) for name in names}
    made, notes = motion.clean(seen(performed(), changes=changes, **joined))
    assert made.meta["cuts"] == [2.0] and "1 cuts" in notes[0]
    truth = np.concatenate([performed(60), performed(60)])
    assert np.percentile(apart(made, truth), 90) < 6


def test_hands_are_read_as_they_are_held():
    """A flat left hand that points ahead, its palm down, as a picture shows it."""
    flat = np.zeros((21, 3))
    for finger, across in enumerate((0.03, 0.01, -0.01, -0.03)):
        for joint in range(4):
            flat[5 + 4 * finger + joint] = [across, 0, 0.1 + 0.03 * joint]  # the index finger of a left hand lies at +x
    flat[1:5] = [[0.02 + 0.015 * joint, 0, 0.03 + 0.02 * joint] for joint in range(4)]
    along, palm = hands.frame(flat[None], left=True)
    assert np.allclose(along, [0, 0, 1], atol=1e-6) and np.allclose(palm, [0, 1, 0], atol=1e-6)
    shape = hands.shape(flat[None], left=True)[0]
    assert np.abs(shape[:8]).max() < 25 and shape[-1] < 25
    mirrored = flat * [-1, 1, 1]
    assert np.allclose(hands.frame(mirrored[None], left=False)[1], [0, 1, 0], atol=1e-6)
    assert np.allclose(hands.shape(mirrored[None], left=False)[0], shape, atol=1e-6)


def test_smoothing_keeps_a_peak_and_bridges_a_gap():
    times = np.arange(90) / 30
    bump = np.exp(-0.5 * ((times - 1.5) / 0.12) ** 2)[:, None]
    at = np.arange(45) / 15
    values, known = smoothing.resample(times, bump, np.ones(90), np.zeros(90, int), at)
    assert known.all() and values.max() > 0.93
    known[20:24] = False
    filled = smoothing.fill(values, known, np.array([5.0]), 8, 4)
    assert filled[20:24].max() <= values[[19, 24]].max() + 1e-6
    assert smoothing.fill(values, known, np.array([5.0]), 2, 1)[21:23].max() == pytest.approx(5.0)


def test_films_are_read_with_their_times_and_cuts(tmp_path):
    av = pytest.importorskip("av")
    path = tmp_path / "two.mp4"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mpeg4", rate=30)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for number in range(60):
            pixels = np.full((48, 64, 3), 40 if number < 30 else 200, np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(pixels, format="rgb24")))
        container.mux(stream.encode(None))
    pictures = list(film.pictures(path))
    assert len(pictures) == 60 and pictures[45].time == pytest.approx(1.5, abs=0.01)
    assert len(list(film.pictures(path, 10.0, [(0.5, 1.0)]))) in (5, 6)
    small = np.stack([film.thumbnail(picture.pixels) for picture in pictures])
    changes = np.concatenate([[0], np.abs(np.diff(small, axis=0)).mean((1, 2))])
    assert np.flatnonzero(film.is_cut(changes)).tolist() == [30]
    (tmp_path / "none.mp4").write_bytes(b"no film")
    with pytest.raises(CorpusUnreadable):
        film.facts(tmp_path / "none.mp4")


def test_films_of_performers_are_not_made_or_looked_at_again_unless_they_move_otherwise(tmp_path):
    av = pytest.importorskip("av")
    piece = performed(8)[::2].astype(np.float32)
    path = tmp_path / "the-coach-1.mp4"
    Motion(piece).save(path.with_suffix(".npz"))
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mpeg4", rate=30)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for _ in range(8):
            container.mux(stream.encode(av.VideoFrame.from_ndarray(np.zeros((48, 64, 3), np.uint8), format="rgb24")))
        container.mux(stream.encode(None))
    seen(performed(8), film=np.array(sha256(path))).save(path.with_suffix(".seen.npz"))
    made = filming.through_films(tmp_path, {"the coach": [piece]}, None, lambda stage, share: None)
    assert len(made["the coach"]) == 1 and made["the coach"][0].meta["unseen"] == []
    assert np.array_equal(Motion.load(path.with_suffix(".npz")).directions, piece)

    def without_blender(module, job, progress):
        raise EngineMissing(module, job)

    other = piece[::-1]
    with pytest.raises(EngineMissing, match="render.capture_films"):
        filming.through_films(tmp_path, {"the coach": [other]}, without_blender, lambda stage, share: None)
    assert not path.exists() and np.array_equal(Motion.load(path.with_suffix(".npz")).directions, other)


def test_strokes_are_counted_for_each_hand_and_each_once():
    """A still right hand loses its strokes, one that trembles makes some up, and a late motion answers none."""
    both = performed(600)[::2]
    both[:, [7, 8]] = (both[:, [4, 5]] * [-1, 1, 1])[np.clip(np.arange(len(both)) - 3, 0, None)]
    count, found, same, extra = trial.count_strokes(both, both)
    assert count == found == same > 60 and extra == 0
    still = both.copy()
    still[:, [7, 8]] = both[0, [7, 8]]
    left = trial.count_strokes(still, still)[0]
    assert 0.4 * count < left < 0.6 * count
    assert trial.count_strokes(both, still) == (count, left, left, 0)
    assert trial.count_strokes(still, both) == (left, left, count, count - left)
    smaller = skeleton.normalize(0.75 * both + 0.25 * both.mean(0))
    assert trial.count_strokes(both, smaller)[1] == count
    late = np.roll(both, 4, axis=0)  # strokes are 7 and 8 frames apart in turn: every other one lies within 3 of the next
    assert 0.4 * count < trial.count_strokes(both, late)[1] < 0.6 * count


def test_films_of_other_characters_have_their_names(tmp_path):
    shots = filmed.plan(tmp_path, [("human", "male"), (str(tmp_path / "Old Man.blend"), "female")])
    assert len(shots) == 12 and shots[0].name == "male-front-studio" and shots[-1].name == "Old Man-aside-dim"
    rows = [
        trial.Row(shot, False, {edge: np.full(9, 5.0) for edge in trial.EDGES}, np.zeros((0, 2)), (10, 9, 8, 2), 1.0)
        for shot in shots
    ]
    lines = trial.table(rows).splitlines()
    assert "| character Old Man (6) | 5.0° | 5.0° | 5.0° | 5.0° | - | 90% of 60 | 25% of 48 | 100% |" in lines


def test_who_speaks_is_chosen_and_who_is_named(tmp_path):
    everyone = []
    for number in range(20):
        faces = [[0.6, 0.2, 0.1, 0.2, 0.02 + 0.03 * (number % 2)], [0.1, 0.2, 0.12, 0.25, 0.02]]
        people._assign(everyone, faces, True)
    everyone.sort(key=lambda one: one.middle[0])
    assert len(everyone) == 2 and people._speaker(everyone) == 1
    left, _, right, _ = people._region(everyone, 1, film.Facts(640, 360, 2.0))
    assert 0.3 < left < 0.55 and right > 0.75
    with pytest.raises(UsageError):
        people._named(3, 2)


def test_without_the_estimator_one_sentence_says_what_to_install(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv(estimator.VARIABLE, str(tmp_path / "nothing"))
    with pytest.raises(EngineMissing) as caught:
        estimator.python()
    assert "pip install mediapipe" in caught.value.remedy
    assert main(["capture", str(tmp_path / "talk.mp4"), "-o", str(tmp_path / "talk.npz")]) == 2
    assert "mediapipe" in capsys.readouterr().err


def test_what_was_seen_is_kept_and_read_again(tmp_path):
    found = seen(performed())
    found.save(tmp_path / "talk.seen.npz")
    again = Landmarks.load(tmp_path / "talk.seen.npz")
    assert np.array_equal(again.pose, found.pose) and str(again.film) == "0"
    Motion(performed().astype(np.float32)).save(tmp_path / "motion.npz")
    with pytest.raises(CorpusUnreadable):
        Landmarks.load(tmp_path / "motion.npz")


def _estimator():
    try:
        python = estimator.python()
    except EngineMissing:
        return "the pose estimator is not installed"
    done = subprocess.run([python, "-I", "-c", "import mediapipe"], capture_output=True)
    return "" if done.returncode == 0 else "the pose estimator cannot be loaded"


def test_a_picture_of_a_person_is_captured_for_real(tmp_path):
    """The still of the documents, as a film of a second that moves to a side; stopped once and gone on with."""
    av = pytest.importorskip("av")
    if reason := _estimator():
        pytest.skip(reason)
    with av.open(str(ROOT / "docs" / "hello.png")) as still:
        pixels = next(still.decode(video=0)).to_ndarray(format="rgb24")
    path, output = tmp_path / "still.mp4", tmp_path / "still.npz"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mpeg4", rate=15, options={"qscale": "2"})
        stream.height, stream.width = (side // 2 * 2 for side in pixels.shape[:2])
        stream.pix_fmt = "yuv420p"
        for _ in range(8):
            cut = np.ascontiguousarray(pixels[: stream.height, : stream.width])
            container.mux(stream.encode(av.VideoFrame.from_ndarray(cut, format="rgb24")))
        container.mux(stream.encode(None))

    def stop(share):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        estimator.look(path, kept=motion.kept_beside(output), progress=stop)
    assert len(Landmarks.load(motion.kept_beside(output))) >= 1
    assert main(["capture", str(path), "-o", str(output), "--no-transcript"]) == 0
    made = Motion.load(output)
    assert len(made.directions) == 8 and made.hands is not None and not motion.kept_beside(output).exists()
    assert made.directions[:, [4, 7], 1].min() > 0.5  # upper arms hang
