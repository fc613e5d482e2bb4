"""Styles of one's own: learned from motion, kept in files, chosen by name or path."""

import json
import wave

import numpy as np
import pytest
from s2ag.core import own_styles, styles
from s2ag.core.cli import main
from s2ag.core.errors import UnknownStyle, UsageError
from s2ag.core.learning.own_style import camera, fit, manner, source, trial
from s2ag.core.model import checkpoint_metadata
from s2ag.core.motion.motion import Motion
from s2ag.core.sound import audio
from s2ag.core.synthesis.request import Request
from s2ag.core.synthesis.session import Session

FAR_APART = "stern", "coach"


@pytest.fixture(scope="module")
def session():
    return Session(cache="off")


@pytest.fixture(scope="module")
def voice(examples, tmp_path_factory):
    """Eight seconds of a voice."""
    path = tmp_path_factory.mktemp("voice") / "voice.wav"
    with wave.open(str(path), "wb") as file:
        file.setparams((1, 2, audio.SAMPLE_RATE, 0, "NONE", ""))
        file.writeframes((audio.load(examples / "hello.flac")[: 8 * audio.SAMPLE_RATE] * 32000).astype("<i2").tobytes())
    return path


@pytest.fixture(scope="module")
def stage(session, voice):
    return fit.Stage(session, voice)


@pytest.fixture(scope="module")
def acted(session, stage):
    """A minute of motion of two styles."""
    names, known = [one["name"] for one in session.styles()], fit.speakers(session.checkpoint)
    return {name: [stage.show([known[names.index(name)]], seed)[0][0] for seed in range(1, 9)] for name in FAR_APART}


@pytest.fixture
def own(monkeypatch, tmp_path, session):
    """A style in the user's folder, with the manner of nobody."""
    monkeypatch.setenv("S2AG_DATA", str(tmp_path))
    speaker = session.styles()[2]
    more = {"point": session.checkpoint.network.speakers[0][2].tolist(), "weights": session.checkpoint.hash}
    about = {"format": own_styles.FORMAT, "name": "Ada", "description": "", "manner": {}, "seconds": 60}
    path = own_styles.path_of("Ada")
    path.parent.mkdir()
    own_styles.write({**speaker, **more, **about}, path)
    return path


@pytest.mark.slow
def test_what_was_learned_is_nearer_to_its_source(stage, acted, voice, monkeypatch):
    for name, less in {"ROUNDS": 1, "_FIRST": 1, "TRIALS": 6, "_BATCH": 4}.items():
        monkeypatch.setattr(fit, name, less)
    manners = {name: manner.measure(motions) for name, motions in acted.items()}
    for name, other in (FAR_APART, FAR_APART[::-1]):
        found = fit.fit(stage, source.of_motions(name, acted[name], [voice]))
        made = manner.measure([stage.show([found.style], seed)[0][0] for seed in (11, 12, 13)])
        assert manner.apart(made, manners[name]) < manner.apart(made, manners[other])


def test_the_judges_of_a_trial_know_the_styles_themselves(session, voice, acted):
    """On eight seconds a performance: manner and the judge of speakers call other performances of a style by its name."""
    small = trial.Trial(session, [voice], lambda stage, share: None, [*FAR_APART, "shy student"], (600, 700, 800))
    rows = [small.row(name, motions, name) for name, motions in acted.items()]
    assert all(row.near for row in rows)
    other = small.row("stern", acted["coach"])
    assert not other.near and other.likely == "coach" and other.apart["coach"] < other.apart["stern"]
    first, second = trial.table(rows).splitlines()[2:]
    assert first.startswith("| stern | stern | ") and second.endswith("| coach |")


def test_what_a_film_adds_is_taken_back_and_what_it_hides_is_left_out(acted, voice, stage, monkeypatch):
    """A film that slows all hands alike: what others lost is given back, and posture is that of the styles alike."""
    figures = {name: manner.measure(motions) for name, motions in acted.items()}
    filmed = {name: {**one, "speed": one["speed"] - 0.17, "lean": one["lean"] + 9} for name, one in figures.items()}
    added = camera.changes([(filmed["stern"], figures["stern"]), ({**filmed["stern"], "open": 9.0}, figures["stern"])])
    assert added["speed"] == pytest.approx((1.0, 2.0, 0.0)) and "lean" not in added
    heard = source.of_motions("coach", acted["coach"], [voice])
    again = source.of_film(heard._replace(manner=filmed["coach"]), {**added, "open": (1.0, 0.0, 30.0)})
    assert again.manner["speed"] == pytest.approx(figures["coach"]["speed"]) and "lean" not in again.manner
    assert again.trust["speed"] == pytest.approx(1.0) and again.trust["open"] < 0.01
    assert manner.apart(again.manner, figures["coach"], again.trust) < 1e-6
    for name, less in {"ROUNDS": 0, "_FIRST": 1, "_BATCH": 1}.items():
        monkeypatch.setattr(fit, name, less)
    others = np.tile([*figures["stern"].values()], (24, 1))
    others[7] = [*{**figures["coach"], "lean": 40.0, "open": 3.0}.values()]
    monkeypatch.setattr(stage, "known", others / fit._SCALES)
    found = fit.fit(stage, again)
    assert found.shares.argmax() == 7 and np.allclose(found.style.rest, fit.speakers(stage.checkpoint)[7].rest, atol=0.1)


