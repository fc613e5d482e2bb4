"""Talks of people: a sonnet, a woman's reading, and telephone prompts. Material that is absent is skipped."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from heard_words import words_are_heard
from s2ag.core.learning.corpus import human_speech, kathleen, speech

MATERIAL = Path(__file__).parents[3].parent / "shared" / "data"
needs_material = pytest.mark.skipif(not (MATERIAL / "emobank").is_dir(), reason="../shared is absent")
needs_kathleen = pytest.mark.skipif(not (MATERIAL / "kathleen").is_dir(), reason="../shared has no kathleen")
needs_prompts = pytest.mark.skipif(not human_speech.prompts(), reason="asterisk-core-sounds-en-wav is not installed")
RATE = 16000


@needs_material
def test_the_sonnet_is_the_one_for_training():
    audio, placed, closings, numbers = human_speech.sonnet(MATERIAL)
    assert [word.text for word in placed[1:5]] == ["from", "fairest", "creatures", "we"]
    assert len(placed) == len(closings) == len(numbers) > 100 and closings.count(":") >= 3 and max(numbers) == 14
    starts = [word.start for word in placed]
    assert starts == sorted(starts) and placed[-1].end <= len(audio)


@needs_kathleen
def test_each_of_kathleens_sentences_is_of_one_split_and_in_one_talk():
    scripts = kathleen.scripts(str(MATERIAL), 0)
    spoken = [said for script in scripts for said in script.sentences]
    assert len(spoken) == len({said.text for said in spoken}) > 1000
    assert all({said.split for said in script.sentences} == {script.split} for script in scripts)
    share = Counter(said.split for said in spoken)
    assert share[1] / len(spoken) == pytest.approx(0.1, abs=0.03) == share[2] / len(spoken)
    assert {script.split for script in scripts[:15]} == {0, 1, 2}


@needs_kathleen
def test_kathleens_words_are_where_they_are_heard_also_when_she_acts():
    pytest.importorskip("pyworld")
    talks = speech.talks(str(MATERIAL), 0)
    natural = next(talk for talk in talks if talk.kind == kathleen.KIND)
    acted = next(talk for talk in talks if talk.script is natural.script and talk.acting != "natural")
    for talk in (natural, acted):
        spoken = speech.make(str(MATERIAL), talk.index, 0)
        assert 35 < spoken.duration < 80 and len(spoken.affect) > 0.8 * len(talk.script.sentences)
        assert words_are_heard(spoken.clean, spoken.words) < 0.05
        assert (np.abs(spoken.affect - 0.5).max() == 0) == (talk is natural)


@needs_prompts
def test_prompts_make_talks_of_a_minute():
    groups = human_speech.prompt_talks(0)
    files = [file for group in groups for file in group]
    assert len(groups) >= 20 and len(files) == len(set(files))
    assert not any(file.parent.name == "silence" or "beep" in file.stem for file in files)
    audio = human_speech.join_prompts(groups[0], np.random.default_rng(0))
    assert 30 < len(audio) / RATE < 80
    loud = np.abs(audio) > 0.01
    assert 0.3 < loud[: len(loud) // 160 * 160].reshape(-1, 160).any(axis=1).mean() < 0.98


@needs_material
def test_without_the_prompts_their_talks_are_left_out(monkeypatch, tmp_path):
    monkeypatch.setattr(human_speech, "PROMPTS", tmp_path)
    human_speech.prompt_talks.cache_clear()
    index = next(talk.index for talk in speech.talks(str(MATERIAL), 0) if talk.kind == "human:prompts")
    assert human_speech.prompts() == [] and speech.make(str(MATERIAL), index, 0) is None
    human_speech.prompt_talks.cache_clear()
