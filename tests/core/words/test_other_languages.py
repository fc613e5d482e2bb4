"""Words of other languages, pronounced by eSpeak NG. ``pytest tests/core/words/test_other_languages.py -rP`` prints figures."""

import foreign_speech
import numpy as np
import pytest
from s2ag.core import optional_packages
from s2ag.core.errors import EngineMissing, TranscriptUnreadable
from s2ag.core.synthesis.session import Request, Session
from s2ag.core.words import align, hints, language, markup, transcript
from s2ag.core.words.aligner.espeak import MAX_PRONUNCIATIONS, ipa_to_cmu
from s2ag.core.words.recognise import recognise
from s2ag.core.words.spelling import split_foreign

pytest.importorskip("pocketsphinx", reason="the aligner is not installed")


@pytest.fixture(scope="module")
def german(tmp_path_factory):
    pytest.importorskip("espeakng_loader", reason="the extra `languages` is not installed")
    text = foreign_speech.TEXTS["de"]
    return text, *foreign_speech.formants("de", text, tmp_path_factory.mktemp("german"))


def measured(name, code, sound, said):
    """Errors in ms and the share of words that were lost."""
    pytest.importorskip("espeakng_loader", reason="the extra `languages` is not installed")
    ways = transcript.TranscriptOptions(model=language.load_language(code=code))
    found = transcript.timed_transcript(sound, text=" ".join(word for word, _ in said), ways=ways)
    assert len(found.words) == len(said)
    off = [abs(start - true) for (_, start, _), (_, true) in zip(found.words, said, strict=True) if true is not None]
    off, lost = 1000 * np.array(off), np.mean(np.array(found.confidence) == 0)
    near = 100 * np.mean(off <= 80)
    print(
        f"{name}: {len(off)} starts, mean {off.mean():.1f} ms, median {np.median(off):.0f}, {near:.1f} % within 80 ms, ", end=""
    )
    print(f"{lost:.1%} of {len(said)} words lost")
    return off, lost


@pytest.mark.slow
@pytest.mark.parametrize("code", ["de", "es", "fr"])
def test_formants(code, tmp_path):
    pytest.importorskip("espeakng_loader", reason="the extra `languages` is not installed")
    sound, said = foreign_speech.formants(code, foreign_speech.TEXTS[code], tmp_path)
    off, lost = measured(f"formants, {code}", code, sound, said)
    assert off.mean() < 40 and np.mean(off <= 80) > 0.9 and lost < 0.1


@pytest.mark.parametrize("voice", ["de5", "de6", "de7"])
def test_diphones(voice, tmp_path):
    if not foreign_speech.has_diphones(voice):
        pytest.skip(f"mbrola, mbrola-{voice} (Debian, non-free) and espeak-ng are not installed")
    sound, said = foreign_speech.diphones(voice, foreign_speech.TEXTS["de"], tmp_path)
    off, lost = measured(f"diphones of a person, {voice}", "de", sound, said)
    assert off.mean() < 30 and np.mean(off <= 80) > 0.95 and not lost


@pytest.mark.parametrize("code", ["es", "fr", "it", "ru"])
def test_people(code):
    """Telephone bandwidth, isolated prompts without pauses, texts with errors: harder than a talk."""
    package = f"asterisk-core-sounds-{code}"
    if not (foreign_speech.SHARE / "doc" / package / f"core-sounds-{code}.txt.gz").is_file():
        pytest.skip(f"{package} and {package}-wav are not installed")
    off, lost = measured(f"prompts by a person, {code}", code, *foreign_speech.prompts(code))
    assert np.median(off) < 40 and np.mean(off <= 80) > 0.7 and lost < 0.08


@pytest.mark.slow
def test_a_missing_sentence_and_another_text(german):
    text, sound, said = german
    ways = transcript.TranscriptOptions(model=language.load_language(code="de"))
    extra = "Übrigens fliegen morgen dreizehn gelbe Flugzeuge nach Australien zurück."
    longer = text.replace("Meine Schwester", extra + " Meine Schwester")
    found = transcript.timed_transcript(sound, text=longer, ways=ways)
    first = [word for word, _, _ in found.words].index("Übrigens")
    lost = {number for number, sure in enumerate(found.confidence) if not sure}
    own = set(range(first, first + len(extra.split())))
    assert len(own - lost) <= 4 and len(lost - own) <= 3
    other = transcript.timed_transcript(sound, text=extra * 25, ways=ways)
    assert "does not fit" in other.warnings[0]


def test_numbers_are_read_in_the_language(tmp_path, german):
    sound, said = foreign_speech.formants("de", "Wir kamen im Jahr neunzehn an und blieben fünf Komma drei Wochen.", tmp_path)
    found = transcript.timed_transcript(
        sound,
        text="Wir kamen im Jahr 19 an und blieben 5,3 Wochen.",
        ways=transcript.TranscriptOptions(model=language.load_language(code="de")),
    )
    starts = dict(said)
    assert [word for word, _, _ in found.words][4] == "19" and all(found.confidence)
    assert abs(found.words[4][1] - starts["neunzehn"]) < 0.08 and abs(found.words[-1][1] - starts["Wochen"]) < 0.08


