"""The paper's figure 3 as a page: rows of one speech and one seed pose, drawn where they are."""

import re

import numpy as np
import pytest

pytest.importorskip("torch")

from s2ag.core import user_folders  # noqa: E402
from s2ag.core.cli.main import main  # noqa: E402
from s2ag.core.motion import rest, skeleton  # noqa: E402
from s2ag.core.study import figure  # noqa: E402
from sounds import write_wav  # noqa: E402
from toy_bench import write_bench_corpus  # noqa: E402


@pytest.fixture
def home(tmp_path, monkeypatch):
    """A folder of data in which nothing has been made."""
    monkeypatch.setenv(user_folders.ENVIRONMENT_VARIABLE, str(tmp_path / "home"))


def test_figures_stand_at_their_times(tmp_path):
    sound = tmp_path / "a.wav"
    write_wav(sound, np.zeros(16000))
    motion = np.repeat(rest.REST[None], 30, axis=0)
    rows = [figure.Row("seed pose", "", motion[:1]), figure.Row("<S2AG>", "9 steps", motion)]
    page = figure.section(figure.Excerpt("talk & me", sound), (("a<b", 0.5, 0.9),), rows, 2.0)
    assert "talk &amp; me" in page and "&lt;S2AG&gt;" in page and "a&lt;b" in page
    assert "9 steps; wrists 0 cm/s, 0.0 movements a second" in page
    _, seed, performed = re.findall(r"<svg.*?</svg>", page)
    bones = [re.findall(r'points="([^"]*)" stroke="#[0-9a-f]+" stroke-width="2"', row) for row in (seed, performed)]
    assert [len(each) for each in bones] == [9, 4 * 9], "two seconds have figures at 0, 0.5, 1 and 1.5 s"
    first, second = (np.array([[float(x) for x in point.split(",")] for point in bone.split()]) for bone in bones[1][0::9][:2])
    np.testing.assert_allclose(second - first, [[100, 0]] * 2, atol=0.11)
    hips, neck = first
    assert hips[1] > neck[1], "y of a page goes down"
    left = [float(bones[1][5].split()[1].split(",")[0]), float(bones[1][8].split()[1].split(",")[0])]
    assert left[0] > left[1], "seen from the front, the left wrist is on the right"


def test_excerpts_of_a_corpus_begin_with_a_word(tmp_path):
    corpus = write_bench_corpus(tmp_path / "corpus")
    (excerpt,) = figure.from_corpus(corpus, tmp_path, seconds=4.0)
    assert excerpt.performed.shape == (60, 9, 3) and excerpt.sound.is_file() and excerpt.transcript.is_file()
    np.testing.assert_array_equal(excerpt.seed, excerpt.performed[0])
    directions, words = figure.perform(excerpt, None, seconds=4.0)
    assert directions.shape == (60, 9, 3) and words
    assert words[0][1] < 0.5 / skeleton.FPS, "the cut is at a frame, half a frame from the word at most"


def test_the_command_leaves_out_what_is_not_made(home, tmp_path, capsys):
    sound, page = tmp_path / "a.wav", tmp_path / "page.html"
    write_wav(sound, np.random.default_rng(0).normal(0, 0.1, 32000))
    (tmp_path / "a.txt").write_text("one day")
    assert main(["study", "figure", str(sound), "--seconds", "2", "-o", str(page)]) == 0
    said = capsys.readouterr()
    assert said.err.count("Left out") == 3 and "1 excerpts, default" in said.out
    text = page.read_text("utf-8")
    assert text.count("<tr>") == 3 and ">one</text>" in text and "data:audio/wav;base64," in text
    assert main(["study", "figure", str(sound), "--row", "S2AG=published", "-o", str(page)]) == 2
    assert "s2ag checkpoint train" in capsys.readouterr().err
    assert main(["study", "figure", "-o", str(page)]) == 2
    assert main(["study", "figure", str(sound), "--row", "S2AG", "-o", str(page)]) == 2
