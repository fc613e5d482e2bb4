"""The user study: balanced orders, a page that works in a real browser, and intervals that hold what they say."""

import functools
import http.server
import itertools
import json
import shutil
import threading

import browser
import numpy as np
import pytest
from s2ag.core.cli.main import main
from s2ag.core.errors import OutputUnwritable, UsageError
from s2ag.core.study import analysis, build, design
from short_films import films

CONDITIONS, EXCERPTS = ("gtc", "original", "ours"), ("a", "b")


@pytest.fixture(scope="module")
def clips(tmp_path_factory):
    return films(tmp_path_factory.mktemp("clips"), CONDITIONS, EXCERPTS)


@pytest.fixture
def study(clips, tmp_path, capsys):
    assert main(["study", "make", str(clips), "-o", str(tmp_path / "study"), "--participants", "6"]) == 0
    assert "3 conditions, 2 excerpts" in capsys.readouterr().out
    return tmp_path / "study"


@pytest.mark.parametrize("count", [2, 3, 4, 5])
def test_a_williams_square_is_balanced(count):
    rows = design.williams(count)
    for place in range(count):
        assert len({rows_at := tuple(sorted(row[place] for row in rows))}) == 1
        assert all(rows_at.count(value) == len(rows) // count for value in range(count))
    follows = [pair for row in rows for pair in itertools.pairwise(row)]
    assert {follows.count(pair) for pair in itertools.permutations(range(count), 2)} == {
        len(rows) * (count - 1) // (count * (count - 1))
    }


def test_orders_are_balanced_shuffled_and_the_same_again():
    keys = [(c, f"{n:02d}") for c in CONDITIONS for n in range(12)]
    plan = design.Design(CONDITIONS, tuple(f"{n:02d}" for n in range(12)), {}, {key: str(key) for key in keys}, 0)
    orders = [plan.order(person) for person in range(24)]
    assert orders == [plan.order(person) for person in range(24)]
    assert all(sorted(order) == sorted(keys) for order in orders)
    firsts = [order[place][0] for order in orders for place in range(0, 36, 3)]
    assert all(firsts.count(condition) == 24 * 12 / 3 for condition in CONDITIONS)
    assert len({tuple(excerpt for _, excerpt in order[::3]) for order in orders}) > 20
    for excerpt in plan.excerpts:
        first = [next(c for c, e in order if e == excerpt) for order in orders]
        assert {first.count(condition) for condition in CONDITIONS} == {8}


def test_the_page_does_not_tell_conditions(study):
    page = study / "page"
    text = "".join(path.read_text() for path in page.glob("*.*")) + " ".join(path.name for path in (page / "clips").iterdir())
    assert len(list((page / "clips").iterdir())) == 6
    assert not any(f"{word}" in text for word in ("gtc", "ours")) and "http" not in text
    key = json.loads((study / "key.json").read_text())
    assert {(clip["condition"], clip["excerpt"]) for clip in key["clips"].values()} == set(
        itertools.product(CONDITIONS, EXCERPTS)
    )


def test_wrong_folders_are_one_sentence(tmp_path, clips, capsys):
    (tmp_path / "one" / "ours").mkdir(parents=True)
    (tmp_path / "one" / "ours" / "a.mp4").write_bytes(b"")
    (tmp_path / "two" / "ours").mkdir(parents=True)
    (tmp_path / "two" / "gtc").mkdir()
    (tmp_path / "two" / "ours" / "a.mp4").write_bytes(b"")
    (tmp_path / "two" / "gtc" / "b.mp4").write_bytes(b"")
    for folder, sentence in (("none", "no folder"), ("one", "1 conditions"), ("two", "has no clip")):
        assert main(["study", "make", str(tmp_path / folder), "-o", str(tmp_path / "out")]) == 2
        assert sentence in capsys.readouterr().err
    with pytest.raises(OutputUnwritable, match="not empty"):
        build.build(design.find(clips), tmp_path / "one", "x")


def answer_file(folder, key, person, rate):
    answers = [
        {"clip": name, **dict(zip(("plausibility", "synchrony"), rate(clip["condition"], clip["excerpt"]), strict=True))}
        for name, clip in key["clips"].items()
    ]
    path = folder / f"answers-{person}.json"
    path.write_text(json.dumps({"study": key["id"], "participant": person, "answers": answers}))
    return path


def test_shares_and_differences(study, tmp_path, capsys):
    key = json.loads((study / "key.json").read_text())
    rates = {"ours": (5, 4), "original": (4, 2), "gtc": (2, 1)}
    files = [answer_file(tmp_path, key, n, lambda c, e, n=n: rates[c] if n % 4 else (3, 3)) for n in range(1, 9)]
    found = analysis.analyse(analysis.read(files, study / "key.json"), "ours")["questions"]
    assert found["plausibility"]["conditions"]["ours"]["share"] == 0.75
    assert found["plausibility"]["conditions"]["ours"]["counts"] == [0, 0, 4, 0, 12]
    assert found["plausibility"]["differences"]["gtc"]["difference"] == 0.75
    assert found["plausibility"]["differences"]["original"] == {"difference": 0.0, "interval": [0.0, 0.0]}
    low, high = found["synchrony"]["conditions"]["ours"]["interval"]
    assert 0.3 < low < 0.75 < high <= 1
    command = ["study", "analyse", *map(str, files), "--key", str(study / "key.json"), "--ours", "ours"]
    assert main([*command, "-o", str(tmp_path / "a.json")]) == 0
    assert "ours over gtc: +75.00%" in capsys.readouterr().out and (tmp_path / "a.json").is_file()


def test_the_interval_covers_the_truth_as_often_as_it_says():
    rng, held = np.random.default_rng(0), 0
    for trial in range(100):
        lean = rng.normal(0.5, 0.15, (24, 1, 1)).clip(0, 1)
        ratings = np.where(rng.random((24, 2, 12)) < lean, 5.0, 1.0)
        given = analysis.Answers(tuple(range(24)), ("a", "b"), tuple(map(str, range(12))), {"plausibility": ratings})
        low, high = analysis.analyse(given, seed=trial)["questions"]["plausibility"]["conditions"]["a"]["interval"]
        held += low <= 0.5 <= high
    assert held >= 86


def test_wrong_answers_are_named(study, tmp_path):
    key = json.loads((study / "key.json").read_text())
    good = answer_file(tmp_path, key, 1, lambda c, e: (3, 3))
    (tmp_path / "twice").mkdir()
    twice = answer_file(tmp_path / "twice", key, 1, lambda c, e: (3, 3))
    odd = answer_file(tmp_path, key, 2, lambda c, e: (6, 3))
    other = answer_file(tmp_path, {**key, "id": "other"}, 3, lambda c, e: (3, 3))
    (tmp_path / "text.json").write_text("no")
    for files, sentence in (
        ([good, twice], "occurs twice"), ([odd], "plausibility is 6"), ([other], "belongs to the study"),
        ([tmp_path / "text.json"], "cannot be read"), ([], "no answers"),
    ):  # fmt: skip
        with pytest.raises(UsageError, match=sentence):
            analysis.read(files, study / "key.json")
    with pytest.raises(UsageError, match="no key"):
        analysis.read([good], good)
    with pytest.raises(UsageError, match="no condition"):
        analysis.analyse(analysis.read([good], study / "key.json"), "magic")
    missing = json.loads(good.read_text())
    del missing["answers"][0]
    good.write_text(json.dumps(missing))
    assert np.isnan(analysis.read([good], study / "key.json").ratings["synchrony"]).sum() == 1


@pytest.fixture
def served(study):
    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=str(study / "page")))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_address[1]}/index.html"
    server.shutdown()


