import os
import struct
import subprocess
import sys
import wave

import av
import numpy as np
import pytest
from callers import listening
from s2ag.core.errors import AudioUnreadable
from s2ag.core.learning.corpus.human_speech import levelled
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
    usual = levelled(sound)
    for factor in (1e-3, 0.2, 3.0):
        np.testing.assert_allclose(levelled(sound * np.float32(factor)), usual, rtol=1e-4, atol=1e-7)
    np.testing.assert_allclose(levelled(usual), usual, rtol=1e-5)


def test_level_ignores_digital_silence_and_a_quiet_room(examples):
    sound = audio.load(examples / "hello.flac")
    expected = audio.speech_gain(sound)
    silence = np.zeros(60 * 16000, np.float32)
    room = np.random.default_rng(0).normal(0, 1e-3, 20 * 16000).astype(np.float32)
    assert audio.speech_gain(np.concatenate([silence, sound, silence])) == pytest.approx(expected, rel=0.01)
    assert audio.speech_gain(np.concatenate([room, sound])) == pytest.approx(expected, rel=0.1)


def test_level_of_silence_is_silence():
    assert audio.speech_gain(np.zeros(1000, np.float32)) == 1.0
    assert audio.speech_gain(np.zeros(0, np.float32)) == 1.0
    np.testing.assert_array_equal(levelled(np.zeros(5000, np.float32)), np.zeros(5000, np.float32))


def test_digest_names_the_sound_and_nothing_else():
    sound = tone()[0]
    assert audio.digest(sound) == audio.digest(sound.astype(">f4")) == audio.digest(sound[::-1].copy()[::-1])
    assert audio.digest(sound) != audio.digest(sound * np.float32(0.99))
    assert len(audio.digest(sound)) == 64


# --- hostile recordings


def caf(path, channels, rate=16000.0, count=1600):
    """A Core Audio file of noise, 16 bits, in as many channels as are asked for."""
    data = np.random.default_rng(0).integers(-9000, 9000, (count, channels)).astype(">i2").tobytes()
    form = struct.pack(">d4sIIIII", rate, b"lpcm", 0, 2 * channels, 1, channels, 16)
    chunks = b"desc" + struct.pack(">q", len(form)) + form + b"data" + struct.pack(">q", 4 + len(data)) + bytes(4) + data
    path.write_bytes(b"caff\0\1\0\0" + chunks)
    return path


LOAD = "import sys; from s2ag.core.sound import audio; print(audio.load(sys.argv[1]).std())"


@pytest.mark.parametrize("channels", [7, 8, 9, 24, 64])
def test_any_number_of_channels_is_mixed_down(tmp_path, channels):
    """In a process of its own: from eight on it ended there."""
    path = caf(tmp_path / "many.caf", channels)
    done = subprocess.run([sys.executable, "-c", LOAD, str(path)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    # independent noise, uniform, so that its deviation falls with the root of the number of channels
    assert float(done.stdout) == pytest.approx(9000 / 32768 / np.sqrt(3 * channels), rel=0.1)


@pytest.mark.parametrize("name", ["12:30 talk.flac", "http:talk.flac", "tcp:1:9.flac", "50% {x} #1.flac", "pipe:0.flac"])
def test_a_path_is_a_path(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    plain = encode(tmp_path / "plain.flac", tone(), 16000, "flac", "s16")
    expected = audio.load(plain)
    plain.rename(tmp_path / name)
    for path in (name, tmp_path / name):
        audio.check_readable(path)
        np.testing.assert_array_equal(audio.load(path), expected)


@pytest.mark.parametrize("suffix", ["m3u8", "ffconcat", "sdp", "mpd", "wav"])
def test_nothing_in_a_file_or_its_name_calls_anybody(tmp_path, monkeypatch, suffix):
    monkeypatch.chdir(tmp_path)
    with listening() as (port, callers):
        address = f"http://127.0.0.1:{port}/a.wav"
        content = {
            "m3u8": f"#EXTM3U\n#EXT-X-TARGETDURATION:10\n#EXTINF:10,\n{address}\n#EXT-X-ENDLIST\n",
            "ffconcat": f"ffconcat version 1.0\nfile '{address}'\n",
            "sdp": f"v=0\no=- 0 0 IN IP4 127.0.0.1\ns=x\nc=IN IP4 127.0.0.1\nt=0 0\nm=audio {port} TCP 0\n",
            "mpd": f'<?xml version="1.0"?><MPD><BaseURL>{address}</BaseURL></MPD>',
            "wav": "",
        }[suffix]
        path = tmp_path / f"list.{suffix}"
        path.write_text(content)
        for name in (path, address, f"tcp:127.0.0.1:{port}", f"tcp://127.0.0.1:{port}"):
            with pytest.raises(AudioUnreadable):
                audio.load(name)
        assert callers == []


@pytest.mark.parametrize("rate", [1, 999, 384_001, 1_000_000_000])
def test_rates_beyond_reason_are_refused_before_they_cost_anything(tmp_path, rate):
    head = b"RIFF" + struct.pack("<I", 20036) + b"WAVEfmt " + struct.pack("<IHHIIHH", 16, 1, 1, rate, 2 * rate, 2, 16)
    (tmp_path / "a.wav").write_bytes(head + b"data" + struct.pack("<I", 20000) + bytes(20000))
    for path in (tmp_path / "a.wav", caf(tmp_path / "a.caf", 1, float(rate))):
        with pytest.raises(AudioUnreadable):
            audio.load(path)


def test_hours_of_nothing_in_a_small_file_end_where_its_size_says(tmp_path, monkeypatch):
    """A minute of silence stands for the days that the bound is for."""
    path = encode(tmp_path / "a.flac", np.zeros((1, 16000 * 60), np.float32), 16000, "flac", "s16")
    assert len(audio.load(path)) == 16000 * 60
    monkeypatch.setattr(audio, "LONG_SECONDS", 30.0)
    with pytest.raises(AudioUnreadable, match="is longer than"):
        audio.load(path)
    noise = np.random.default_rng(0).uniform(-1, 1, (1, 16000 * 60)).astype(np.float32)
    spoken = encode(tmp_path / "b.flac", noise, 16000, "flac", "s16")
    assert len(audio.load(spoken)) == 16000 * 60
