"""The same film with its own sound and with another's, both encoded alike so that nothing but the speech differs."""

from os import PathLike
from pathlib import Path

import numpy as np

from ..errors import UsageError
from ..sound import audio

RATE = 48000


def length(film: str | PathLike) -> float:
    """Seconds of a film's picture; raises :class:`UsageError` where it cannot be read or lacks picture or sound."""
    with _opened(film) as container:
        stream = container.streams.video[0]
        if stream.duration and stream.time_base:
            return float(stream.duration * stream.time_base)
        return float(container.duration or 0) / 1e6


def partners(lengths: dict[str, float]) -> dict[str, str]:
    """For every excerpt the one whose sound it gets: the next longer one, and the longest's is the second longest's.

    Raises :class:`UsageError` for less than two.
    """
    ranked = sorted(lengths, key=lambda name: (lengths[name], name))
    if len(ranked) < 2:
        raise UsageError("Another sound needs a second excerpt.", "Give every condition two clips or more.")
    return dict(zip(ranked, [*ranked[1:], ranked[-2]], strict=True))


def with_sound(film: str | PathLike, heard: str | PathLike, out: str | PathLike) -> None:
    """Write ``film``'s picture with the sound of the film ``heard`` to ``out``, as long as the picture."""
    import av

    film, out = Path(film), Path(out)
    samples = _samples(heard, int(round(length(film) * RATE)))
    try:
        with _opened(film) as own, av.open(audio.local(out), "w") as made:
            source = own.streams.video[0]
            copied = getattr(made, "add_stream_from_template", None) or (lambda template: made.add_stream(template=template))
            picture = copied(source)
            sound = made.add_stream("libopus" if out.suffix.lower() == ".webm" else "aac", rate=RATE)
            sound.layout = "mono"
            for packet in own.demux(source):
                if packet.dts is not None:
                    packet.stream = picture
                    made.mux(packet)
            for begin in range(0, len(samples), RATE):
                frame = av.AudioFrame.from_ndarray(samples[None, begin : begin + RATE], "flt", "mono")
                frame.sample_rate, frame.pts = RATE, begin
                made.mux(sound.encode(frame))
            made.mux(sound.encode(None))
    except av.FFmpegError as error:
        raise UsageError(f"{film} cannot be given another sound: {error}.", "Encode it as H.264 in .mp4.") from error


def _samples(film: str | PathLike, count: int) -> np.ndarray:
    """``(count,)`` float32 of a film's sound, cut or filled with silence."""
    with _opened(film) as container:
        parts = [piece[0] for piece in audio.pieces(container, container.streams.audio[0], RATE, "mono")]
    found = np.concatenate(parts or [np.zeros(0, np.float32)])[:count]
    return np.pad(found, (0, count - len(found))).astype(np.float32)


def _opened(film: str | PathLike):
    try:
        import av
    except ImportError as error:
        raise UsageError("Films get another sound by the package av.", 'Install it: pip install "s2ag[engine]".') from error
    try:
        container = audio.opened(film)
    except (av.FFmpegError, OSError, ValueError) as error:
        raise UsageError(f"{film} is no film.", "Give .mp4 or .webm that a browser plays.") from error
    if not (container.streams.video and container.streams.audio):
        container.close()
        raise UsageError(f"{film} lacks picture or sound.", "Give films with sound.")
    return container
