"""The data with known shares: what gesture follows from can be found again, and is in the inputs where it is said to be."""

import json
import shutil
import sys

import numpy as np
import pytest
from s2ag.core.learning.shares import gestures, speech

RATE = 16000


@pytest.fixture(scope="module")
def talks():
    """Recordings of every speaker, in which a word is a burst of noise."""
    chance = np.random.default_rng(0)
    sounds = [chance.normal(0, 1, chance.integers(4000, 8000)) for _ in speech.WORDS]
    spoken = [speech.speak(sounds, number % len(speech.VOICES), 0, number) for number in range(48)]
    return spoken, [gestures.sources(one, 0, number) for number, one in enumerate(spoken)]


def test_every_source_moves_the_arms_by_its_share(talks):
    _, made = talks
    factors = gestures.scales([tracks for tracks, _ in made])
    moved = np.concatenate([gestures.arms(gestures.perform(tracks, affect, factors)) for tracks, affect in made])
    moved -= moved.mean(0)
    for name, share in gestures.SHARES.items():
        source = np.concatenate([tracks[name] for tracks, _ in made])
        source -= source.mean(0)
        told = source @ np.linalg.lstsq(source, moved, rcond=None)[0]
        assert told.var(0).sum() / moved.var(0).sum() == pytest.approx(share, abs=0.05), name
    assert sum(gestures.SHARES.values()) == pytest.approx(1)


def test_what_a_motion_knows_of_each_source_is_told_apart(talks):
    pytest.importorskip("torch")
    from s2ag.core.learning.shares.told import told

    _, made = talks
    factors = gestures.scales([tracks for tracks, _ in made])
    real = np.stack([gestures.perform(tracks, affect, factors)[:34] for tracks, affect in made])
    for name in set(gestures.SHARES) - {"chance"}:  # of which bones of unit length tell half
        without = [gestures.perform({**tracks, name: 0 * tracks[name]}, affect, factors)[:34] for tracks, affect in made]
        found = told(np.stack(without), real, 4)
        assert found[name] < 0.3 and all(share > 0.7 for other, share in found.items() if other != name), (name, found)
    assert all(share == 1 for share in told(real, real, 4).values())


def test_one_affect_is_seen_alone_and_one_is_heard_alone(talks):
    spoken, made = talks
    factors = gestures.scales([tracks for tracks, _ in made])
    lean = [gestures.perform(tracks, seen, factors)[:, 0, 0].mean() for tracks, seen in made]
    affect = [seen for _, seen in made]
    assert np.corrcoef(lean, affect)[0, 1] > 0.99
    for heard in ("loudness", "timbre"):
        assert abs(np.corrcoef([getattr(one, heard).mean() for one in spoken], affect)[0, 1]) < 0.4
    timbre, loudness, words = (np.concatenate(parts) for parts in zip(*(
        (one.timbre, one.loudness, [word for word, *_ in one.words]) for one in spoken), strict=True))  # fmt: skip
    assert abs(np.corrcoef(timbre, loudness)[0, 1]) < 0.1 and abs(np.corrcoef(timbre, words)[0, 1]) < 0.1
    assert any(len(set(one.timbre)) > 3 for one in spoken)  # phrases of a recording differ: the given poses do not tell


def test_a_timbre_changes_the_spectrum_and_not_the_level():
    sound = np.random.default_rng(0).normal(0, 0.1, RATE)
    dark, bright = speech.tilted(sound, -1), speech.tilted(sound, 1)
    levels = [np.sqrt(np.square(one).mean()) for one in (sound, dark, bright)]
    assert levels == pytest.approx([levels[0]] * 3)
    power = [np.abs(np.fft.rfft(one)) ** 2 for one in (dark, bright)]
    low, high = (np.array([one[part].sum() for one in power]) for part in (slice(100, 800), slice(3000, 8000)))
    assert low[0] > 4 * low[1] and high[1] > 4 * high[0]


def test_recordings_are_the_same_again_and_never_repeat(talks):
    spoken, _ = talks
    said = [tuple(word for word, *_ in one.words) for one in spoken]
    assert len(set(said)) == len(said) and min(map(len, said)) > 15
    assert all(0 <= start < end <= speech.SECONDS for one in spoken for _, start, end in one.words)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("espeak-ng") is None, reason="espeak-ng speaks the data")
def test_one_command_makes_data_and_table(tmp_path):
    pytest.importorskip("torch")
    pytest.importorskip("librosa")
    from s2ag.core.cli.main import main
    from s2ag.core.learning.metrics.extractor import Extractor

    Extractor().save(tmp_path / "extractor.safetensors")  # nothing is judged here
    few = ["--steps", "2", "--batch", "8", "--share", "0.05", "--seeds", "1", "--draws", "1", "--validate-every", "1"]
    out = tmp_path / "not" / "there"
    command = ["bench", "--setting", "claim-small", "--out", str(out), "--hours", "0.05", "--systems", "s2ag-no-judge", *few]
    assert main([*command, "--extractor", str(tmp_path / "extractor.safetensors")]) == 0
    meta = json.loads((out / "data" / "meta.json").read_text())
    assert meta["source"] == "shares" and [one["name"] for one in meta["speakers"]] == [speech.VOICES[0]]
    split = np.load(out / "data" / "split.npy")
    assert np.bincount(split).tolist() == [8, 1, 1] and "by known shares" in (out / "table.md").read_text()


def test_what_judges_is_asked_for_before_anything_is_made(tmp_path, monkeypatch, capsys):
    pytest.importorskip("torch")
    from s2ag.core.cli.main import main

    monkeypatch.setitem(sys.modules, "librosa", None)  # as where it is not installed
    assert main(["bench", "--setting", "claim-small", "--out", str(tmp_path / "out")]) == 2
    assert "librosa is missing" in capsys.readouterr().err and not (tmp_path / "out").exists()
