"""WAV files of every kind that numpy reads, and other sampling rates, against FFmpeg where it is installed."""

import struct
import sys

import numpy as np
import pytest
from s2ag.core.errors import AudioUnreadable
from s2ag.core.sound import audio, resample, wavefile

KINDS = {(1, 8): 2**-7, (1, 16): 2**-15, (1, 24): 2**-23, (1, 32): 1e-7, (3, 32): 1e-9, (3, 64): 1e-7}


def encoded(samples, kind):
    tag, bits = kind
    if tag == 3:
        return samples.astype(f"<f{bits // 8}").tobytes()
    whole = np.round(samples.astype(float) * 2 ** (bits - 1)).clip(-(2 ** (bits - 1)), 2 ** (bits - 1) - 1).astype("<i8")
    whole += 128 if bits == 8 else 0
    return whole.reshape(-1, 1).view(np.uint8)[:, : bits // 8].tobytes()


def write(path, samples, kind=(1, 16), rate=16000, extensible=False, size=None, before=b""):
    """A RIFF file of ``(n, channels)`` samples; ``size`` is what the header says of their bytes."""
    samples = samples.reshape(len(samples), -1)
    data, (tag, bits), channels = encoded(samples, kind), kind, samples.shape[1]
    block = channels * bits // 8
    form = struct.pack("<HHIIHH", 0xFFFE if extensible else tag, channels, rate, rate * block, block, bits)
    if extensible:
        form += struct.pack("<HHIH", 22, bits, 0, tag) + bytes.fromhex("000000001000800000aa00389b71")
    chunks = b"fmt " + struct.pack("<I", len(form)) + form + before
    chunks += b"data" + struct.pack("<I", len(data) if size is None else size) + data
    path.write_bytes(b"RIFF" + struct.pack("<I", 4 + len(chunks)) + b"WAVE" + chunks)
    return path


def noise(count, channels=1):
    return np.random.default_rng(0).uniform(-0.9, 0.9, (count, channels)).astype(np.float32)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("extensible", [False, True])
@pytest.mark.parametrize("channels", [1, 2, 6])
def test_every_kind(tmp_path, kind, extensible, channels):
    sound = noise(5000, channels)
    path = write(tmp_path / "a.wav", sound, kind, extensible=extensible, before=b"LIST" + struct.pack("<I", 3) + b"abc\0")
    loaded = audio.load(path)
    assert loaded.dtype == np.float32 and len(loaded) == 5000
    np.testing.assert_allclose(loaded, sound.mean(1), atol=KINDS[kind])


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_as_ffmpeg(tmp_path, kind, monkeypatch):
    pytest.importorskip("av", reason="the reference is not installed")
    path = write(tmp_path / "a.wav", noise(30_000, 2), kind)
    ours = audio.load(path)
    monkeypatch.setattr(wavefile, "_FORMATS", {})
    np.testing.assert_allclose(ours, audio.load(path), atol=1e-7)


@pytest.mark.parametrize("size", [0, 0xFFFFFFFF, 0x7FFFFFFF])
def test_sizes_that_are_not_known(tmp_path, size):
    assert len(audio.load(write(tmp_path / "a.wav", noise(40_000), size=size))) == 40_000


def test_what_is_not_a_number_is_silence(tmp_path):
    sound = noise(1000)
    sound[100], sound[200] = np.nan, np.inf
    loaded = audio.load(write(tmp_path / "a.wav", sound, (3, 32)))
    assert not loaded[100] and not loaded[200] and np.isfinite(loaded).all()


@pytest.mark.parametrize("cut", range(12, 45, 4))
def test_headers_cut_off_are_one_sentence(tmp_path, cut):
    path = write(tmp_path / "a.wav", noise(1000))
    path.write_bytes(path.read_bytes()[:cut])
    with pytest.raises(AudioUnreadable):
        audio.load(path)


def test_without_av_other_formats_are_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    assert len(audio.load(write(tmp_path / "a.wav", noise(1000)))) == 1000
    (tmp_path / "a.mp3").write_bytes(b"ID3" + bytes(500))
    for read in (audio.load, audio.check_readable):
        with pytest.raises(AudioUnreadable, match="package av"):
            read(tmp_path / "a.mp3")


# --- other rates


def heard(sound, source, target=16000, size=7001):
    pieces = (sound[begin : begin + size] for begin in range(0, len(sound), size))
    return np.concatenate([np.zeros(0, np.float32), *resample.resample(pieces, source, target)])


@pytest.mark.parametrize("rate", [8000, 11025, 22050, 44100, 48000, 96000, 44099])
def test_tones_keep_pitch_level_and_time(rate):
    time = np.arange(rate) / rate
    found = heard(np.sin(2 * np.pi * 1000 * time).astype(np.float32), rate)
    assert len(found) == 16000
    expected = np.sin(2 * np.pi * 1000 * np.arange(16000) / 16000)
    assert np.abs(found - expected)[500:-500].max() < 1e-4


def test_what_16_khz_cannot_hold_is_gone():
    time = np.arange(48000) / 48000
    found = heard(np.sin(2 * np.pi * 11000 * time).astype(np.float32), 48000)
    assert np.abs(found[500:-500]).max() < 1e-4


@pytest.mark.parametrize("count", [0, 1, 50, 1000])
def test_scraps(count):
    assert len(heard(np.ones(count, np.float32), 44100)) == -(-count * 160 // 441)


def test_pieces_leave_no_seam(monkeypatch):
    sound = noise(100_000)[:, 0]
    whole = heard(sound, 44100)
    monkeypatch.setattr(resample, "_MIN_SAMPLES", 1)
    np.testing.assert_allclose(heard(sound, 44100, size=313), whole, atol=1e-6)


@pytest.mark.parametrize("rate", [8000, 22050, 44100, 48000])
def test_the_same_as_ffmpegs_resampler(rate):
    av = pytest.importorskip("av", reason="the reference is not installed")
    sound = noise(2 * rate)[:, 0]
    frame = av.AudioFrame.from_ndarray(sound[None], format="fltp", layout="mono")
    frame.sample_rate = rate
    resampler = av.AudioResampler(format="fltp", layout="mono", rate=16000)
    expected = np.concatenate([part.to_ndarray()[0] for part in resampler.resample(frame) + resampler.resample(None)])
    found = heard(sound, rate)
    count = min(len(found), len(expected))
    assert abs(len(found) - len(expected)) < 40
    off = (found[:count] - expected[:count])[400:-400]
    print(f"{rate}: {20 * np.log10(off.std() / found.std()):.0f} dB")
    assert off.std() < 1e-3 * found.std()
