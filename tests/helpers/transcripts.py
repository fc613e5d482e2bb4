"""One transcript in every form: by independent programs where there are any, else in the shape of the form's description."""

import json

import pytest
from s2ag.core.words import transcript

WORDS = [("Now", 0.5, 0.74), ("then,", 0.8, 1.2), ("it's", 1.5, 1.625), ("time.", 1.625, 2.25)]
PHRASES = [("Now then,", 0.5, 1.2), ("it's time.", 1.5, 2.25)]


def words_and_warnings(sound, *about, **more):
    """Words and warnings of :func:`transcript.timed_transcript`."""
    heard = transcript.timed_transcript(sound, *about, **more)
    return heard.words, heard.warnings


def milliseconds(seconds):
    return round(1000 * seconds)


def praat(short, phones=True):
    """Praat itself writes it."""

    def write(path):
        parselmouth = pytest.importorskip("parselmouth")
        grid = parselmouth.praat.call("Create TextGrid...", 0, 3, "phones words", "")
        places = sorted({time for _, start, end in WORDS for time in (start, end)})
        for tier in (1, 2):
            for time in places:
                parselmouth.praat.call(grid, "Insert boundary...", tier, time)
        for text, start, end in WORDS:
            number = int(parselmouth.praat.call(grid, "Get interval at time...", 2, (start + end) / 2))
            parselmouth.praat.call(grid, "Set interval text...", 2, number, text)
            parselmouth.praat.call(grid, "Set interval text...", 1, number, "AH N AH N AH N AH N")
        parselmouth.praat.call(grid, "Save as short text file..." if short else "Save as text file...", str(path))

    return write


def praatio_json(path):
    textgrid = pytest.importorskip("praatio.textgrid")
    grid = textgrid.Textgrid()
    grid.addTier(textgrid.IntervalTier("words", [(start, end, text) for text, start, end in WORDS], 0, 3))
    grid.save(str(path), format="textgrid_json", includeBlankSpaces=True)


def mfa_json(path):
    entries = [[0.0, 0.5, ""], *([start, end, text] for text, start, end in WORDS)]
    tiers = {"words": {"type": "interval", "entries": entries}, "phones": {"type": "interval", "entries": [[0.5, 0.6, "N"]]}}
    path.write_text(json.dumps({"start": 0, "end": 3, "tiers": tiers}))


def webvtt(suffix):
    def write(path):
        module = pytest.importorskip("webvtt")
        captions = module.WebVTT()
        for text, start, end in PHRASES:
            captions.captions.append(module.Caption(stamp(start), stamp(end), text))
        (captions.save if suffix == "vtt" else captions.save_as_srt)(str(path))

    return write


def stamp(seconds, comma="."):
    return f"00:00:{int(seconds):02}{comma}{milliseconds(seconds) % 1000:03}"


def text(content):
    return lambda path: path.write_text(content, encoding="utf-8")


def as_json(value):
    return lambda path: path.write_text(json.dumps(value), encoding="utf-8")


YOUTUBE = """WEBVTT
Kind: captions
Language: en

STYLE
::cue { color: white }

NOTE written by a machine

00:00:00.500 --> 00:00:01.200 align:start position:0%
Now<00:00:00.800><c> then,</c>

00:00:01.500 --> 00:00:02.250 align:start position:0%
Now then,
it's<00:00:01.625><c> time.</c>
"""
VOICES = f"""WEBVTT

intro
{stamp(0.5)} --> {stamp(1.2)} line:80%
<v Mary Ann>Now <b>then</b>,</v>

2
{stamp(1.5)} --> {stamp(2.25)}
<v.loud Bob>it's &nbsp;time.</v>
"""
ASS = """[Script Info]
ScriptType: v4.00+

[Events]
Format: Layer, Start, End, Style, Name, MarginL, MarginR, MarginV, Effect, Text
Comment: 0,0:00:00.00,0:00:00.40,Default,,0,0,0,,not said
Dialogue: 0,0:00:00.50,0:00:01.20,Default,,0,0,0,,{\\an8}Now then,
Dialogue: 0,0:00:01.50,0:00:02.25,Default,,0,0,0,,it's\\Ntime.
"""
WHISPER = {
    "text": " Now then, it's time.",
    "segments": [
        {
            **{"id": number, "seek": 0, "start": start, "end": end, "text": f" {phrase}", "tokens": [5036], "temperature": 0.0},
            "words": [
                {"word": f" {word}", "start": begin, "end": stop, "probability": 0.9}
                for word, begin, stop in WORDS
                if start <= begin < end
            ],
        }
        for number, (phrase, start, end) in enumerate(PHRASES)
    ],
    "language": "en",
}
PLAIN_WHISPER = {**WHISPER, "segments": [{k: v for k, v in s.items() if k != "words"} for s in WHISPER["segments"]]}
WHISPERX = {
    "segments": [
        {
            **{"start": start, "end": end, "text": phrase, "speaker": "SPEAKER_00"},
            "words": [
                {"word": word, "start": begin, "end": stop, "score": 0.8} for word, begin, stop in WORDS if start <= begin < end
            ],
        }
        for phrase, start, end in PHRASES
    ],
    "word_segments": [{"word": word, "start": start, "end": end, "score": 0.8} for word, start, end in WORDS],
    "language": "en",
}
WHISPER_CPP = {
    "systeminfo": "AVX = 1",
    "result": {"language": "en"},
    "transcription": [
        {
            "timestamps": {"from": stamp(start, ","), "to": stamp(end, ",")},
            "offsets": {"from": milliseconds(start), "to": milliseconds(end)},
            "text": f" {phrase}",
        }
        for phrase, start, end in PHRASES
    ],
}


