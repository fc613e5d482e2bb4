import os
import wave

import av
import numpy as np
import pytest
from s2ag.core.errors import AudioUnreadable
from s2ag.core.sound import audio


def tone(seconds=1.0, rate=16000, hertz=440.0, channels=1):
    """Full-scale fraction ``(channels, n)``: a tone at 0.5."""
    signal = 0.5 * np.sin(2 * np.pi * hertz * np.arange(int(seconds * rate)) / rate)
    return np.tile(signal.astype(np.float32), (channels, 1))


def encode(path, samples, rate, codec, sound_format, video=False):
    """Write a file of any container and codec; with ``video`` a picture track and no sound."""
    with av.open(str(path), "w") as container:
        if video:
            stream = container.add_stream("mpeg4", rate=10)
            stream.width = stream.height = 32
            for _ in range(5):
                container.mux(stream.encode(av.VideoFrame.from_ndarray(np.zeros((32, 32, 3), np.uint8))))
        else:
            layout = "stereo" if len(samples) == 2 else "mono"
            stream = container.add_stream(codec, rate=rate, layout=layout, format=sound_format)
            resampler = av.AudioResampler(format=sound_format, layout=layout, rate=rate, frame_size=stream.frame_size or 1024)
            frame = av.AudioFrame.from_ndarray(samples, format="fltp", layout=layout)
            frame.sample_rate = rate
            for piece in resampler.resample(frame) + resampler.resample(None):
                container.mux(stream.encode(piece))
        container.mux(stream.encode(None))
    return path


@pytest.mark.parametrize(
    ("name", "rate", "codec", "sound_format", "channels"),
    [
        ("a.wav", 8000, "pcm_s16le", "s16", 1),
        ("a.wav", 44100, "pcm_s24le", "s32", 2),
        ("a.wav", 16000, "pcm_f32le", "flt", 1),
        ("a.flac", 96000, "flac", "s16", 2),
        ("a.mp3", 44100, "libmp3lame", "fltp", 2),
        ("a.ogg", 48000, "libopus", "flt", 2),
        ("a.opus", 48000, "libopus", "flt", 1),
        ("a.m4a", 22050, "aac", "fltp", 1),
        ("a.mkv", 48000, "aac", "fltp", 2),
        ("größe 声.wav", 22050, "pcm_s16le", "s16", 1),
    ],
)
def test_any_format_becomes_the_same_sound(tmp_path, name, rate, codec, sound_format, channels):
    path = encode(tmp_path / name, tone(1.5, rate, channels=channels), rate, codec, sound_format)
    sound = audio.load(path)
    assert sound.dtype == np.float32 and sound.ndim == 1
    assert abs(len(sound) / audio.SAMPLE_RATE - 1.5) < 0.1
    middle = sound[8000:16000]
    assert np.argmax(np.abs(np.fft.rfft(middle))) == pytest.approx(220, abs=1)
    assert np.sqrt(np.mean(middle**2)) == pytest.approx(0.5 / np.sqrt(2), rel=0.06)


def test_samples_at_16_khz_come_through_unchanged(tmp_path):
    signal = tone()
    loaded = audio.load(encode(tmp_path / "a.wav", signal, 16000, "pcm_f32le", "flt"))
    np.testing.assert_array_equal(loaded, signal[0])


def test_long_recordings_are_joined_from_blocks(tmp_path):
    signal = np.random.default_rng(0).uniform(-1, 1, 16000 * 130 + 77).astype(np.float32)
    loaded = audio.load(encode(tmp_path / "a.wav", signal[None], 16000, "pcm_f32le", "flt"))
    np.testing.assert_array_equal(loaded, signal)


def bad_files(folder):
    (folder / "empty.wav").touch()
    (folder / "text.mp3").write_text("not a recording\n" * 50)
    with wave.open(str(folder / "no-samples.wav"), "wb") as file:
        file.setparams((1, 2, 16000, 0, "NONE", ""))
    encode(folder / "film.mp4", None, 0, None, None, video=True)
    whole = encode(folder / "whole.wav", tone(4.0), 16000, "pcm_s16le", "s16").read_bytes()
    (folder / "cut.wav").write_bytes(whole[: len(whole) // 2])
    whole = encode(folder / "whole.flac", tone(4.0), 16000, "flac", "s16").read_bytes()
    (folder / "cut.flac").write_bytes(whole[: len(whole) // 2])
    whole = encode(folder / "whole.m4a", tone(4.0), 16000, "aac", "fltp").read_bytes()
    (folder / "cut.m4a").write_bytes(whole[: len(whole) // 2])
    (folder / "folder.wav").mkdir()


def test_a_wave_written_to_a_pipe_does_not_know_its_length(tmp_path):
    path = encode(tmp_path / "a.wav", tone(2.0), 16000, "pcm_s16le", "s16")
    data = bytearray(path.read_bytes())
    at = data.index(b"data") + 4
    data[at : at + 4] = b"\xff\xff\xff\xff"
    path.write_bytes(data)
    assert len(audio.load(path)) == 32000


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("nowhere.wav", "does not exist"),
        ("folder.wav", "is a folder"),
        ("empty.wav", "empty file"),
        ("no-samples.wav", "zero length"),
        ("text.mp3", "not a readable recording"),
        ("film.mp4", "no sound"),
        ("cut.wav", "cut off"),
        ("cut.flac", "cut off"),
        ("cut.m4a", "not a readable recording"),
    ],
)
def test_unreadable_recordings_say_why_in_one_sentence(tmp_path, name, says):
    bad_files(tmp_path)
    with pytest.raises(AudioUnreadable) as caught:
        audio.load(tmp_path / name)
    assert says in caught.value.message and "\n" not in caught.value.message
    assert caught.value.message.endswith(".") and caught.value.remedy.endswith(".")


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may read everything")
def test_unreadable_by_permission(tmp_path):
    path = encode(tmp_path / "a.wav", tone(), 16000, "pcm_s16le", "s16")
    path.chmod(0)
    with pytest.raises(AudioUnreadable, match="cannot be opened"):
        audio.load(path)


def test_level_forgets_the_microphone(examples):
    sound = audio.load(examples / "hello.flac")
    levelled = audio.level(sound)
    for factor in (1e-3, 0.2, 3.0):
        np.testing.assert_allclose(audio.level(sound * np.float32(factor)), levelled, rtol=1e-4, atol=1e-7)
    np.testing.assert_allclose(audio.level(levelled), levelled, rtol=1e-5)


def test_level_ignores_digital_silence_and_a_quiet_room(examples):
    sound = audio.load(examples / "hello.flac")
    expected = audio.gain(sound)
    silence = np.zeros(60 * 16000, np.float32)
    room = np.random.default_rng(0).normal(0, 1e-3, 20 * 16000).astype(np.float32)
    assert audio.gain(np.concatenate([silence, sound, silence])) == pytest.approx(expected, rel=0.01)
    assert audio.gain(np.concatenate([room, sound])) == pytest.approx(expected, rel=0.1)


def test_level_of_silence_is_silence():
    assert audio.gain(np.zeros(1000, np.float32)) == 1.0
    assert audio.gain(np.zeros(0, np.float32)) == 1.0
    np.testing.assert_array_equal(audio.level(np.zeros(5000, np.float32)), np.zeros(5000, np.float32))


def test_digest_names_the_sound_and_nothing_else():
    sound = tone()[0]
    assert audio.digest(sound) == audio.digest(sound.astype(">f4")) == audio.digest(sound[::-1].copy()[::-1])
    assert audio.digest(sound) != audio.digest(sound * np.float32(0.99))
    assert len(audio.digest(sound)) == 64
