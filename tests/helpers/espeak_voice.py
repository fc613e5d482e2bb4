"""eSpeak NG's own voice says a text: ``python espeak_voice.py LANGUAGE OUT.wav < text``, a process for its C library.

Standard output is JSON, ``[[word, start in seconds], ...]``, exact to the sample.
"""

import ctypes
import json
import sys
import wave

import numpy as np

_WORD, _SYNCHRONOUS, _UTF8 = 1, 2, 1


class Event(ctypes.Structure):
    """``espeak_EVENT`` of speak_lib.h."""

    _fields_ = [
        *((name, ctypes.c_int) for name in ("type", "message", "place", "length", "time", "sample")),
        ("data", ctypes.c_void_p),
        ("id", ctypes.c_char * 8),
    ]


def say(language: str, text: str) -> tuple:
    """Sound int16 ``(n,)``, its rate, and words with their starts."""
    import espeakng_loader

    library = ctypes.CDLL(espeakng_loader.get_library_path())
    rate = library.espeak_Initialize(_SYNCHRONOUS, 0, espeakng_loader.get_data_path().encode(), 0)
    assert rate > 0 and library.espeak_SetVoiceByName(language.encode()) == 0
    pieces, words = [], []

    @ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(ctypes.c_short), ctypes.c_int, ctypes.POINTER(Event))
    def hear(sound, count, events):
        while events.contents.type:
            if events.contents.type == _WORD:
                place, length = events.contents.place - 1, events.contents.length
                words.append((text[place : place + length], events.contents.sample / rate))
            events = ctypes.cast(ctypes.addressof(events.contents) + ctypes.sizeof(Event), ctypes.POINTER(Event))
        if sound and count:
            pieces.append(np.ctypeslib.as_array(sound, (count,)).copy())
        return 0

    library.espeak_SetSynthCallback(hear)
    data = text.encode()
    library.espeak_Synth(data, ctypes.c_size_t(len(data) + 1), 0, 1, 0, _UTF8, None, None)
    library.espeak_Synchronize()
    return np.concatenate(pieces), rate, words


if __name__ == "__main__":
    sound, rate, words = say(sys.argv[1], sys.stdin.buffer.read().decode())
    with wave.open(sys.argv[2], "wb") as file:
        file.setparams((1, 2, rate, len(sound), "NONE", ""))
        file.writeframes(sound.tobytes())
    print(json.dumps(words))