def test_films_of_the_still_are_read_with_another_factor_than_those_of_the_lively(acted):
    """A camera that takes a fifth of all deviations and trembles is undone, the more surely the more films differ."""
    figures = manner.measure(acted["coach"])
    pairs = []
    for more in (-8.0, -3.0, 0.0, 4.0, 7.0):
        true = {**figures, "speed": figures["speed"] + more * manner.FIGURES["speed"]}
        pairs.append(({**true, "speed": figures["speed"] + (0.8 * more - 1) * manner.FIGURES["speed"]}, true))
    added = camera.changes(pairs)
    assert added["speed"][0] == pytest.approx(1.2, abs=0.06) and added["speed"][2] < 0.6
    for seen, true in pairs:
        assert camera.undone(seen, added)["speed"] == pytest.approx(true["speed"], abs=0.6 * manner.FIGURES["speed"])
    assert set(camera.CHANGES) == set(manner.FIGURES) - set(camera.UNKNOWN)


def test_a_level_camera_tells_how_the_head_is_held(acted):
    """Arms turn back by what the estimated camera is not level, and the face's usual angle becomes a bow of the head."""
    taken = acted["coach"][0]
    motion = Motion(taken, meta={"camera": [0.0, -6.0], "gaze": 9.0})
    level, again = camera.levelled(motion), camera.levelled(Motion(taken, meta={"camera": [0.0, 0.0], "gaze": 0.0}))
    np.testing.assert_allclose(again, taken, atol=1e-6)
    angle = np.arctan2(level[..., 2], -level[..., 1]) - np.arctan2(taken[..., 2], -taken[..., 1])
    angle = np.degrees((angle + np.pi) % (2 * np.pi) - np.pi)
    np.testing.assert_allclose(np.abs(angle[:, 3:]), 6, atol=0.01)
    assert manner.measure([level])["nod"] - manner.measure([taken])["nod"] == pytest.approx(3, abs=0.1)
    whole = camera.bowed(taken[0].astype(float), 3.0)
    np.testing.assert_allclose(whole[1:3], level[0, 1:3], atol=1e-6)


def test_a_style_is_numbers_of_a_flat_space_and_back(session):
    for one in fit.speakers(session.checkpoint):
        again = fit._style(fit._numbers(one), one.rest)
        np.testing.assert_allclose(again.point, one.point)
        np.testing.assert_allclose(again.taste / again.taste[3:6].sum(), one.taste / one.taste[3:6].sum(), rtol=0.01)


def test_a_style_is_chosen_by_name_and_by_file(own, session, voice):
    """It performs as the speaker whose numbers it has, but for the random numbers, which are keyed by the name."""
    by_name, by_path = (session.synthesize(Request(voice, style=one)) for one in ("ada", str(own)))
    assert by_name.motions[0].meta["style"] == {"ada": 1.0} and by_path.motions[0].meta["style"] == {str(own): 1.0}
    np.testing.assert_array_equal(by_name.latents, by_path.latents)
    np.testing.assert_allclose(by_name.latents[0, 0], session.checkpoint.network.speakers[0][2], rtol=1e-5)
    mixed = session.synthesize(Request(voice, style=f"{own}:0.5+coach:0.5"))
    assert mixed.motions[0].meta["style"] == {str(own): 0.5, "coach": 0.5}
    assert "Ada" in [one["name"] for one in checkpoint_metadata.describe()["speakers"]]


def test_a_windows_path_has_no_weight():
    assert styles._split(r"C:\styles\ada.json+stern:2") == [(r"C:\styles\ada.json", 1.0), ("stern", 2.0)]


def test_what_is_wrong_with_a_style_is_said(own, session, voice, tmp_path):
    with pytest.raises(UnknownStyle, match="cannot be read"):
        session.synthesize(Request(voice, style=str(tmp_path / "gone.json")))
    with pytest.raises(UnknownStyle, match="no style 'Adda'"):
        session.synthesize(Request(voice, style="Adda"))
    kept = own_styles.read(own)
    own_styles.write({**kept, "weights": "other"}, own)
    with pytest.raises(UnknownStyle, match="other weights"):
        session.synthesize(Request(voice, style="Ada"))
    assert "Ada" not in [one["name"] for one in checkpoint_metadata.describe()["speakers"]]
    for damage in ({"point": ["x"]}, {"rest": [[0, 1]]}, {"seconds": float("nan")}, {"name": ""}, {"answers": 3}):
        own.write_text(json.dumps({**kept, **damage}))
        with pytest.raises(UnknownStyle, match="no style of this version"):
            own_styles.read(own)
    assert own_styles.listed() == []
    for name in ("", "a+b", "a>b", "a:b", "x.json"):
        with pytest.raises(UnknownStyle, match="cannot be the name"):
            own_styles.path_of(name)


def test_what_cannot_be_learned_from_is_said(acted, tmp_path, capsys):
    still = np.repeat(acted["coach"][0][:1], 400, axis=0)
    for motion, complaint in ((still, "Hardly anything moves"), (acted["coach"][0], "too short")):
        Motion(motion).save(tmp_path / "talk.npz")
        with pytest.raises(UsageError, match=complaint):
            source.read([tmp_path / "talk.npz"])
    assert main.main(["learn", str(tmp_path / "gone.npz")]) == 2
    assert main.main(["learn", str(tmp_path / "talk.npz"), "-o", str(tmp_path / "ada.txt")]) == 2
    assert "gone.npz" in (told := capsys.readouterr().err) and "no .json" in told


def test_what_was_not_seen_is_left_out(acted, tmp_path):
    motion = np.concatenate(acted["coach"])
    Motion(motion, meta={"unseen": [[2.0, 5.0], [6.0, 10.0]]}).save(tmp_path / "talk.npz")
    (tmp_path / "talk.wav").write_bytes(b"")
    found = source.read([tmp_path / "talk.npz"])
    assert found.seconds == pytest.approx(len(motion) / 15 - 10, abs=0.1)
    assert found.sounds == [tmp_path / "talk.wav"]