@pytest.mark.slow
@pytest.mark.skipif(bool(browser.MISSING), reason=browser.MISSING)
def test_a_participant_goes_through_the_page(study, served, tmp_path):
    downloads = tmp_path / "downloads"
    downloads.mkdir()
    orders = json.loads((study / "page" / "study-data.js").read_text().removeprefix("window.STUDY = ").rstrip(";\n"))["orders"]
    with browser.Browser(downloads) as window:
        window.open(served)
        assert window.shown("#welcome") and not window.shown("#trial")
        window.type("#number", "3")
        window.click("#begin button")
        for place, clip in enumerate(orders[2]):
            window.wait(lambda clip=clip: window.run("return document.getElementById('clip').src").endswith(clip))
            assert window.run("return document.querySelector('#answers fieldset').disabled")
            window.run("document.getElementById('clip').play()")
            window.wait(lambda: not window.run("return document.querySelector('#answers fieldset').disabled"))
            if place == 0:
                assert not window.shown("#right")
                window.click("#answers button")  # unanswered: the browser asks for answers, the page stays
                assert window.run("return document.getElementById('progress').textContent") == "Clip 1 of 6"
            window.click(f"input[name=plausibility][value='{1 + place % 5}']")
            window.click("input[name=synchrony][value='4']")
            window.click("#answers button")
            if place == 2:  # the browser is closed and opened again
                window.open("about:blank")
                window.open(served)
                assert window.run("return document.getElementById('progress').textContent") == "Clip 4 of 6"
        window.wait(lambda: window.shown("#done"))
        window.click("#save-json")
        window.wait(lambda: (downloads / "answers-3.json").is_file())
        window.click("#save-csv")
        window.wait(lambda: (downloads / "answers-3.csv").is_file())
        window.open(served)
        assert window.shown("#welcome") and not window.shown("#broken")
    saved = json.loads((downloads / "answers-3.json").read_text())
    assert [one["clip"] for one in saved["answers"]] == orders[2] and saved["answers"][5]["plausibility"] == 1
    assert len((downloads / "answers-3.csv").read_text().splitlines()) == 7
    found = analysis.analyse(analysis.read([downloads / "answers-3.json"], study / "key.json"))
    assert all(one["share"] == 1 for one in found["questions"]["synchrony"]["conditions"].values())


@pytest.mark.skipif(bool(browser.MISSING), reason=browser.MISSING)
def test_the_page_also_opens_from_a_disk_and_tells_what_is_missing(study, tmp_path):
    with browser.Browser(tmp_path) as window:
        window.open((study / "page" / "index.html").as_uri())
        assert window.shown("#welcome") and window.run("return document.title") == "Gesture study"
        shutil.copytree(study / "page", tmp_path / "torn", ignore=shutil.ignore_patterns("study-data.js"))
        window.open((tmp_path / "torn" / "index.html").as_uri())
        assert window.shown("#broken") and not window.shown("#welcome")