def google(start, end, time):
    words = [{"word": word, start: time(begin), end: time(stop)} for word, begin, stop in WORDS]
    halves = [{"alternatives": [{"transcript": "t", "confidence": 0.9, "words": half}]} for half in (words[:2], words[2:])]
    return halves


def protobuf(seconds):
    return {"seconds": str(int(seconds)), "nanos": round(seconds % 1 * 1e9)}


GENTLE = {
    "transcript": "Now then, it's time.",
    "words": [
        {
            **{"alignedWord": word.lower().strip(".,"), "case": "success", "start": begin, "end": stop, "word": word},
            **{"startOffset": 4 * number, "endOffset": 4 * number + 3, "phones": [{"duration": 0.1, "phone": "n_B"}]},
        }
        for number, (word, begin, stop) in enumerate(WORDS)
    ],
}
AMAZON = {
    "jobName": "a",
    "results": {
        "transcripts": [{"transcript": "Now then, it's time."}],
        "items": [
            *(
                {
                    "start_time": str(begin),
                    "end_time": str(stop),
                    "alternatives": [{"confidence": "1.0", "content": word}],
                    "type": "pronunciation",
                }
                for word, begin, stop in WORDS
            ),
            {"alternatives": [{"confidence": "0.0", "content": "."}], "type": "punctuation"},
        ],
    },
}
DEEPGRAM = {
    "results": {
        "channels": [
            {
                "alternatives": [
                    {
                        "transcript": "now then",
                        "words": [{"word": "x", "punctuated_word": word, "start": b, "end": e} for word, b, e in WORDS],
                    }
                ]
            }
        ]
    }
}
CTM = ";; made by hand\n" + "".join(f"talk 1 {start:.3f} {end - start:.3f} {word} 0.98\n" for word, start, end in WORDS)
MFA_CSV = "Begin,End,Label,Type,Speaker\n" + "".join(
    f'{start},{end},"{word}",words,a\n' for word, start, end in WORDS
) + "0.5,0.6,N,phones,a\n"  # fmt: skip

JSON_G = "JSON of Google"
YOUTUBE_FILE = text(YOUTUBE)
"""States where words begin, and not where they end."""

FORMS = [
    ("Praat TextGrid, long", "a.TextGrid", praat(False), "TextGrid", WORDS),
    ("Praat TextGrid, short", "a.textgrid", praat(True), "TextGrid", WORDS),
    ("TextGrid as JSON by praatio", "a.json", praatio_json, "JSON of an aligner", WORDS),
    ("Montreal Forced Aligner JSON", "a.json", mfa_json, "JSON of an aligner", WORDS),
    ("Montreal Forced Aligner CSV", "a.csv", text(MFA_CSV), "labels of the Montreal Forced Aligner", WORDS),
    ("WebVTT by webvtt-py", "a.vtt", webvtt("vtt"), "WebVTT", PHRASES),
    ("SRT by webvtt-py", "a.srt", webvtt("srt"), "SRT", PHRASES),
    ("WebVTT with word times", "a.vtt", YOUTUBE_FILE, "WebVTT", WORDS),
    ("WebVTT with voices and tags", "a.vtt", text(VOICES), "WebVTT", PHRASES),
    ("ASS", "a.ass", text(ASS), "ASS", PHRASES),
    ("Whisper with words", "a.json", as_json(WHISPER), "JSON of Whisper", WORDS),
    ("Whisper without words", "a.json", as_json(PLAIN_WHISPER), "JSON of Whisper", PHRASES),
    ("Whisper TSV", "a.tsv", text("start\tend\ttext\n500\t1200\tNow then,\n1500\t2250\tit's time.\n"), "labels", PHRASES),
    ("WhisperX", "a.json", as_json(WHISPERX), "JSON of Whisper", WORDS),
    ("whisper.cpp", "a.json", as_json(WHISPER_CPP), "JSON of whisper.cpp", PHRASES),
    ("Google REST", "a.json", as_json({"results": google("startTime", "endTime", lambda t: f"{t:.3f}s")}), JSON_G, WORDS),
    ("Google v2", "a.json", as_json({"results": google("startOffset", "endOffset", lambda t: f"{t}s")}), JSON_G, WORDS),
    ("Google protobuf", "a.json", as_json({"results": google("start_time", "end_time", protobuf)}), "JSON of Google", WORDS),
    ("GENEA 2020", "a.json", as_json(google("start_time", "end_time", lambda t: f"{t:.3f}s")), "JSON of Google", WORDS),
    ("GENEA 2022 TSV", "a.tsv", text("".join(f"{b}\t{e}\t{w}\n" for w, b, e in WORDS)), "labels", WORDS),
    ("Gentle", "a.json", as_json(GENTLE), "JSON of Gentle", WORDS),
    ("Amazon Transcribe", "a.json", as_json(AMAZON), "JSON of Amazon", WORDS),
    ("Deepgram", "a.json", as_json(DEEPGRAM), "JSON of Google", WORDS),
    ("Vosk", "a.json", as_json({"result": [{"conf": 1, "word": w, "start": b, "end": e} for w, b, e in WORDS]}),
     "JSON of words", WORDS),
    ("CTM", "a.ctm", text(CTM), "CTM", WORDS),
    ("our own", "a.json", as_json([list(word) for word in WORDS]), "JSON of words", WORDS),
    ("our own, as objects", "a.json", as_json({"words": [dict(zip(("word", "start", "end"), w, strict=True)) for w in WORDS]}),
     "JSON of words", WORDS),
    ("plain text", "a.txt", text("Now then,\nit's time.\n"), "plain text", [("Now then,\nit's time.\n", None, None)]),
]  # fmt: skip
