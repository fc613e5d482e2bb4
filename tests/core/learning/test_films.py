"""A folder of talks becomes takes for a data set, film by film."""

import numpy as np
import pytest
from s2ag.core.cli import main
from s2ag.core.errors import CorpusUnreadable
from s2ag.core.learning.capture import films
from s2ag.core.learning.capture.motion import Captured
from s2ag.core.motion import skeleton
from s2ag.core.motion.motion import Motion

UNSEEN = {"a": [[4.0, 6.0]], "b": [], "c": [[1.0, 9.0]]}


@pytest.fixture
def talks(tmp_path):
    """Two films of one speaker, and one of another that lies in no folder."""
    for name in ("ann/a.mp4", "ann/b.mov", "c.mkv", "ann/broken.mp4"):
        path = tmp_path / "talks" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(name.encode())
    return tmp_path / "talks"


def look(film, output):
    """Ten seconds that a film shows; the estimator is not installed beside the tests."""
    if film.stem == "broken":
        raise CorpusUnreadable("The film cannot be read.", "Get it again.")
    motion = Motion(np.tile(skeleton.MEAN_UNIT, (150, 1, 1)), words=(("one", 1.0, 1.5), ("two", 7.0, 7.5)))
    motion.meta["unseen"] = UNSEEN[film.stem]
    return Captured(motion, np.linspace(-1, 1, 160_000), [])


def test_films_become_pieces_that_were_seen(talks, tmp_path):
    told = films.collect(talks, tmp_path / "takes", look=look)
    assert [one.split(":")[0] for one in told] == ["ann/a", "ann/broken", "c"]
    assert "2.0 of 10.0 seconds" in told[0] and "cannot be read" in told[1] and "10.0 of 10.0" in told[2]
    takes = films.listed(tmp_path / "takes")
    assert [one.name for one in takes] == ["ann/a-1", "ann/a-2", "ann/b-1"] and {one.speaker for one in takes} == {"ann"}
    assert takes[0].split == takes[1].split
    second = Motion.load(takes[1].motion)
    assert second.duration == pytest.approx(4) and [word[:2] for word in second.words] == [("two", pytest.approx(1.0))]


def test_a_second_run_looks_at_what_is_new_alone(talks, tmp_path):
    first = films.collect(talks, tmp_path / "takes", look=look)
    (talks / "ann" / "b.mov").write_bytes(b"another film")
    seen = []
    assert films.collect(talks, tmp_path / "takes", look=lambda *film: seen.append(film[0].name) or look(*film)) == first
    assert seen == ["b.mov"]
    whole = look(talks / "ann" / "a.mp4", None)
    whole.motion.meta["unseen"] = []
    (talks / "ann" / "a.mp4").write_bytes(b"without the gap")
    films.collect(talks, tmp_path / "takes", look=lambda *film: whole)
    assert [one.name for one in films.listed(tmp_path / "takes")] == ["ann/a-1", "ann/b-1"]


def test_a_folder_without_films_is_told(tmp_path):
    with pytest.raises(CorpusUnreadable, match="no films"):
        films.collect(tmp_path, tmp_path / "takes", look=look)


def test_without_the_estimator_the_command_says_what_to_install(talks, tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("S2AG_CAPTURE_PYTHON", str(tmp_path / "nothing"))
    assert main.main(["data", "films", str(talks), "-o", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err.startswith("s2ag: ")
