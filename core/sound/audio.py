"""Any recording to 16 kHz mono float32, decoded piece by piece."""

import contextlib
import hashlib
from collections.abc import Iterable, Iterator
from os import PathLike
from pathlib import Path

import numpy as np

from ..errors import AudioUnreadable
from . import wavefile
from .resample import resampled

SAMPLE_RATE = 16000
SPEECH_RMS = 0.05
"""Active speech level after :func:`level`: -26 dB below full scale, the usual telephony reference."""

RATES = 1_000, 384_000
"""Samples a second of a recording: lower ones would grow without limit, higher ones want long filters."""
SPARSE, LONG = 3600.0, 12 * 3600.0
"""Seconds: what is longer than the first holds :data:`_SPEECH` bytes a second, and nothing is longer than the second."""

_SPEECH = 500
"""The slowest speech coders in use write 600 bytes a second; silence for days fits into a few."""
_BLOCK = SAMPLE_RATE * 60
_CHOOSE = "Choose a recording, or a video with an audio track."
_DECLARES_LENGTH = {"flac", "aiff", "mov,mp4,m4a,3gp,3g2,mj2"}
"""Containers whose header states the length; elsewhere FFmpeg guesses it from the bit rate, which proves nothing."""


def load(path: str | PathLike) -> np.ndarray:
    """Decode the first audio stream of any audio or video file to ``(n,)`` float32 mono at 16 kHz, full scale 1.

    WAV is read by :mod:`wavefile`, all else by the package ``av``. The file is decoded piece by piece, so memory is that of
    the result (230 MB an hour). Damaged packets are left out as a player would do. Raises :class:`AudioUnreadable` when the
    file is missing, a folder, empty, in no known format, without an audio stream, without a single sample, shorter than
    its own header says, or beyond :data:`RATES` and :data:`LONG`.
    """
    path = Path(path)
    _check(path)
    head = wavefile.header(path)
    if head and head.kind is not None:
        audio, declared = _mono(path, wavefile.samples(path, head), head.rate), 0.0
    else:
        audio, declared = _decoded(path)
    if not len(audio):
        raise AudioUnreadable(f"{path} holds no sound at all (zero length).", "Choose another recording.")
    seconds = len(audio) / SAMPLE_RATE
    declared = max(declared, seconds / (head.share if head else 1.0))
    if declared - seconds > max(0.25, 0.02 * declared):
        raise AudioUnreadable(
            f"{path} is cut off: it ends after {seconds:.1f} s where its header promises {declared:.1f} s.",
            "Copy or export it again.",
        )
    return audio


def check(path: str | PathLike) -> None:
    """Raise :class:`AudioUnreadable` unless ``path`` opens as a recording; its samples are not decoded."""
    path = Path(path)
    _check(path)
    head = wavefile.header(path)
    if head and head.kind is not None:
        return
    with _opened(path):
        pass


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


def opened(path: str | PathLike):
    """An open ``av`` container, whatever encoding the tags of the file are in.

    A path is a path, also where it looks like an address; and no playlist reads anything but files.
    """
    import av

    name, options = local(path), {"protocol_whitelist": "file"}
    try:
        return av.open(name, metadata_errors="ignore", options=options)
    except TypeError:  # av 19 ignores such errors of its own accord and has no such argument
        return av.open(name, options=options)


def local(path: str | PathLike) -> str:
    """What FFmpeg calls the file at ``path``: without its protocol, ``12:30 talk.wav`` would be an address."""
    return f"file:{path}"


def pieces(container, stream, rate: int, layout: str | None = None) -> Iterator[np.ndarray]:
    """Float32 samples ``(channels, n)`` of a stream of an open ``av`` container, piece by piece.

    They are resampled to ``rate`` and mixed to a ``layout`` such as ``stereo`` (None: as they are). Decoding goes on after
    damaged packets. Raises :class:`av.FFmpegError`.
    """
    import av

    stream.thread_type = "AUTO"
    resampler = av.AudioResampler(format="flt", layout=layout, rate=rate)
    for packet in container.demux(stream):
        try:
            frames = packet.decode()
        except av.InvalidDataError:
            continue
        for frame in frames:
            frame.pts = None
            yield from (_channels(piece) for piece in resampler.resample(frame))
    yield from (_channels(piece) for piece in resampler.resample(None))