def test_words_say_nothing_to_an_english_network(german, tmp_path):
    """ "die" and "war" are not the English ones: with the language only hints reach the network."""
    from sounds import write_wav

    text, sound, said = german
    write_wav(tmp_path / "said.wav", sound[: 16000 * 8])
    part = " ".join(word for word, start in said if start < 7.5)
    session = Session(language="de", cache="off")
    plain, hinted = (session.synthesize(Request(tmp_path / "said.wav", text=one)) for one in (part, "{me} " + part))
    assert [word for word, _, _ in plain.words][0] == "Guten" and plain.warnings == []
    assert not np.array_equal(plain.motions[0].directions, hinted.motions[0].directions)
    assert Session(cache="off").understands and Session(language="en", cache="off").understands and not session.understands


def test_what_the_network_hears():
    words, wishes = [("die", 0.0, 1.0), ("Zeit", 1.0, 2.0)], hints.HintEffects(gestures={1: ("me", 0.0)})
    assert hints.network_words(words, wishes) == [("die", 0.0, 1.0), ("me", 1.0, 2.0)]
    assert hints.network_words(words, wishes, understood=False) == [("", 0.0, 1.0), ("me", 1.0, 2.0)]


@pytest.mark.parametrize(
    ("ipa", "said"),
    [
        ("_ɪ_ç", ["IH HH", "IH SH"]),
        ("pf_l_ˈaʊ_m_ə_n", ["P F L AW M AH N"]),
        ("ˈøː", ["ER", "EH"]),
        ("m_ˈɔ̃_t_ˈa_ɲ", ["M AO N T AA N Y", "M AO N T AE N Y"]),
        ("ˈeː_(en)_m_ˈeɪ_l_(de)", ["EY M EY L", "EH M EY L"]),
        ("ts v_ˈaɪ", ["T S V AY"]),
        ("", []),
        ("(de)_5_ˈ", []),
    ],
)
def test_sounds_of_other_languages(ipa, said):
    assert ipa_to_cmu(ipa) == said


def test_no_word_has_too_many_pronunciations():
    assert len(ipa_to_cmu("_".join("ɾaxø" * 20))) == MAX_PRONUNCIATIONS


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("Grüße!", ["grüße"]),
        ("„Vor-Ort-Termin“", ["vor", "ort", "termin"]),
        ("3,5", ["3,5"]),
        ("20€", ["20€"]),
        ("5–10", ["5", "10"]),
        ("%", ["%"]),
        ("l’homme", ["l'homme"]),
        ("Kolleg(inn)en", ["kolleginnen"]),
        ("¿Qué?", ["qué"]),
        ("здравствуйте,", ["здравствуйте"]),
        ("—", []),
        ("+", []),
    ],
)
def test_words_are_left_to_the_language(word, said):
    assert split_foreign(word) == said
    assert [parts for _, parts in markup.parse(word, split_foreign).tokens] == ([said] if said else [])


def test_languages_that_cannot_be(tmp_path, monkeypatch):
    assert (
        language.load_language() is None
        and language.load_language(code="en-GB") is None
        and language.load_language(code=" EN ") is None
    )
    with pytest.raises(TranscriptUnreadable, match="English only"):
        recognise_german()
    monkeypatch.setattr(optional_packages, "ESPEAK", "no_such_package_anywhere")
    with pytest.raises(EngineMissing, match=r"s2ag\[languages\]"):
        language.load_language(code="de")


def recognise_german():
    recognise(np.zeros(16000, np.float32), language="de")


def test_codes_and_folders(tmp_path):
    pytest.importorskip("espeakng_loader", reason="the extra `languages` is not installed")
    assert language.load_language(code="pt_BR")["voice"] == "pt-BR" and language.load_language(code="fr-fr")["voice"] == "fr"
    with pytest.raises(TranscriptUnreadable, match="does not know the language xx"):
        language.load_language(code="xx")
    (tmp_path / "mdef").write_text("")
    (tmp_path / "own.dict").write_text("äpfel EH P F AH L\n", encoding="utf-8")
    with pytest.raises(TranscriptUnreadable, match="sounds of its own"):
        language.load_language(tmp_path, "de")
    (tmp_path / "mdef").unlink()
    both = language.load_language(tmp_path, "de")
    assert both["dictionary"] and both["voice"] == "de"
    assert language.fingerprint(both) != language.fingerprint(language.load_language(tmp_path))


def test_the_users_dictionary_comes_first(german, tmp_path):
    """A word that is pronounced as nonsense there is lost, whatever eSpeak NG knows."""
    _, sound, said = german
    (tmp_path / "own.dict").write_text("willkommen " + "S IY " * 30 + "\n", encoding="utf-8")
    sound, stretch = sound[: int(16000 * said[9][1])], align.Stretch([split_foreign(word) for word, _ in said[:9]])
    own, without = (
        align.align_stretches(sound, [stretch], None, language.load_language(folder, "de")) for folder in (tmp_path, None)
    )
    assert all(without.confidence) and not own.confidence[4]
