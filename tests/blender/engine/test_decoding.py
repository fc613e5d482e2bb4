"""Blender's sound system hears what the engine that ships cannot read: whole, joined without a seam, in time."""

import errno

import bpy
import numpy as np
import pytest
from s2ag.core.errors import AudioUnreadable, Cancelled, OutputUnwritable
from s2ag.core.sound import audio
from s2ag.core.sound.resample import resample
from s2ag.s2ag_blender.engine import decoding

pytestmark = pytest.mark.slow

assert bpy  # brings aud with it
aud = pytest.importorskip("aud", reason="this bpy comes without Blender's sound system")

KINDS = {
    "mp3": (aud.CONTAINER_MP3, aud.CODEC_MP3),
    "ogg": (aud.CONTAINER_OGG, aud.CODEC_VORBIS),
    "mkv": (aud.CONTAINER_MATROSKA, aud.CODEC_AAC),
    "flac": (aud.CONTAINER_FLAC, aud.CODEC_FLAC),
}


def written(path, kind, sound):
    container, codec = KINDS[kind]
    form = aud.FORMAT_S16 if kind == "flac" else aud.FORMAT_FLOAT32
    sound.resample(44100, 3).rechannel(2).write(str(path), 44100, 2, form, container, codec, 192000, 65536)
    return str(path)


def heard(path):
    return audio.load(decoding.Decoding(path).outcome())


@pytest.mark.parametrize("kind", KINDS)
def test_pieces_are_the_whole(kind, examples, tmp_path):
    path = written(tmp_path / f"voice.{kind}", kind, aud.Sound(str(examples / "hello.flac")))
    assert decoding.needs_decoding(path)
    whole = np.concatenate(list(resample([aud.Sound(path).data().mean(axis=1)], 44100, decoding.RATE)))
    found = heard(path)
    assert abs(len(found) - len(whole)) <= 0.03 * decoding.RATE  # a coder's padding, which a seek leaves out
    count = min(len(found), len(whole)) - decoding.RATE // 10
    wrong = found[:count] - whole[:count]
    assert 10 * np.log10(np.mean(whole[:count] ** 2) / max(np.mean(wrong**2), 1e-12)) > 40


def test_silence_and_a_click_keep_their_places(tmp_path):
    quiet = (
        aud.Sound.silence(44100)
        .limit(0, 20)
        .join(aud.Sound.sine(440, 44100).limit(0, 1))
        .join(aud.Sound.silence(44100).limit(0, 9))
    )
    found = heard(written(tmp_path / "quiet.mp3", "mp3", quiet))
    loud = np.flatnonzero(np.abs(found) > 0.1) / decoding.RATE
    assert abs(len(found) / decoding.RATE - 30) < 0.1 and abs(loud[0] - 20) < 0.05 and abs(loud[-1] - 21) < 0.05


def test_decoded_once_and_again_when_the_file_changes(examples, tmp_path):
    path = tmp_path / "voice.flac"
    path.write_bytes((examples / "hello.flac").read_bytes())
    first = decoding.Decoding(str(path)).outcome()
    assert decoding.Decoding(str(path)).outcome() == first
    with open(path, "ab") as file:
        file.write(b"\0")
    assert decoding.Decoding(str(path)).outcome() != first


def test_what_cannot_be_heard_says_why(examples, tmp_path, monkeypatch):
    cut, text = tmp_path / "cut.flac", tmp_path / "text.mp3"
    cut.write_bytes((examples / "hello.flac").read_bytes()[:150_000])
    text.write_text("no sound")
    with pytest.raises(AudioUnreadable, match="is cut off"):
        heard(str(cut))
    with pytest.raises(AudioUnreadable, match="text.mp3 is not a readable recording"):
        heard(str(text))
    assert not decoding.needs_decoding(str(tmp_path / "missing.mp3"))  # the engine says so

    def full(file, pieces):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(decoding, "write_wave", full)
    with pytest.raises(OutputUnwritable, match="No space left"):
        heard(str(written(tmp_path / "other.mp3", "mp3", aud.Sound(str(examples / "hello.flac")))))


def test_cancelled_between_pieces(examples, tmp_path):
    path = written(tmp_path / "long.mp3", "mp3", aud.Sound(str(examples / "hello.flac")).loop(4))
    under_way = decoding.Decoding(path)
    under_way.cancel()
    with pytest.raises(Cancelled):
        under_way.outcome()
