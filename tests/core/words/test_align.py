import html
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from s2ag.core.errors import Cancelled
from s2ag.core.sound import audio, voice_activity
from s2ag.core.words import align, transcript
from s2ag.core.words.aligner import letter_rules
from sounds import pauses
from transcripts import words_and_warnings

pytest.importorskip("pocketsphinx", reason="the aligner is not installed")
LIBRIVOX = Path("/usr/share/pocketsphinx/test/data/librivox")


@pytest.fixture(scope="module")
def sound(examples):
    return audio.load(examples / "hello.flac")


@pytest.fixture(scope="module")
def truth(examples):
    """Words with the times at which the neural voice placed them."""
    return json.loads((examples / "hello.json").read_text())


@pytest.fixture(scope="module")
def words(examples):
    return [said for _, said in transcript.tokenise((examples / "hello.txt").read_text())]


def align_words(sound, words, progress=None):
    """Spans of all words as one stretch of the recording, and warnings for the user."""
    alignment = align.align_stretches(sound, [align.Stretch(words)], progress)
    return alignment.spans, align.describe_problems(alignment, [" ".join(parts) for parts in words])


def starts_off(spans, truth):
    return np.array([start - true for (start, _), (_, true, _) in zip(spans, truth, strict=True)])


def test_starts_are_close_to_the_voices_own(sound, words, truth):
    spans, warnings = align_words(sound, words)
    off = np.abs(starts_off(spans, truth))
    assert warnings == []
    assert off.mean() < 0.035 and off.max() < 0.15


@pytest.mark.parametrize("decibels", [20, 10])
def test_noise(sound, words, truth, decibels):
    level = audio.SPEECH_RMS / audio.speech_gain(sound) * 10 ** (-decibels / 20)
    noisy = sound + np.random.default_rng(0).normal(0, level, len(sound)).astype(np.float32)
    spans, warnings = align_words(noisy, words)
    assert warnings == [] and np.median(np.abs(starts_off(spans, truth))) < 0.05


def test_quiet_and_loud_microphones_align_alike(sound, words, truth):
    for factor in (1e-3, 20):
        spans, _ = align_words(sound * np.float32(factor), words)
        assert np.abs(starts_off(spans, truth)).mean() < 0.035


def test_the_same_twice(sound, words):
    assert align_words(sound, words) == align_words(sound, words)


def test_unknown_words_are_guessed_from_their_letters(sound, words, truth):
    odd = [["haloe"] if word == ["hello"] else ["hanndz"] if word == ["hands"] else word for word in words]
    spans, warnings = align_words(sound, odd)
    assert warnings == [] and np.abs(starts_off(spans, truth)).mean() < 0.04


def test_a_word_without_letters_to_say_stands_between_its_neighbours(sound, words, truth):
    spans, warnings = align_words(sound, words[:20] + [["мир"]] + words[20:])
    assert len(warnings) == 1 and warnings[0].startswith("1 of 42 words")
    assert spans[19][0] <= spans[20][0] <= spans[21][0]
    assert np.abs(starts_off(spans[:20] + spans[21:], truth)).mean() < 0.035


@pytest.mark.slow
def test_several_minutes_are_followed_without_drifting(sound, words, truth):
    """Fourteen times the same speech with changing pauses: the text repeats, so a slip would go on to the end."""
    copies, rng, pieces, expected = 14, np.random.default_rng(3), [], []
    for _ in range(copies):
        at = sum(map(len, pieces)) / 16000
        expected += [(word, at + start, at + end) for word, start, end in truth]
        pieces += [sound, rng.normal(0, 1e-4, int(rng.uniform(0.2, 2) * 16000)).astype(np.float32)]
    recording, heard = np.concatenate(pieces), []
    assert len(recording) > 200 * 16000
    spans, warnings = align_words(recording, words * copies, heard.append)
    off = np.abs(starts_off(spans, expected))
    assert warnings == []
    assert off.mean() < 0.035 and np.percentile(off, 99) < 0.2
    assert heard == sorted(heard) and len(heard) > 4


