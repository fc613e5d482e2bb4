"""Analyses prosody: loudness, pitch, phrases and accented syllables, for the networks and for the editing of gestures.

Gesture strokes fall on accents (McNeill), so training and synthesis use the same accents: with words where they are known,
otherwise from the sound alone. As in the literature, prominence means louder, higher and longer than the neighbourhood, on
a word that carries meaning."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..motion.skeleton import FPS
from ..smoothing import gaussian, running_mean
from . import peaks, voice_activity
from .prosody_tracks import RATE, Tracks, measure

PHRASE_PAUSE = 0.16
"""A pause of this many seconds ends a phrase."""
LONGEST_PHRASE = 4.0
"""Seconds; a longer phrase is cut at its quietest point."""

FEATURE_NAMES = (
    "voice", "level", "pitch", "pitch trend", "accent", "main accent", "until main accent", "since main accent",
    "phrase strength", "since phrase start", "until phrase end", "pause", "syllable rate", "register", "pitch range",
    "dynamics", "brightness",
)  # fmt: skip
FEATURES = len(FEATURE_NAMES)

_STRESSED = 0.95  # strength of an accent that the transcript marks as stressed
_BUMP = 0.06  # seconds: standard deviation of the bump that marks an accent
_NEIGHBOURHOOD = 1.2  # seconds: standard deviation of the weights of the neighbours that an accent is compared with
_MANNER_SECONDS = 8.0  # smoothing of the features that describe how somebody speaks at the moment

_FUNCTION = (
    "a an the of to in on at by for from with and or as is are was were be been being it its he him his she her they them "
    "their i you we us our your my me that this these those there which who whom whose than then if so but not has have had "
    "do does did will would can could shall should may might into onto upon about it's i'm that's he's she's they're i'd "
    "i'll you'd we'd he'd some any no nor"
)
FUNCTION_WORDS = frozenset(_FUNCTION.split())
"""Words that rarely carry an accent."""
_EMPHATIC = "very really so too only even just never always must every all no not nothing great big huge best worst"
EMPHATIC_WORDS = frozenset(_EMPHATIC.split())
"""Words that carry an accent more often than others of their word class."""


@dataclass(frozen=True)
class Accent:
    """A syllable that may be accented: ``time`` of its peak in seconds, ``strength`` 0..1, whether it is the ``main`` accent
    of its phrase, the number of the ``phrase``, and the number of its ``word`` (-1 if words are unknown)."""

    time: float
    strength: float
    main: bool
    phrase: int
    word: int


@dataclass(frozen=True)
class Prosody:
    """Result of :func:`analyse`.

    ``accents`` in order of time; ``phrases`` ``(p, 2)``, start and end in seconds; ``features`` ``(frames, FEATURES)`` float32
    at 15 fps with columns :data:`FEATURE_NAMES`, all of order one; the 100 Hz tracks ``level`` (dB above the speaker's mean)
    and ``pitch`` (semitones above the speaker's median, interpolated where unvoiced)."""

    accents: tuple[Accent, ...]
    phrases: np.ndarray
    features: np.ndarray
    level: np.ndarray
    pitch: np.ndarray


def analyse(
    audio: np.ndarray, words: Sequence[tuple[str, float, float]] = (), frames: int | None = None,
    stressed: Collection[int] = (), measured: Tracks | None = None, fps: float = FPS
) -> Prosody:  # fmt: skip
    """Analyse the prosody of ``(n,)`` float32 samples at 16 kHz; ``words`` are (text, start, end) in seconds, in order of time.

    ``frames`` is the number of pose frames of the features, by default that of the recording. ``stressed`` holds the numbers
    of words that get a main accent whatever the sound says. ``measured`` is the result of :func:`measure`, if the caller has
    it. Networks take these features at 15 fps; data sets may have another ``fps``."""
    frames = voice_activity.frame_count(audio, fps) if frames is None else frames
    tracks = measured or measure(audio)
    phrases = _phrases(tracks)
    units = _word_units(tracks, words) if len(words) else _syllable_units(tracks)
    if len(units[0]) and not len(phrases):  # no voice is heard long enough, but every accent is one of a phrase
        edges = np.linspace(0, len(tracks.level) / RATE, int(np.ceil(len(tracks.level) / RATE / LONGEST_PHRASE)) + 1)
        phrases = np.stack([edges[:-1], edges[1:]], axis=1)
    accents = _stress(_accents(phrases, units), stressed)
    return Prosody(accents, phrases, _features(tracks, phrases, accents, np.arange(frames) / fps), tracks.level, tracks.pitch)


def _phrases(tracks: Tracks) -> np.ndarray:
    """Return phrases ``(p, 2)``, start and end in seconds: voiced segments between pauses.

    Those longer than :data:`LONGEST_PHRASE` are cut at their quietest point, away from the ends."""
    waiting = [tuple(edge) for edge in voice_activity.segments_of_track(tracks.voice, shortest=0.12, pause=PHRASE_PAUSE)][::-1]
    quiet = gaussian(tracks.level, 0.06 * RATE)
    phrases = []
    while waiting:
        start, end = waiting.pop()
        if end - start <= LONGEST_PHRASE:
            phrases.append((start, end))
            continue
        low, high = int((start + 1.2) * RATE), int(min(start + LONGEST_PHRASE, end - 0.8) * RATE)
        cut = (low + int(np.argmin(quiet[low:high]))) / RATE
        waiting += [(cut, end), (start, cut)]
    return np.array(phrases).reshape(-1, 2)


def _word_units(tracks: Tracks, words: Sequence[tuple[str, float, float]]) -> tuple[np.ndarray, ...]:
    """Return arrays ``(w,)`` of the words in order of time: time of the peak in seconds, level, pitch, duration relative to
    what the number of letters lets expect, semantic weight, and the number of the word."""
    last = len(tracks.level) - 1
    times, levels, pitches, lengths, weights = (np.zeros(len(words)) for _ in range(5))
    for k, (text, start, end) in enumerate(words):
        low = int(np.clip(round(start * RATE), 0, last))
        window = slice(low, int(np.clip(round(end * RATE), low + 1, last + 1)))
        # prefer the first peak of a long word, as English tends to stress early syllables
        lead = np.linspace(1.5, 0, window.stop - low)
        peak = low + int(np.argmax(tracks.level[window] + 0.4 * tracks.pitch[window] + lead))
        times[k] = peak / RATE
        levels[k] = tracks.level[peak]
        pitches[k] = tracks.pitch[max(peak - 5, 0) : peak + 6].max()
        lengths[k] = (end - start) / (0.09 + 0.055 * len(text))
        plain = text.lower().strip(".,;:!?\"'")
        weights[k] = (plain not in FUNCTION_WORDS) + 0.7 * (plain in EMPHATIC_WORDS)
    order = np.argsort(times, kind="stable")
    return times[order], levels[order], pitches[order], lengths[order], weights[order], order


def _syllable_units(tracks: Tracks) -> tuple[np.ndarray, ...]:
    """Return the same arrays from the sound alone, one unit per loudness peak with a prominence of at least 3 dB."""
    loud = gaussian(tracks.level, 0.04 * RATE)
    syllables = peaks.find_peaks(loud, prominence=3.0, distance=8, depth=0.6)
    voiced = tracks.voice[syllables.places] > 0.5
    at, lengths = syllables.places[voiced], np.clip(syllables.widths[voiced] / RATE, 0.05, 0.4) / 0.16
    return at / RATE, loud[at], tracks.pitch[at], lengths, np.full(len(at), 0.75), np.full(len(at), -1)


def _accents(phrases: np.ndarray, units: tuple[np.ndarray, ...]) -> tuple[Accent, ...]:
    """Rate the prominence of units (see :func:`_word_units`) and choose the main accent of every phrase."""
    times, levels, pitches, lengths, weights, numbers = units
    if not len(times):
        return ()
    louder = np.clip((levels - _local_mean(times, levels, weights)) / 5, -1, 1)
    higher = np.clip((pitches - _local_mean(times, pitches, weights)) / 4, -1, 1)
    longer = np.clip(np.log(np.maximum(lengths, 0.1) / np.maximum(_local_mean(times, lengths, weights), 0.1)) / 0.7, -1, 1)
    strength = 0.14 + 0.22 * weights + 0.17 * louder + 0.12 * higher + 0.12 * longer
    phrase = np.clip(np.searchsorted(phrases[:, 0], times + 0.02, side="right") - 1, 0, None)
    main = np.zeros(len(times), bool)
    for number in np.unique(phrase):
        members = np.flatnonzero(phrase == number)
        # the nuclear accent is usually the last strong accent of its phrase
        late = np.linspace(0, 0.14, len(members))
        main[members[np.argmax(strength[members] + late)]] = True
    strength = np.clip(strength + 0.22 * main, 0.02, 1)
    return tuple(
        Accent(float(t), float(s), bool(m), int(p), int(n))
        for t, s, m, p, n in zip(times, strength, main, phrase, numbers, strict=True)
    )


def _stress(accents: tuple[Accent, ...], stressed: Collection[int]) -> tuple[Accent, ...]:
    """Make the accents of the words ``stressed`` the main accents of their phrases, instead of the previous ones."""
    chosen = set(stressed)
    phrases = {accent.phrase for accent in accents if accent.word in chosen}
    return tuple(
        replace(one, strength=_STRESSED, main=True) if one.word in chosen
        else replace(one, main=False) if one.phrase in phrases else one
        for one in accents
    )  # fmt: skip


def _local_mean(times: np.ndarray, values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return the mean of the values near each time, with Gaussian weights; words with semantic weight count more.

    Words of one time are taken together, so that any number of them costs no more than the length of the recording."""
    moments, number = np.unique(times, return_inverse=True)
    counted, summed = np.bincount(number, 0.2 + weights), np.bincount(number, (0.2 + weights) * values)
    result = np.empty(len(moments))
    for begin in range(0, len(moments), 512):
        rows = slice(begin, begin + 512)
        low, high = np.searchsorted(moments, [moments[rows][0] - 4 * _NEIGHBOURHOOD, moments[rows][-1] + 4 * _NEIGHBOURHOOD])
        share = np.exp(-0.5 * ((moments[rows, None] - moments[low:high]) / _NEIGHBOURHOOD) ** 2)
        result[rows] = share @ summed[low:high] / (share @ counted[low:high])
    return result[number]


def _features(tracks: Tracks, phrases: np.ndarray, accents: tuple[Accent, ...], time: np.ndarray) -> np.ndarray:
    """Return features ``(frames, FEATURES)`` float32 with columns :data:`FEATURE_NAMES` at seconds ``time`` ``(frames,)``."""
    mains = [accent for accent in accents if accent.main]
    manner = _manner(tracks, (tracks.voice > 0.5) & (tracks.level > -15))
    ahead, behind = _distance(time, np.array([accent.time for accent in mains]))
    number = np.clip(np.searchsorted(phrases[:, 0], time, side="right") - 1, 0, max(len(phrases) - 1, 0))
    begins, ends = phrases[number].T if len(phrases) else np.zeros((2, len(time)))
    strengths = np.zeros(max(len(phrases), 1))
    for accent in mains:
        strengths[accent.phrase] = accent.strength
    inside = (time >= begins) & (time < ends)
    pause = np.where(time < begins, begins, np.append(phrases[1:, 0], 1e6)[number] - ends if len(phrases) else 1e6)
    columns = [
        _sample(gaussian(tracks.voice, 0.03 * RATE), time),
        _sample(gaussian(np.maximum(tracks.level, -25), 0.05 * RATE), time) / 10,
        _sample(tracks.pitch, time) / 4,
        _sample(gaussian(tracks.pitch, 0.5 * RATE), time) / 3,
        _bumps(time, accents),
        _bumps(time, mains),
        np.exp(-ahead / 0.5),
        np.exp(-behind / 0.5),
        np.where(inside, strengths[number], 0.0),
        np.where(inside, np.minimum((time - begins) / 2, 1), 0.0),
        np.where(inside, np.minimum((ends - time) / 2, 1), 0.0),
        np.where(inside, 0.0, np.clip(pause, 0, 3) / 2),
        _sample(_rate(tracks), time),
        *(_sample(track, time) for track in manner),
    ]
    return np.stack(columns, axis=1).astype(np.float32)


def _manner(tracks: Tracks, counted: np.ndarray) -> list[np.ndarray]:
    """Return slow tracks of register, pitch range, dynamics and brightness, from the frames ``counted`` (a mask)."""
    weight = _slow(counted.astype(float)) + 1e-3
    sure = weight / (weight + 0.03)
    pitch = _slow(tracks.pitch * counted) / weight
    level = _slow(tracks.level * counted) / weight
    spread = np.sqrt(np.maximum(_slow(tracks.pitch**2 * counted) / weight - pitch**2, 0))
    dynamics = np.sqrt(np.maximum(_slow(tracks.level**2 * counted) / weight - level**2, 0))
    bright = _slow(tracks.tilt * counted) / weight
    values = 2 * tracks.register + pitch / 6, (spread - 2.5) / 1.5, (dynamics - 8) / 2, (bright + 6) / 6
    return [sure * value for value in values]


def _rate(tracks: Tracks) -> np.ndarray:
    """Return the smoothed syllable rate while speaking, standardised: syllables per second minus 2.5, divided by 1.5."""
    peaks = np.zeros(len(tracks.level))
    peaks[np.round(_syllable_units(tracks)[0] * RATE).astype(int)] = RATE
    return (_slow(peaks) / (_slow((tracks.voice > 0.5).astype(float)) + 0.05) - 2.5) / 1.5


def _bumps(time: np.ndarray, accents: Sequence[Accent]) -> np.ndarray:
    """Return ``(frames,)`` with a Gaussian bump per accent, as high as its strength; overlapping bumps do not add up."""
    result = np.zeros(len(time))
    for accent in accents:
        low, high = np.searchsorted(time, [accent.time - 4 * _BUMP, accent.time + 4 * _BUMP])
        bump = accent.strength * np.exp(-0.5 * ((time[low:high] - accent.time) / _BUMP) ** 2)
        result[low:high] = np.maximum(result[low:high], bump)
    return result


def _distance(time: np.ndarray, marks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the seconds to the next and since the last of ``marks``, large where there is none."""
    padded = np.concatenate([[-1e3], marks, [1e9]])
    following = np.searchsorted(padded, time, side="left")
    return padded[following] - time, time - padded[following - 1]


def _sample(track: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Interpolate a 100 Hz track at ``time`` in seconds."""
    return np.interp(time, (np.arange(len(track)) + 0.5) / RATE, track)


def _slow(track: np.ndarray) -> np.ndarray:
    """Smooth over :data:`_MANNER_SECONDS` by three running means: nearly Gaussian, at a cost independent of the width."""
    for _ in range(3):
        track = running_mean(track, int(_MANNER_SECONDS * RATE / 2))
    return track