def _channels(frame) -> np.ndarray:
    """``(channels, n)`` of a frame of interleaved samples; ``av`` ends the process over more than seven planes."""
    return frame.to_ndarray().reshape(-1, frame.layout.nb_channels).T


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


@contextlib.contextmanager
def _opened(path: Path):
    """The ``av`` container of a file that has sound in it; raises :class:`AudioUnreadable`, also for what goes on inside."""
    try:
        import av
    except ImportError as error:
        what = f"{path} is no WAV file, and the package av, which reads all other recordings, is missing."
        raise AudioUnreadable(what, 'Save it as WAV, or install it with: pip install "s2ag[engine]".') from error
    try:
        with opened(path) as container:
            if not container.streams.audio:
                raise AudioUnreadable(f"{path} has no sound in it.", _CHOOSE)
            if container.streams.audio[0].codec_context is None:
                raise AudioUnreadable(f"The sound of {path} is of a kind that nothing here reads.", _CHOOSE)
            yield container
    except (av.FFmpegError, OSError, ValueError) as error:
        raise _unreadable(path, error) from error


def _decoded(path: Path) -> tuple[np.ndarray, float]:
    """The sound by ``av``, and the seconds that the file declares, 0 where that proves nothing."""
    with _opened(path) as container:
        stream = container.streams.audio[0]
        rate = stream.rate or SAMPLE_RATE
        audio = _mono(path, pieces(container, stream, rate), rate)
        exact = stream.duration and container.format.name in _DECLARES_LENGTH
        return audio, float(stream.duration * stream.time_base) if exact else 0.0


def _mono(path: Path, parts: Iterable[np.ndarray], rate: int) -> np.ndarray:
    """``(n,)`` float32 at :data:`SAMPLE_RATE` of pieces ``(channels, n)``; what is not a number is silence."""
    if not RATES[0] <= rate <= RATES[1]:
        what = f"{path} has {rate} samples a second; {RATES[0]} to {RATES[1]} are read."
        raise AudioUnreadable(what, "Export it again, for instance at 48000.")
    mixed = (np.nan_to_num(part.mean(axis=0, dtype=np.float32), nan=0.0, posinf=0.0, neginf=0.0) for part in parts)
    longest = min(max(SPARSE, path.stat().st_size / _SPEECH), LONG)
    return _join(_ending(path, resampled(mixed, rate, SAMPLE_RATE), longest))


def _ending(path: Path, parts: Iterable[np.ndarray], seconds: float) -> Iterator[np.ndarray]:
    left = seconds * SAMPLE_RATE
    for part in parts:
        left -= len(part)
        if left < 0:
            what = f"{path} is longer than {seconds / 3600:.3g} hours, the most that a file of its size may hold."
            raise AudioUnreadable(what, "Cut it into shorter recordings.")
        yield part


def _join(pieces) -> np.ndarray:
    """Concatenate many small pieces in one buffer that grows in place, so that the peak is the result itself."""
    audio, filled = np.empty(_BLOCK, np.float32), 0
    for piece in pieces:
        if filled + len(piece) > len(audio):
            audio.resize(filled + len(piece) + _BLOCK, refcheck=False)
        audio[filled : filled + len(piece)] = piece
        filled += len(piece)
    audio.resize(filled, refcheck=False)
    return audio


def _unreadable(path, error: Exception) -> AudioUnreadable:
    what = f"{path} is not a readable recording ({_reason(error)})."
    return AudioUnreadable(what, "Export it again, for instance as WAV, FLAC or MP3.")


def _reason(error: Exception) -> str:
    return (getattr(error, "strerror", None) or str(error) or type(error).__name__).rstrip(".")
