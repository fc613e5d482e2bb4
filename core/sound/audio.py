"""Any recording to 16 kHz mono float32, decoded piece by piece."""

import hashlib
import struct
from collections.abc import Iterator
from os import PathLike
from pathlib import Path

import numpy as np

from ..errors import AudioUnreadable

SAMPLE_RATE = 16000
SPEECH_RMS = 0.05
"""Active speech level after :func:`level`: -26 dB below full scale, the usual telephony reference."""

_BLOCK = SAMPLE_RATE * 60
_CHOOSE = "Choose a recording, or a video with an audio track."
_STREAMED = 0x7FFFFFFF
"""Sizes from here on are what programs write that do not know the size yet."""
_DECLARES_LENGTH = {"flac", "aiff", "mov,mp4,m4a,3gp,3g2,mj2"}
"""Containers whose header states the length; elsewhere FFmpeg guesses it from the bit rate, which proves nothing."""


def load(path: str | PathLike) -> np.ndarray:
    """Decode the first audio stream of any audio or video file to ``(n,)`` float32 mono at 16 kHz, full scale 1.

    The file is decoded packet by packet, so memory is that of the result (230 MB an hour). Damaged packets are left
    out as a player would do. Raises :class:`AudioUnreadable` when the file is missing, a folder, empty, in no known
    format, without an audio stream, without a single sample, or shorter than its own header says.
    """
    import av

    path = Path(path)
    _check(path)
    try:
        with av.open(str(path), metadata_errors="ignore") as container:
            if not container.streams.audio:
                raise AudioUnreadable(f"{path} has no sound in it.", _CHOOSE)
            stream = container.streams.audio[0]
            audio = _join(piece.mean(axis=0) for piece in pieces(container, stream, SAMPLE_RATE))
            declared = float(stream.duration * stream.time_base) if stream.duration else 0.0
            exact = container.format.name in _DECLARES_LENGTH
    except (av.FFmpegError, OSError, ValueError) as error:
        raise _unreadable(path, error) from error
    if not len(audio):
        raise AudioUnreadable(f"{path} holds no sound at all (zero length).", "Choose another recording.")
    seconds = len(audio) / SAMPLE_RATE
    declared = max(declared if exact else 0.0, seconds / _wave_share(path))
    if declared - seconds > max(0.25, 0.02 * declared):
        raise AudioUnreadable(
            f"{path} is cut off: it ends after {seconds:.1f} s where its header promises {declared:.1f} s.",
            "Copy or export it again.",
        )
    return audio


def check(path: str | PathLike) -> None:
    """Raise :class:`AudioUnreadable` unless ``path`` opens as a recording; its samples are not decoded."""
    import av

    _check(Path(path))
    try:
        with av.open(str(path), metadata_errors="ignore") as container:
            silent = not container.streams.audio
    except (av.FFmpegError, OSError, ValueError) as error:
        raise _unreadable(path, error) from error
    if silent:
        raise AudioUnreadable(f"{path} has no sound in it.", _CHOOSE)


def digest(audio: np.ndarray) -> str:
    """SHA-256 (hexadecimal) of the samples as little-endian float32: names the sound whatever the file was called."""
    return hashlib.sha256(np.ascontiguousarray(audio, "<f4")).hexdigest()


def level(audio: np.ndarray) -> np.ndarray:
    """The same sound with its active speech level at :data:`SPEECH_RMS`, so that a microphone's gain leaves no trace."""
    return np.asarray(audio, np.float32) * np.float32(gain(audio))


def gain(audio: np.ndarray) -> float:
    """Factor that brings the active speech level to :data:`SPEECH_RMS`; 1 for silence.

    Active are the 20 ms frames less than 10 dB below the mean power of all frames that are not digital silence: two
    gates as in loudness metering (ITU-R BS.1770), both relative to the recording itself, so long pauses, digital
    silence and quiet rooms do not count.
    """
    audio = np.asarray(audio, np.float32)
    size = min(320, len(audio))
    if not size:
        return 1.0
    frames = audio[: len(audio) // size * size].reshape(-1, size)
    power = np.einsum("ij,ij->i", frames, frames) / size
    power = power[power > 1e-6 * power.max()].astype(float)
    if not len(power) or power.max() < 1e-14:
        return 1.0
    active = power[power >= 0.1 * power.mean()]
    return SPEECH_RMS / float(np.sqrt(active.mean()))


def pieces(container, stream, rate: int, layout: str | None = None) -> Iterator[np.ndarray]:
    """Float32 samples ``(channels, n)`` of a stream of an open ``av`` container, piece by piece.

    They are resampled to ``rate`` and mixed to a ``layout`` such as ``stereo`` (None: as they are). Decoding goes on after
    damaged packets. Raises :class:`av.FFmpegError`.
    """
    import av

    stream.thread_type = "AUTO"
    resampler = av.AudioResampler(format="fltp", layout=layout, rate=rate)
    for packet in container.demux(stream):
        try:
            frames = packet.decode()
        except av.InvalidDataError:
            continue
        for frame in frames:
            frame.pts = None
            yield from (piece.to_ndarray() for piece in resampler.resample(frame))
    yield from (piece.to_ndarray() for piece in resampler.resample(None))


def _check(path: Path) -> None:
    if path.is_dir():
        raise AudioUnreadable(f"{path} is a folder, not a recording.", "Name a file inside it.")
    if not path.exists():
        raise AudioUnreadable(f"The recording {path} does not exist.", "Check the name and the folder.")
    try:
        with open(path, "rb") as file:
            if not file.read(1):
                raise AudioUnreadable(f"{path} is an empty file.", "Export or copy the recording again.")
    except OSError as error:
        raise AudioUnreadable(f"{path} cannot be opened: {error.strerror}.", "Check the file's permissions.") from error


def _wave_share(path: Path) -> float:
    """How much of the samples that a RIFF WAVE header promises is there (FFmpeg believes the file's size); 1 elsewhere."""
    with open(path, "rb") as file:
        riff, _, kind = struct.unpack("<4sI4s", file.read(12).ljust(12))
        while riff == b"RIFF" and kind == b"WAVE" and len(head := file.read(8)) == 8:
            name, size = struct.unpack("<4sI", head)
            if name == b"data":
                there = path.stat().st_size - file.tell()
                return there / size if 0 < there < size < _STREAMED else 1.0
            file.seek(size + size % 2, 1)
    return 1.0


def _join(pieces) -> np.ndarray:
    """Concatenate many small pieces in one buffer that grows in place, so that the peak is the result itself."""
    audio, filled = np.empty(_BLOCK, np.float32), 0
    for piece in pieces:
        if filled + len(piece) > len(audio):
            audio.resize(filled + len(piece) + _BLOCK, refcheck=False)
        audio[filled : filled + len(piece)] = np.nan_to_num(piece, posinf=0.0, neginf=0.0)
        filled += len(piece)
    audio.resize(filled, refcheck=False)
    return audio


def _unreadable(path, error: Exception) -> AudioUnreadable:
    what = f"{path} is not a readable recording ({_reason(error)})."
    return AudioUnreadable(what, "Export it again, for instance as WAV, FLAC or MP3.")


def _reason(error: Exception) -> str:
    return (getattr(error, "strerror", None) or str(error) or type(error).__name__).rstrip(".")
