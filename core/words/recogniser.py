"""Speech recognition by Whisper through faster-whisper, run as a program of its own by :mod:`recognise`.

Standard input is one line of JSON ``{"samples": n, "model": folder, "language": code or null, "words": bool}`` and then n
little-endian int16 samples at 16 kHz; standard output is JSON lines, ``{"progress": 0..1}`` and last
``{"segments": [[text, start, end], ...]}``, with ``words`` one for every word. The sound is recognised in stretches of some
five minutes that end in silence, so memory does not grow with the recording.
"""

import json
import os
import sys

import numpy as np

RATE = 16000
_STRETCH = 300 * RATE
_SEARCH = 20 * RATE
_HOP = RATE // 10
_QUICK = {"beam_size": 1, "condition_on_previous_text": False}


def main() -> None:
    """Speak the protocol at the top of this file."""
    os.environ["HF_HUB_OFFLINE"] = "1"
    from faster_whisper import WhisperModel

    request = json.loads(sys.stdin.buffer.readline())
    model = WhisperModel(request["model"], device="cpu", compute_type="int8", local_files_only=True)
    segments, begin, total = [], 0, request["samples"]
    rest = np.zeros(0, np.float32)
    while begin < total:
        wanted = min(_STRETCH, total - begin) - len(rest)
        data = sys.stdin.buffer.read(2 * max(wanted, 0))
        sound = np.concatenate([rest, np.frombuffer(data, "<i2").astype(np.float32) / 32768])
        size = len(sound) if begin + len(sound) >= total or not len(data) else _quiet(sound)
        found, _ = model.transcribe(sound[:size], language=request["language"], word_timestamps=request["words"], **_QUICK)
        for part in found:
            pieces = [(word.word, word.start, word.end) for word in part.words or ()]
            for text, start, end in pieces or [(part.text, part.start, part.end)]:
                segments.append([text.strip(), begin / RATE + start, begin / RATE + max(start, min(end, size / RATE))])
            print(json.dumps({"progress": min((begin + part.end * RATE) / total, 1.0)}), flush=True)
        rest, begin = sound[size:], begin + size
        if not size:
            break
    print(json.dumps({"segments": segments}), flush=True)


def _quiet(sound: np.ndarray) -> int:
    """The quietest place in the last seconds."""
    tail = sound[-_SEARCH:]
    power = (tail[: len(tail) // _HOP * _HOP].reshape(-1, _HOP) ** 2).sum(1)
    return len(sound) - len(tail) + int(np.argmin(np.convolve(power, np.ones(3), mode="same"))) * _HOP + _HOP // 2


if __name__ == "__main__":
    main()
