"""Idles judged against captured ones: the captures by body and part, and what a judge needs."""

import pytest
from s2ag.core.cli.main import main
from s2ag.core.errors import UsageError
from s2ag.core.learning.evaluate import idles


def test_captured_idles_are_of_two_bodies_in_two_parts_each(shared):
    found = idles.captured(shared)
    assert {kind.partition(",")[0] for kind in found} == {"a woman waits", "a man waits"} and len(found) == 4
    assert min(sum(map(len, motions)) for motions in found.values()) > 60 * 15
    assert all(motion.shape[1:] == (9, 3) for motions in found.values() for motion in motions)


def test_listeners_move_as_captured_ones_do(shared, examples):
    found = idles.listeners(shared, [examples / "hello.flac"])
    people, ours = found["captured"], found["ours"]
    assert len(people) == 3 and len(ours) == len(idles.STYLES)
    assert (0.5 * people.min(0) < ours.mean(0)).all() and (ours.mean(0) < 1.5 * people.max(0)).all()


def test_without_captures_it_is_said(tmp_path, capsys):
    with pytest.raises(UsageError, match="no captured idles"):
        idles.captured(tmp_path)
    assert main(["evaluate", "--idles"]) == 2 and "--material is required" in capsys.readouterr().err
