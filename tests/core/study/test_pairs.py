"""Two clips side by side: balanced sides, other speech under the same motion, a page that works, tests that hold."""

import itertools
import json
import math

import browser
import numpy as np
import pytest
from s2ag.core.cli.main import main
from s2ag.core.errors import UsageError
from s2ag.core.study import analysis, pairs, sounds
from short_films import film, films

CONDITIONS, EXCERPTS = ("gtc", "original", "ours"), ("a", "b", "c")


@pytest.fixture(scope="module")
def clips(tmp_path_factory):
    """Excerpts of other lengths and other tones."""
    return films(tmp_path_factory.mktemp("clips"), CONDITIONS, EXCERPTS, other=True)


def made(clips, folder, form, capsys, participants=4):
    command = ["study", "make", str(clips), "-o", str(folder), "--form", form, "--participants", str(participants)]
    assert main(command) == 0
    capsys.readouterr()
    shown = json.loads((folder / "page" / "study-data.js").read_text().removeprefix("window.STUDY = ").rstrip(";\n"))
    return shown, json.loads((folder / "key.json").read_text())


def answers(folder, shown, key, person, score):
    """The file of a participant who gives each question ``score(left, right)``, counted to the right."""
    given = []
    for left, right in shown["orders"][(person - 1) % len(shown["orders"])]:
        value = score(key["clips"][left], key["clips"][right])
        given.append({"left": left, "right": right, **{one["id"]: value for one in shown["questions"]}})
    path = folder / f"answers-{person}.json"
    path.write_text(json.dumps({"study": key["id"], "participant": person, "answers": given}))
    return path


def test_every_two_conditions_meet_on_both_sides(clips, tmp_path, capsys):
    shown, key = made(clips, tmp_path / "study", "pairs", capsys)
    every = {frozenset(((a, e), (b, e))) for e in EXCERPTS for a, b in itertools.combinations(CONDITIONS, 2)}
    sides = []
    for order in shown["orders"]:
        met = [tuple((key["clips"][name]["condition"], key["clips"][name]["excerpt"]) for name in pair) for pair in order]
        assert {frozenset(pair) for pair in met} == every and len(met) == len(every)
        sides.append({frozenset(pair): pair[0] for pair in met})
    for first, second in (sides[:2], sides[2:]):
        assert all(first[pair] != second[pair] for pair in every)
    assert shown["orders"][0] != shown["orders"][2] and [one["id"] for one in shown["questions"]] == [
        "realism",
        "appropriateness",
    ]


def test_own_and_other_speech_under_the_same_motion(clips, tmp_path, capsys):
    shown, key = made(clips, tmp_path / "study", "matched", capsys)
    assert len(key["clips"]) == 18 and all(len(order) == 9 for order in shown["orders"])
    named = {(one["condition"], one["excerpt"], one["sound"]): name for name, one in key["clips"].items()}
    place = tmp_path / "study" / "page" / "clips"

    def hertz(name):
        samples = sounds._samples(place / name, 24000)
        return np.argmax(np.abs(np.fft.rfft(samples))) * 2

    def picture(name):
        import av

        with av.open(str(place / name)) as opened:
            return [frame.to_ndarray(format="gray")[20, 30] for frame in opened.decode(video=0)]

    for number, (excerpt, other) in enumerate((("a", "b"), ("b", "c"), ("c", "b"))):
        own, odd = (named["ours", excerpt, sound] for sound in ("own", "other"))
        assert picture(own) == picture(odd) and len(picture(own)) == 8 + 2 * number
        assert hertz(own) == pytest.approx(16000 / (2 * math.pi * (3 + 2 * number)), abs=10)
        assert hertz(odd) == pytest.approx(16000 / (2 * math.pi * (3 + 2 * EXCERPTS.index(other))), abs=10)
        assert sounds.film_seconds(place / own) == pytest.approx(sounds.film_seconds(place / odd))
    for pair in shown["orders"][0]:
        assert {key["clips"][name]["sound"] for name in pair} == {"own", "other"}
        assert len({key["clips"][name]["excerpt"] for name in pair}) == 1