def sonnet(shared, name):
    """A human reading of some 53 s and its text, line by line."""
    page = (shared / "speech" / f"{name}.xhtml").read_text()
    lines = [re.sub("<[^>]+>", "", html.unescape(line)) for line in re.findall(r"<span[^>]*>(.*?)</span>", page, re.DOTALL)]
    return audio.load(shared / "speech" / f"{name}.mp3"), lines


def spoken(lines):
    return [said for _, said in transcript.tokenise("\n".join(lines))]


@pytest.fixture(scope="module")
def two_sonnets(shared):
    """Sound, words and where the words are said when nothing else is there, of each of two readings."""
    found = [(sound, spoken(lines)) for sound, lines in (sonnet(shared, name) for name in ("p001", "p002"))]
    return [(sound, words, align_words(sound, words)[0]) for sound, words in found]


@pytest.mark.parametrize("case", ["sound without text", "text without sound"])
def test_what_has_no_counterpart_does_not_lose_the_rest(two_sonnets, case):
    (first, before, begun), (second, after, ended) = two_sonnets
    between, extra = np.zeros(0, np.float32), []
    if case == "sound without text":
        between = first[10 * 16000 : 30 * 16000][::-1]
    else:
        extra = after[100:60:-1]
    spans, warnings = align_words(np.concatenate([first, between, second]), before + extra + after)
    assert all("not found in the recording: " in warning for warning in warnings)
    missing = sum(int(warning.split()[0]) for warning in warnings)
    # a numeral at the seam may be taken for noise
    assert missing <= 1 if not extra else abs(missing - len(extra)) <= 4
    shift = (len(first) + len(between)) / 16000
    begins = np.array([start for start, _ in spans[:90]]) - [start for start, _ in begun[:90]]
    ends = np.array([start - shift for start, _ in spans[-60:]]) - [start for start, _ in ended[-60:]]
    assert np.percentile(np.abs(begins), 95) < 0.1 and np.percentile(np.abs(ends), 95) < 0.1


CHILDREN = {
    "dies": "import os, signal, sys; sys.stdin.buffer.read(100_000); os.kill(os.getpid(), signal.SIGSEGV)",
    "dies at once": "import os; os._exit(3)",
    "talks nonsense": "print('hello', flush=True); import time; time.sleep(60)",
    "answers for another text": "print('{\"spans\": [[0, 1]]}', flush=True)",
}


@pytest.mark.parametrize("name", CHILDREN)
def test_a_failing_child_becomes_a_warning(sound, words, monkeypatch, name):
    monkeypatch.setattr(align, "command", lambda: [sys.executable, "-c", CHILDREN[name]])
    spans, warnings = align_words(sound, words)
    assert len(warnings) == 1 and warnings[0].startswith("The aligner ")
    assert len(spans) == len(words)
    assert all(0 <= start <= end <= len(sound) / 16000 for start, end in spans)


def test_a_hanging_child_is_killed(sound, words, monkeypatch, tmp_path):
    program = f"import os, time; open({str(tmp_path / 'pid')!r}, 'w').write(str(os.getpid())); time.sleep(600)"
    monkeypatch.setattr(align, "command", lambda: [sys.executable, "-c", program])
    monkeypatch.setattr(align, "TIMEOUT", 2 - len(sound) / 16000)
    _, warnings = align_words(sound, words)
    assert "took too long" in warnings[0]
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "pid").read_text()), 0)


def test_the_native_crash_that_this_is_about(monkeypatch, sound):
    """A word without phones makes pocketsphinx read a null pointer; nobody but the child may notice."""
    program = "import s2ag.core.words.aligner.lexicon as lexicon, s2ag.core.words.aligner.serve as serve; "
    program += "lexicon.Lexicon.ways = lambda self, word: [' ']; serve.main()"
    monkeypatch.setattr(align, "command", lambda: [sys.executable, "-c", program])
    _, warnings = align_words(sound, [["qwzx"]] * 20)
    assert len(warnings) == 1


