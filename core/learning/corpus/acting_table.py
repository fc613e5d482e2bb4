"""``python -m s2ag.core.learning.corpus.acting_table``: what the voices change in each emotion, beside what people change.

The features are those by which people's acting was measured: tilt is the median over voiced frames of the energy of 1 to
5 kHz over that of 60 to 1000 Hz, harmonicity that of the autocorrelation at the pitch period, register the median pitch.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

from ...sound.audio import SAMPLE_RATE
from . import acting, kathleen, texts, vocal_delivery, voices

_WINDOW, _HOP = 512, 160
_LOWEST, _HIGHEST = 60, 700
_VOICED = 0.5


def measure(audio: np.ndarray) -> np.ndarray:
    """Return features ``(5,)`` of speech ``(n,)`` at 16 kHz: register (semitones over 100 Hz), tilt and harmonicity (dB), range
    (semitones, 5 to 95 %) and movement of pitch (mean step of 10 ms in semitones, steps under 2)."""
    frames = np.lib.stride_tricks.sliding_window_view(audio, 2 * _WINDOW)[::_HOP] * np.hanning(2 * _WINDOW)
    power = np.abs(np.fft.rfft(frames, 4 * _WINDOW)) ** 2
    loud = power.sum(1) > 0.003 * power.sum(1).max()
    correlation = np.fft.irfft(power)[:, : 2 * _WINDOW]
    shape = np.fft.irfft(np.abs(np.fft.rfft(np.hanning(2 * _WINDOW), 4 * _WINDOW)) ** 2)[: 2 * _WINDOW]
    normal = correlation / np.maximum(correlation[:, :1] * shape / shape[0], 1e-12)
    low, high = SAMPLE_RATE // _HIGHEST, SAMPLE_RATE // _LOWEST
    # of nearly equal peaks the shortest period is the pitch's
    part = normal[:, low:high] - 0.02 * np.log2(np.arange(low, high) / low)
    best = part.argmax(1)
    strength = normal[np.arange(len(best)), best + low]
    voiced = loud & (strength > _VOICED)
    hertz = np.fft.rfftfreq(4 * _WINDOW, 1 / SAMPLE_RATE)
    bands = [power[:, (hertz >= a) & (hertz < b)].sum(1) for a, b in ((1000, 5000), (60, 1000))]
    tilt = 10 * np.log10((bands[0] + 1e-12) / (bands[1] + 1e-12))
    clear = np.clip(strength, _VOICED, 0.9999)
    pitch = 12 * np.log2(SAMPLE_RATE / (best + low) / 100)
    spread = np.diff(np.percentile(pitch[voiced], [5, 95]))[0]
    steps = np.abs(np.diff(pitch))[voiced[1:] & voiced[:-1]]
    middles = [np.median(x[voiced]) for x in (pitch, tilt, 10 * np.log10(clear / (1 - clear)))]
    return np.array([*middles, spread, steps[steps < 2].mean()])


def acted(kind: str, voice: voices.Voice, sentences: list[texts.Sentence], mood: str, seed: int = 0) -> np.ndarray:
    """Speak ``sentences`` in a mood of :data:`acting.MOODS` or "neutral"; return the means of :func:`measure` and words a
    second ``(6,)``."""
    affect, rows = np.array(acting.MOODS.get(mood, (0.5, 0.5, 0.5))), []
    person = vocal_delivery.draw_voice(kind, np.random.default_rng(seed))
    for number, sentence in enumerate(sentences):
        random = np.random.default_rng([seed, number])
        delivery = vocal_delivery.draw_delivery(person, affect, random)
        said = voice.say(sentence, delivery.manner)
        if said is None:
            continue
        tempo = delivery.manner.tempo if kind == kathleen.KIND else 1.0
        audio = vocal_delivery.apply_delivery(*said, delivery, random, tempo)
        seconds = (said[1][-1].end - said[1][0].start) / SAMPLE_RATE / tempo
        rows.append([*measure(audio), len(said[1]) / seconds])
    return np.mean(rows, axis=0)


def shifts(kind: str, voice: voices.Voice, sentences: list[texts.Sentence]) -> dict[str, np.ndarray]:
    """Return for each mood what it changes beside neutral ``(6,)``: as :func:`measure`, at last the factor of the rate."""
    plain = acted(kind, voice, sentences, "neutral")
    result = {}
    for mood in acting.MOODS:
        row = acted(kind, voice, sentences, mood)
        result[mood] = np.append(row[:-1] - plain[:-1], row[-1] / plain[-1])
    return result


def main(arguments: list[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split(": ", 1)[1])
    parser.add_argument("--material", type=Path, required=True, help="folder with emobank/ and kathleen/")
    parser.add_argument("--voices", nargs="+", default=["piper", "flite:slt", "flite:rms", kathleen.KIND])
    options = parser.parse_args(arguments)
    written, hers = texts.load_sentences(options.material)[:8], kathleen.scripts(str(options.material), 0)
    print("| emotion | voice | register, st | tilt, dB | harmonicity, dB | range, st | movement | rate |\n" + "|---" * 8 + "|")
    found = {
        kind: shifts(kind, kathleen.Reader(str(options.material), hers[0]), list(hers[0].sentences[:8]))
        if kind == kathleen.KIND
        else shifts(kind, voices.voice(kind), written)
        for kind in options.voices
    }
    for mood, (pitch, tilt, clear, rate, spread, _) in acting.SHIFTS.items():
        people = (pitch, tilt, clear, spread, np.nan, 1 + rate / vocal_delivery.SYLLABLES)
        for kind, row in {"people": people, **{kind: rows[mood] for kind, rows in found.items()}}.items():
            numbers = [f"{number:+.1f}" for number in row[:4]] + [f"{row[4]:+.2f}", f"{row[5]:.2f}"]
            print("|", " | ".join([mood, kind, *numbers]), "|")
    return 0


if __name__ == "__main__":
    sys.exit(main())