def test_one_condition_is_enough_for_the_mismatch_and_one_excerpt_is_not(clips, tmp_path, capsys):
    (tmp_path / "clips").mkdir()
    (tmp_path / "clips" / "ours").symlink_to(clips / "ours")
    made(tmp_path / "clips", tmp_path / "study", "matched", capsys)
    (tmp_path / "few" / "ours").mkdir(parents=True)
    film(tmp_path / "few" / "ours" / "a.mp4")
    for form, sentence in (("matched", "second excerpt"), ("pairs", "1 conditions"), ("magic", "no form")):
        assert main(["study", "make", str(tmp_path / "few"), "-o", str(tmp_path / "out"), "--form", form]) == 2
        assert sentence in capsys.readouterr().err


def test_shares_tests_and_strengths(clips, tmp_path, capsys):
    shown, key = made(clips, tmp_path / "study", "pairs", capsys, 8)
    worth = {"gtc": 0, "original": 1, "ours": 2}

    def score(left, right):
        gap = worth[right["condition"]] - worth[left["condition"]]
        return gap if "gtc" in (left["condition"], right["condition"]) else 0

    files = [answers(tmp_path, shown, key, person, score) for person in range(1, 9)]
    found = pairs.analyse(pairs.read(files, tmp_path / "study" / "key.json"), "ours")["questions"]["realism"]
    assert {"ours/gtc", "ours/original"} < set(found["pairs"]) and len(found["pairs"]) == 3
    best = found["pairs"]["ours/gtc"]
    assert best["counts"] == {"2": 24, "1": 0, "0": 0, "-1": 0, "-2": 0} and best["share"] == 1 and best["mean"] == 2
    assert best["p"] == pytest.approx(2 / 2**8) and best["p_holm"] == pytest.approx(6 / 2**8)
    even = found["pairs"]["ours/original"]
    assert (even["share"], even["mean"], even["p"], even["interval"]) == (0.5, 0, 1, [0.5, 0.5])
    strengths = found["strengths"]
    assert strengths["gtc"] < 0 < strengths["original"] == pytest.approx(strengths["ours"])
    command = ["study", "analyse", *map(str, files), "--key", str(tmp_path / "study" / "key.json"), "--ours", "ours"]
    assert main([*command, "-o", str(tmp_path / "a.json")]) == 0
    assert "ours over gtc: 100.00% [100.00%, 100.00%]  mean +2.00" in capsys.readouterr().out


def test_the_mismatch_is_analysed(clips, tmp_path, capsys):
    shown, key = made(clips, tmp_path / "study", "matched", capsys)

    def score(left, right):
        return 0 if left["condition"] == "gtc" else (1 if right["sound"] == "own" else -1)

    files = [answers(tmp_path, shown, key, person, score) for person in range(1, 5)]
    found = pairs.analyse(pairs.read(files, tmp_path / "study" / "key.json"))["questions"]["appropriateness"]
    assert set(found["pairs"]) == {f"{condition}/{pairs.OTHER}" for condition in CONDITIONS} and found["strengths"] == {}
    assert found["pairs"]["ours/other sound"]["mean"] == 1 and found["pairs"]["gtc/other sound"]["share"] == 0.5


def test_the_sign_test_is_what_the_textbooks_have():
    assert pairs.sign_test(9, 1) == pytest.approx(22 / 1024) and pairs.sign_test(0, 0) == 1 and pairs.sign_test(5, 5) == 1


