"""Performances drawn from noise: seeds, kept frames, tiles without seams, wishes, and all that styles could do before."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from bodies import degrees
from rounding import bound
from s2ag.core import styles
from s2ag.core.errors import Cancelled, UsageError
from s2ag.core.model.noise import noise
from s2ag.core.motion import hand_channels, limits, rest, skeleton
from s2ag.core.motion.motion import Motion
from s2ag.core.sampling import sheet as sheets
from s2ag.core.synthesis import flow_sampling, generation, hand_synthesis, stroke_conditions, style_sequence
from s2ag.core.synthesis.request import Request
from s2ag.core.synthesis.session import Session
from s2ag.core.words import hints


@pytest.fixture(scope="module")
def session(flow_checkpoint):
    return Session(flow_checkpoint)


@pytest.fixture(scope="module")
def voice(examples):
    return examples / "hello.flac"


@pytest.fixture(scope="module")
def heard(session, voice):
    """The recording as the network hears it."""
    from s2ag.core.sound import audio
    from s2ag.core.synthesis import features
    from s2ag.core.synthesis.stages import Stages

    return features.hear(session, Request(voice), audio.load(voice), Stages(lambda stage, value: None, lambda: False))


@pytest.fixture(scope="module")
def plain(session, voice):
    return session.synthesize(Request(voice)).motions[0].directions


def made(session, voice, **options):
    return session.synthesize(Request(voice, **options)).motions[0].directions


def angles(a, b):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(-1)))


def some_poses(count, seed=3):
    rng = np.random.default_rng(seed)
    poses = skeleton.normalize(rest.REST + 0.15 * rng.standard_normal((count, 9, 3)))
    return limits.enforce_limits(poses.astype(np.float32))


def test_the_same_request_is_the_same_to_the_bit_and_seeds_differ(session, voice, plain):
    assert made(session, voice).tobytes() == plain.tobytes()
    arms = angles(made(session, voice, seed=1), plain)[:, list(skeleton.ARM_EDGES)]
    assert arms.mean() > 3  # of a network that has learned nothing


def test_a_take_is_the_same_whoever_performs_beside_it(session, voice, plain):
    together = session.synthesize(Request(voice, takes=3)).motions
    alone = [session.synthesize(Request(voice, take=take)).motions[0] for take in range(3)]
    for one, other in zip(together, alone, strict=True):
        assert one.directions.tobytes() == other.directions.tobytes() and one.meta == other.meta
    assert together[0].directions.tobytes() == plain.tobytes()


THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
OTHERS = [("numpy", dict.fromkeys(THREADS, number)) for number in ("1", "2")]
OTHERS += [("numpy", {"OPENBLAS_CORETYPE": core}) for core in ("Prescott", "Nehalem", "Haswell")]
OTHERS += [("torch", dict.fromkeys(THREADS, "1"))]
OTHERS += [("torch", {"ONEDNN_MAX_CPU_ISA": "SSE41", "MKL_ENABLE_INSTRUCTIONS": "SSE4_2", **dict.fromkeys(THREADS, "2")})]
"""Numbers of threads, and CPUs as old as the libraries know: no fused products, half the width of registers."""


@pytest.mark.slow
@pytest.mark.parametrize(("backend", "other"), OTHERS, ids=[f"{name}-{[*other.values()][0]}" for name, other in OTHERS])
def test_threads_and_cpus_change_no_more_than_rounding(flow_checkpoint, session, voice, plain, tmp_path, backend, other):
    command = [sys.executable, "-m", "s2ag", "synth", voice, "--no-transcript", "--checkpoint", flow_checkpoint]
    out = tmp_path / "other.npz"
    subprocess.run([*command, "--backend", backend, "-o", out], env={**os.environ, **other}, check=True)
    np.testing.assert_allclose(Motion.load(out).directions, plain, rtol=0, atol=bound(session.checkpoint))


@pytest.fixture(scope="module")
def longer(heard):
    """What would be heard of a longer recording: noise."""
    rng, features = np.random.default_rng(0), heard.features
    prosody = rng.standard_normal((3000, features.prosody.shape[1])).astype(np.float32)
    told = {**vars(features), "prosody": prosody, "mfcc": np.tile(features.mfcc, (60, 1))}
    return lambda start, stop: type(features).slice(SimpleNamespace(**told), start, stop)


def test_tiles_join_without_seams(session, voice, longer):
    network = session.checkpoint.network
    cast = [style_sequence.from_request(session.checkpoint, Request(voice, takes=2, kept=([700], some_poses(1))))]
    frames = 1500
    whole = flow_sampling.sample(network, longer, cast, [None], frames)[0]
    tiled = flow_sampling.sample(network, longer, cast, [None], frames, tile=144)[0]
    np.testing.assert_allclose(tiled, whole, rtol=0, atol=bound(session.checkpoint))
    assert whole.shape == (2, frames, 9, 3) and np.abs(np.linalg.norm(whole, axis=-1) - 1).max() < 1e-5


@pytest.mark.parametrize("frames", [2, 13, 97])
def test_any_length(session, voice, heard, frames):
    cast = [style_sequence.from_request(session.checkpoint, Request(voice))]
    directions, extras = flow_sampling.sample(session.checkpoint.network, heard.features.slice, cast, [None], frames)
    assert directions.shape == (1, frames, 9, 3) and extras.shape == (1, frames, session.checkpoint.config.extras)


@pytest.mark.parametrize("more", [{}, {"mirror": True}, {"intensity": 1.5}, {"intensity": 0.0}])
def test_frames_are_kept_exactly_wherever_they_lie(session, voice, plain, more):
    start, end, *between = some_poses(5)
    frames = np.array([30, 31, 50])
    wanted = {0: start, len(plain) - 1: end, **dict(zip(frames.tolist(), between, strict=True))}
    performed = made(session, voice, pose=start, end_pose=end, kept=(frames, np.array(between)), **more)
    for frame, pose in wanted.items():
        np.testing.assert_array_equal(performed[frame], pose)
    assert angles(performed[3], plain[3]).max() > 1  # they lead on


def test_a_phrase_is_performed_anew_between_frames_that_stay(session, voice, plain):
    gap = slice(40, 70)
    kept = np.setdiff1d(np.arange(len(plain)), np.arange(gap.start, gap.stop))
    again = made(session, voice, seed=9, kept=(kept, plain[kept]))
    np.testing.assert_array_equal(again[kept], plain[kept])
    assert angles(again[gap], plain[gap])[10:20].mean() > 2
    speed, usual = (np.abs(np.diff(one, axis=0)).max((1, 2)) for one in (again, plain))
    assert speed.max() < 1.5 * usual.max()


def test_what_is_known_is_not_computed(session, voice, longer, monkeypatch):
    frames = 3000
    gap = np.arange(1500, 1530)
    kept = np.setdiff1d(np.arange(frames), gap)
    request = Request(voice, kept=(kept, np.broadcast_to(rest.REST, (len(kept), 9, 3))))
    network = session.checkpoint.network
    [(start, stop, low, high)] = flow_sampling._tiles(network, gap, flow_sampling.TILE)
    assert (start, stop) == (1500, 1530) and high - low < 30 + 2 * (network.velocity_reach + network.hears) + 25
    cast = [style_sequence.from_request(session.checkpoint, request)]
    little = flow_sampling.sample(network, longer, cast, [None], frames)[0]
    monkeypatch.setattr(flow_sampling, "_tiles", lambda network, free, tile: [(1500, 1530, 0, 3000)])
    everything = flow_sampling.sample(network, longer, cast, [None], frames)[0]
    np.testing.assert_allclose(little, everything, rtol=0, atol=bound(session.checkpoint))


def test_impossible_frames_are_refused(session, voice):
    poses = some_poses(2)
    for kept in (([1], poses), ([1, 1], poses), ([-1, 2], poses), ([0.5, 1], poses), ([1, 2], poses * 0), 3):
        with pytest.raises(UsageError):
            Request(voice, kept=kept)
    with pytest.raises(UsageError):
        Request(voice, end_pose=np.zeros((9, 3)))
    with pytest.raises(UsageError, match="cannot be kept"):
        session.synthesize(Request(voice, kept=([5, 10**6], poses)))


def test_noise_is_that_of_a_frame():
    whole = noise(3, (1, ()), 0, 700, 27)
    np.testing.assert_array_equal(noise(3, (1, ()), 250, 530, 27), whole[250:530])
    assert abs(whole.mean()) < 0.02 and abs(whole.std() - 1) < 0.02
    for other in (noise(4, (1, ()), 0, 700, 27), noise(3, (2, ()), 0, 700, 27), noise(3, (1, ((1, 1.0),)), 0, 700, 27)):
        assert abs((other * whole).mean()) < 0.03


def test_a_variation_is_as_far_as_it_is_asked_to_be(session, voice, plain):
    def apart(spread):
        return angles(made(session, voice, spread=spread), plain)[:, list(skeleton.ARM_EDGES)].mean()

    near, half, far = apart(0.1), apart(0.4), apart(1.0)
    assert 0 < near < half < far
    assert np.corrcoef(noise(0, (0, ((1, 0.2),)), 0, 99, 27).ravel(), noise(0, (0, ()), 0, 99, 27).ravel())[0, 1] > 0.9
    steps = Request(voice, near=((1, 0.1),), spread=0.2, step=3).identities
    assert steps == styles.take_identities(0, 1, ((1, 0.1),), 0.2, 3)


@pytest.mark.parametrize("style", ["calm one > lively one", "calm one:0.5+lively one:0.5", "random"])
def test_walks_blends_and_random_styles(session, voice, plain, style):
    performed = made(session, voice, style=style)
    assert performed.shape == plain.shape and np.abs(performed - plain).max() > 1e-3
    np.testing.assert_array_equal(made(session, voice, style=style, mirror=True), skeleton.mirror(performed))


@pytest.mark.parametrize("control", [{"affect": {"arousal": 1.0}}, {"rate": 1.0}, {"hand": -1.0}, {"intensity": 2.0}])
def test_controls_steer(session, voice, plain, control):
    assert np.abs(made(session, voice, **control) - plain).max() > 1e-3


@pytest.mark.parametrize("number", [2, 5])
def test_a_cell_of_a_sheet_is_made_again_exactly(session, voice, tmp_path, flow_checkpoint, number):
    request = Request(voice, seed=4, takes=3, intensity=0.8, hand=-1.0)
    sheet, motions, _ = sheets.sample(session, request, ["calm one", "calm one > lively one"])
    sheet.save(tmp_path / "sheet.json")
    wanted = Request(**sheets.request_of_cell(f"{tmp_path / 'sheet.json'}:{number}", flow_checkpoint))
    again = session.synthesize(wanted).motions[0]
    np.testing.assert_array_equal(again.directions, motions[number - 1].directions)
    assert (again.meta["seed"], again.meta["take"]) == (4, (number - 1) % 3)


def test_what_is_remembered_is_what_would_be_made(flow_checkpoint, session, voice):
    warm = Session(flow_checkpoint, remember=True)
    for changes in ({}, {"seed": 2}, {"seed": 2, "intensity": 0.5}, {"seed": 2, "end_pose": some_poses(1)[0]}, {"take": 1}, {}):
        np.testing.assert_array_equal(made(warm, voice, **changes), made(session, voice, **changes))


def test_progress_rises_to_one_and_cancelling_stops(session, voice, heard):
    told, cast = [], [style_sequence.from_request(session.checkpoint, Request(voice, takes=3))]
    generation.generate(session.checkpoint, heard, cast, told.append)
    assert told == sorted(told) and told[-1] == 1
    assert len(told) > session.checkpoint.config.flow_steps  # those of this thread, others work beside it
    with pytest.raises(Cancelled):
        generation.generate(session.checkpoint, heard, cast, cancelled=lambda: True)


def test_a_take_of_other_weights_says_so(session, voice):
    told = session.synthesize(Request(voice, made_by="f00")).warnings
    assert len(told) == 1 and "earlier weights" in told[0]
    assert not session.synthesize(Request(voice, made_by=session.checkpoint.hash)).warnings


def test_hints_are_asked_for_as_strokes_where_the_network_knows_them(session, voice):
    text = voice.with_suffix(".txt").read_text()
    unmarked, marked = (session.synthesize(Request(voice, text=one)) for one in (text, "{me} " + text))
    assert unmarked.words == marked.words and not marked.warnings
    assert np.abs(unmarked.motions[0].directions - marked.motions[0].directions).max() > 1e-3


def test_strokes_of_hints():
    words = [("so", 0.0, 0.4), ("well", 0.5, 1.0), ("we", 1.0, 2.0), ("go", 3.0, 3.5)]
    wishes = hints.HintEffects(gestures={1: ("me", 0.0), 2: ("point", -1.0), 3: ("list", 0.0)}, rests=((2.2, 2.8),))
    meanings = ["beat", "me", "there", "big"]
    assert stroke_conditions.conditioned_words(wishes, meanings) == {1, 2} and not stroke_conditions.conditioned_words(
        wishes, []
    )
    assert [text for text, *_ in hints.network_words(words, wishes, True, frozenset({1, 2}))] == ["so", "well", "we", "first"]
    channels = stroke_conditions.stroke_channels(wishes, words, meanings, 60)
    assert channels.shape == (60, 7)
    assert channels[10, 6] == 2 and tuple(channels[10, 3:5]) == (0, 1)  # "me", the right hand
    assert channels[21, 6] == 3 and tuple(channels[21, 3:5]) == (1, 0) and channels[21, 2] > 0.9  # "there", the left
    assert channels[36, :2].tolist() == [1, 0] and not channels[50].any()
    assert tuple(stroke_conditions.stroke_channels(wishes, words, meanings, 60, hand=-1)[10, 3:5]) == (1, 0)
    assert stroke_conditions.stroke_channels(hints.HintEffects(), words, meanings, 60) is None
    assert stroke_conditions.stroke_channels(replace(wishes, rests=()), words, [], 60) is None


def test_hands_rest_in_silence_and_breathe(session, tmp_path, voice):
    from s2ag.core.sound import audio
    from sounds import write_wav

    sound = audio.load(voice)
    write_wav(tmp_path / "silence.wav", np.concatenate([sound, np.zeros(8 * audio.SAMPLE_RATE, np.float32)]))
    performed = made(session, tmp_path / "silence.wav", seed=5)
    quiet = performed[-4 * 15 :]
    assert angles(quiet, rest.REST)[:, list(skeleton.ARM_EDGES)].max() < 8
    assert np.linalg.norm(np.diff(performed, axis=0), axis=-1).max(1).min() > 1e-5
    assert not limits.backward_elbows(performed).any()


def test_every_speaker_has_noise_of_his_own_and_blends_lead_from_one_to_the_other():
    one, other, blend = (noise(0, (0, ()), 0, 500, 27, who) for who in ({"a": 1.0}, {"b": 1.0}, {"a": 0.5, "b": 0.5}))
    assert abs(np.corrcoef(one.ravel(), other.ravel())[0, 1]) < 0.05
    for own in (one, other):
        assert 0.65 < np.corrcoef(own.ravel(), blend.ravel())[0, 1] < 0.76
    assert abs(blend.std() - 1) < 0.02
    np.testing.assert_array_equal(one, noise(0, (0, ()), 0, 500, 27, {"a": 1.0, "b": 0.0}))


def test_what_is_said_is_shown_and_meaning_turns_it_down(examples, tmp_path):
    words = [{"word": text, "start": 3 + k, "end": 3.3 + k} for k, text in enumerate(["it", "was", "huge", "no", "way"])]
    transcript = tmp_path / "said.json"
    transcript.write_text(json.dumps({"words": words}), "utf-8")
    shipped = Session(cache="off")
    asked = [Request(examples / "hello.flac", transcript=transcript, seed=3, meaning=meaning) for meaning in (0.0, 1.0)]
    results = [shipped.synthesize(request).motions[0] for request in asked]
    points = [skeleton.to_positions(motion.directions)[round(5.3 * skeleton.FPS)] for motion in results]
    apart = [float(np.linalg.norm(each[6] - each[9])) for each in points]
    assert apart[1] > 0.7 and results[1].meta["meaning"] == 1.0
    first = slice(0, round(3.5 * skeleton.FPS))  # the hands set out for it a second before it is said
    np.testing.assert_array_equal(results[0].directions[first], results[1].directions[first])


@pytest.fixture(scope="module")
def handed(tmp_path_factory):
    """A session with a small network of random weights that draws hands beside the arms."""
    torch = pytest.importorskip("torch", reason="the engine is not installed")
    from s2ag.core.model import checkpoint
    from s2ag.core.model.config import ModelConfig
    from s2ag.core.model.flow import FlowGenerator

    torch.manual_seed(3)
    network = FlowGenerator(ModelConfig.flow(speakers=2, flow_size=48, flow_condition=32, extras=hand_channels.SIZE))
    for name, parameter in network.named_parameters():
        if "denoiser" in name:
            torch.nn.init.normal_(parameter, std=0.1)
    path = tmp_path_factory.mktemp("handed") / "handed.safetensors"
    speakers = [{"name": "a", "chance": 0.0}, {"name": "b"}]
    checkpoint.save(path, network, None, {"speakers": speakers, "training": {"settings": {"frames": 64, "seed_frames": 10}}})
    return Session(path)


def test_chance_has_its_way_as_far_as_the_performer_lets_it(handed, voice, heard):
    def apart(style):
        casts = [[style_sequence.from_request(handed.checkpoint, Request(voice, style=style, seed=seed))] for seed in (1, 2)]
        one, other = (
            flow_sampling.sample(handed.checkpoint.network, heard.features.slice, cast, [None], 97)[0][0] for cast in casts
        )
        return np.abs(one - other).max(axis=(1, 2))

    assert apart("a").max() == 0 < apart("b")[1:].min()
    walk = apart("a > b")
    assert 0 < walk[1:24].max() < walk[-24:].max()


def test_hands_are_drawn_with_the_arms_where_the_network_knows_them(handed, voice):
    one, other = (handed.synthesize(Request(voice, style="b", seed=seed, hands=1.0)).motions[0] for seed in (1, 2))
    assert degrees(one.hands.palms, other.hands.palms).mean() > 5
    without = handed.synthesize(Request(voice, style="b", seed=1, hands=0.0)).motions[0]
    np.testing.assert_array_equal(without.directions, one.directions)
    assert without.hands is None


def test_frames_that_are_given_have_hands_as_they_hang_on_such_arms(handed, voice):
    frames, poses = np.arange(20, 30), np.broadcast_to(rest.REST, (10, 9, 3))
    motion = handed.synthesize(Request(voice, kept=(frames, poses), hands=1.0)).motions[0]
    hanging = hand_synthesis.hanging_hands(poses)
    assert degrees(motion.hands.palms[frames], hanging.palms).max() < 0.1
    np.testing.assert_allclose(motion.hands.shape[frames], hanging.shape, atol=0.01)