def test_no_program_to_start(sound, words, monkeypatch, tmp_path):
    monkeypatch.setattr(align, "command", lambda: [str(tmp_path / "nothing")])
    _, warnings = align_words(sound, words)
    assert "could not be started" in warnings[0]


def test_cancelling_from_the_progress(sound, words):
    def cancel(done):
        raise Cancelled("Cancelled.")

    with pytest.raises(Cancelled):
        align_words(sound, words, cancel)


def test_the_child_needs_no_package(tmp_path, sound, words):
    """It also runs where this package has another name: started by path, from anywhere, with its own folder not on the path."""
    pcm = np.clip(sound * 32767, -32768, 32767).astype("<i2")
    stretch = {"words": words, "start": 0, "end": len(pcm) / 16000}
    request = {"stretches": [stretch], "pauses": pauses(sound), "samples": len(pcm)}
    message = json.dumps(request).encode() + b"\n" + pcm.tobytes()
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    result = subprocess.run(align.command(), input=message, capture_output=True, cwd=tmp_path, env=environment, check=True)
    assert len(json.loads(result.stdout.splitlines()[-1])["spans"]) == len(words)


def test_spread_starts_every_stretch_with_a_word():
    words = [["a"], ["quite"], ["long"], ["sentence"], ["here"]]
    segments = [(1.0, 2.0), (3.0, 5.0)]
    spans = align.spread_by_letters(words, segments)
    starts = [start for start, _ in spans]
    assert starts[0] == 1.0 and 3.0 in starts and starts == sorted(starts)
    assert spans[-1][1] == pytest.approx(5.0)
    assert all(any(low <= start and end <= high + 1e-9 for low, high in segments) for start, end in spans)


@pytest.mark.parametrize(
    ("word", "phones"),
    [
        ("", ""),
        ("мир", ""),
        ("'", ""),
        ("ship", "SH IH P"),
        ("nation", "N AE SH AH N"),
        ("bbc", "B IY B IY S IY"),
        ("gate", "G AE T"),
    ],
)
def test_letters_to_sounds(word, phones):
    assert letter_rules.guess_phones(word) == phones


def test_every_guess_is_of_phones_the_model_knows():
    from pocketsphinx import Decoder

    decoder = Decoder(lm=None, loglevel="FATAL")
    spellings = {*letter_rules._LETTERS, *"bcdfghjklmnpqrstvwxz", "xylophonist", "schtroumpf", "aeiou", "queueing"}
    for number, word in enumerate(sorted(spellings)):
        assert letter_rules.guess_phones(word)
        decoder.add_word(f"made{number}up", letter_rules.guess_phones(word), True)


@pytest.mark.skipif(not LIBRIVOX.is_dir(), reason="Debian's pocketsphinx-testdata is not installed")
def test_human_readings():
    lines = [line.rpartition("(") for line in (LIBRIVOX / "transcription").read_text().splitlines() if "(" in line]
    assert len(lines) == 5
    for text, _, name in lines:
        sound = audio.load(LIBRIVOX / f"{name.rstrip(')')}.wav")
        said = re.sub(r"</?s>", "", text)
        words, warnings = words_and_warnings(sound, text=said)
        assert warnings == [] and [word for word, _, _ in words] == said.split()
        segments = voice_activity.segments(sound)
        assert abs(words[0][1] - segments[0][0]) < 0.3 and abs(words[-1][2] - segments[-1][1]) < 0.3


@pytest.mark.parametrize("name", ["p001", "p002"])
def test_human_sonnets(shared, name):
    sound, lines = sonnet(shared, name)
    words, warnings = words_and_warnings(sound, text="\n".join(lines))
    assert warnings == []
    segments, place, distances = voice_activity.segments(sound), 0, []
    for line in lines:
        distances.append(min(abs(words[place][1] - start) for start, _ in segments))
        place += len(transcript.tokenise(line))
    assert place == len(words)
    assert np.median(distances) < 0.15