def test_strengths_are_those_of_the_odds():
    rng, worth = np.random.default_rng(0), {"a": 0.0, "b": 0.7, "c": -0.5}
    votes = {}
    for one, other in itertools.combinations(worth, 2):
        chance = 1 / (1 + math.exp(worth[other] - worth[one]))
        votes[one, other] = np.where(rng.random((200, 100)) < chance, 1.0, -1.0)
    found = pairs.strengths(votes, tuple(worth))
    mean = sum(worth.values()) / 3
    # the error of log odds from 20,000 votes is about 0.015
    assert all(abs(found[name] - (value - mean)) < 0.08 for name, value in worth.items())


def test_wrong_answers_are_named(clips, tmp_path, capsys):
    shown, key = made(clips, tmp_path / "study", "pairs", capsys)
    odd = answers(tmp_path, shown, key, 1, lambda left, right: 3)
    with pytest.raises(UsageError, match="realism is 3"):
        pairs.read([odd], tmp_path / "study" / "key.json")
    content = json.loads(odd.read_text())
    content["answers"] = [{**content["answers"][0], "right": content["answers"][0]["left"], "realism": 1, "appropriateness": 1}]
    odd.write_text(json.dumps(content))
    with pytest.raises(UsageError, match="no pair"):
        pairs.read([odd], tmp_path / "study" / "key.json")
    with pytest.raises(UsageError, match="no condition"):
        good = answers(tmp_path, shown, key, 1, lambda left, right: 1)
        pairs.analyse(pairs.read([good], tmp_path / "study" / "key.json"), "magic")
    (tmp_path / "key.json").write_text(json.dumps({**key, "form": "magic"}))
    with pytest.raises(UsageError, match="no key"):
        analysis.read_key(tmp_path / "key.json")


def test_partners_are_the_next_longer():
    assert sounds.sound_partners({"a": 3.0, "b": 1.0, "c": 2.0}) == {"b": "c", "c": "a", "a": "c"}


@pytest.mark.slow
@pytest.mark.skipif(bool(browser.MISSING), reason=browser.MISSING)
def test_a_participant_compares_pairs_on_the_page(clips, tmp_path, capsys):
    shown, key = made(clips, tmp_path / "study", "matched", capsys)
    downloads = tmp_path / "downloads"
    downloads.mkdir()
    with browser.Browser(downloads) as window:
        window.open((tmp_path / "study" / "page" / "index.html").as_uri())
        assert "differ in the speech alone" in window.run("return document.getElementById('intro').textContent")
        window.type("#number", "2")
        window.click("#begin button")
        for place, (left, right) in enumerate(shown["orders"][1]):
            window.wait(lambda right=right: window.run("return document.getElementById('right').src").endswith(right))
            assert window.run("return document.getElementById('clip').src").endswith(left) and window.shown("#right")
            for name in ("clip", "right"):
                assert window.run("return document.querySelector('#answers fieldset').disabled")
                window.run(f"document.getElementById('{name}').play()")
                window.wait(lambda name=name: window.run(f"return document.getElementById('{name}').ended"))
            window.wait(lambda: not window.run("return document.querySelector('#answers fieldset').disabled"))
            window.click(f"input[name=appropriateness][value='{place % 5 - 2}']")
            window.click("#answers button")
        window.wait(lambda: window.shown("#done"))
        window.click("#save-json")
        window.wait(lambda: (downloads / "answers-2.json").is_file())
        window.click("#save-csv")
        window.wait(lambda: (downloads / "answers-2.csv").is_file())
    saved = json.loads((downloads / "answers-2.json").read_text())
    assert [[one["left"], one["right"]] for one in saved["answers"]] == shown["orders"][1]
    assert [one["appropriateness"] for one in saved["answers"]] == [place % 5 - 2 for place in range(9)]
    assert (downloads / "answers-2.csv").read_text().startswith("participant,left,right,appropriateness,seconds\n")
    votes = pairs.read([downloads / "answers-2.json"], tmp_path / "study" / "key.json")
    assert sum(np.isfinite(scores).sum() for scores in votes.scores["appropriateness"].values()) == 9
