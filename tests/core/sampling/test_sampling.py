"""Samples: what a sheet says can be made again exactly, styles walk, and the map leads back into the latent space."""

import json

import numpy as np
import pytest
from rounding import bound, bound_of
from s2ag.core import styles
from s2ag.core.cli.main import main
from s2ag.core.errors import UsageError
from s2ag.core.model import loading
from s2ag.core.motion.motion import Motion
from s2ag.core.sampling import sheet as sheets
from s2ag.core.sampling.style_map import style_map

pytest.importorskip("torch", reason="the engine is not installed")

from s2ag.core.synthesis.session import Request, Session  # noqa: E402


@pytest.fixture(scope="module")
def session(random_checkpoint):
    return Session(random_checkpoint)


@pytest.fixture
def sampled(session, examples):
    """Two rows of three takes: a style and a walk."""
    request = Request(examples / "hello.flac", seed=4, takes=3, mirror=True, intensity=0.8)
    return sheets.sample(session, request, ["calm one", "calm one > lively one"])


def test_rows_are_styles_and_columns_takes(sampled):
    sheet, motions, _ = sampled
    assert [(one.row, one.column, one.take) for one in sheet.cells] == [(r, c, c) for r in (0, 1) for c in (0, 1, 2)]
    assert sheet.columns == 3 and len(motions) == 6 and sheet.cells[4].label == ("calm one > lively one", "seed 4  take 2")
    assert len({motion.directions.tobytes() for motion in motions}) == 6


def test_one_style_makes_a_square(session, examples):
    sheet, _, _ = sheets.sample(session, Request(examples / "hello.flac", takes=7), [""])
    assert [(one.row, one.column) for one in sheet.cells][3] == (1, 0) and sheet.columns == 3
    assert sheet.cells[0].style == "calm one"  # the default is named


@pytest.mark.parametrize("number", [2, 6])
def test_a_chosen_cell_is_made_again_exactly(sampled, tmp_path, random_checkpoint, number):
    sheet, motions, _ = sampled
    sheet.save(tmp_path / "sheet.json", words=[])
    out = tmp_path / "again.npz"
    where = f"{tmp_path / 'sheet.json'}:{number}"
    assert main(["synth", "--from", where, "--no-transcript", "--checkpoint", str(random_checkpoint), "-o", str(out)]) == 0
    again = Motion.load(out)
    limit = bound(loading.load(random_checkpoint))  # another batch size
    np.testing.assert_allclose(again.directions, motions[number - 1].directions, atol=limit)
    assert again.meta["mirror"] and again.meta["intensity"] == 0.8 and np.shape(again.meta["latent"])[1] == 16


def test_a_chosen_cell_says_what_its_sample_said(session, examples, tmp_path, random_checkpoint):
    from s2ag.core.cli import synthesis_options
    from s2ag.core.cli.parser import parser

    sheet, _, _ = sheets.sample(session, Request(examples / "hello.flac", text="hello"), [""])
    sheet.save(tmp_path / "sheet.json")
    arguments = ["--from", f"{tmp_path / 'sheet.json'}:1", "--checkpoint", str(random_checkpoint), "-o", "a.npz"]
    for more, text in (([], "hello"), (["--text", "good day"], "good day"), (["--no-transcript"], None)):
        wanted = synthesis_options.request(parser().parse_args(["synth", *arguments, *more]))
        assert wanted.text == text and wanted.transcript is None and not wanted.recognise


@pytest.mark.parametrize(
    ("where", "more", "said"),
    [
        (":9", [], "no cell 9"),
        (":x", [], "no cell x"),
        (":²", [], "no cell ²"),
        ("", [], "names no cell|is not a sample"),
        (":1", ["--style", "calm one"], "--style"),
        (":1", ["--intensity", "2"], "--intensity"),
        (":1", ["--affect", "arousal=1"], "controls"),
    ],
)
def test_wrong_cells_are_refused(sampled, tmp_path, capsys, random_checkpoint, where, more, said):
    import re

    sampled[0].save(tmp_path / "sheet.json")
    chosen = f"{tmp_path / 'sheet.json'}{where}"
    common = ["--checkpoint", str(random_checkpoint), "-o", str(tmp_path / "a.npz")]
    assert main(["synth", "--from", chosen, *more, *common]) == 2
    assert re.search(said, capsys.readouterr().err)
    assert not (tmp_path / "a.npz").exists()


def test_a_cell_of_another_checkpoint_is_refused(sampled, tmp_path, capsys, plain_checkpoint):
    sampled[0].save(tmp_path / "sheet.json")
    arguments = ["--from", f"{tmp_path / 'sheet.json'}:1", "--checkpoint", str(plain_checkpoint), "-o", str(tmp_path / "a.npz")]
    assert main(["synth", *arguments]) == 2
    assert "another checkpoint" in capsys.readouterr().err


def test_what_is_no_sample_says_so(tmp_path):
    for content in ("{", "[]", '{"format": 9}', '{"format": 1, "cells": [{}]}'):
        (tmp_path / "a.json").write_text(content)
        with pytest.raises(sheets.SampleUnreadable):
            sheets.Sheet.load(tmp_path / "a.json")


def test_a_walk_begins_and_ends_like_its_styles(session, examples):
    def made(style):
        return session.synthesize(Request(examples / "hello.flac", style=style))

    walk, first, last = made("calm one > lively one"), made("calm one"), made("lively one")
    np.testing.assert_array_equal(walk.latents[0], np.concatenate([first.latents[0], last.latents[0]]))
    directions = [result.motions[0].directions for result in (walk, first, last)]
    apart = np.abs(directions[0] - directions[1]).mean((1, 2)), np.abs(directions[0] - directions[2]).mean((1, 2))
    assert apart[0][:20].mean() < apart[1][:20].mean() and apart[1][-20:].mean() < apart[0][-20:].mean()
    assert walk.motions[0].meta["style"] == [{"calm one": 1.0}, {"lively one": 1.0}]
    steps = np.linalg.norm(np.diff(directions[0], axis=0), axis=-1).max()
    assert steps < 2 * max(np.linalg.norm(np.diff(one, axis=0), axis=-1).max() for one in directions[1:])


def test_a_remembered_walk_is_the_same(session, examples, random_checkpoint):
    warm, style = Session(random_checkpoint, remember=True), "calm one > lively one"
    changes = {"style": style}, {"style": style, "intensity": 0.5}, {"style": "calm one"}, {"style": style, "mirror": True}
    for wanted in changes:
        request = Request(examples / "hello.flac", **wanted)
        made, fresh = (one.synthesize(request).motions[0] for one in (warm, session))
        np.testing.assert_array_equal(made.directions, fresh.directions)


def test_a_walk_of_whole_windows_passes_the_end():
    torch = pytest.importorskip("torch")
    from s2ag.core.model import paper_networks, windows
    from s2ag.core.model.generator import Generator
    from s2ag.core.motion import rest

    torch.manual_seed(0)
    network = Generator(paper_networks.published(words=5, speakers=2)).eval()
    hear = lambda start, stop: (np.zeros((37, 71), np.float32), np.full(34, 4), None)  # noqa: E731
    points = np.random.default_rng(0).standard_normal((2, 2, network.config.style_size)).astype(np.float32)
    poses = np.broadcast_to(rest.REST, (2, 4, 9, 3)).astype(np.float32)
    for frames in (20, 34, 70):
        made = windows.generate(network, hear, styles.interpolate_sequence(points, frames), poses, frames, 34)
        assert made.shape == (2, frames, 9, 3)
        np.testing.assert_allclose(np.linalg.norm(made, axis=-1), 1, atol=1e-5)
        still = windows.generate(network, hear, np.repeat(points[:, :1], frames, 1), poses, frames, 34)
        fixed = windows.generate(network, hear, points[:, 0], poses, frames, 34)
        np.testing.assert_allclose(still, fixed, atol=bound_of(network, 34))


def test_a_walk_goes_straight_from_point_to_point():
    points = np.array([[[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]]])
    way = styles.interpolate_sequence(points, 5)
    np.testing.assert_allclose(way[0], [[0, 0], [0.5, 0], [1, 0], [1, 1], [1, 2]])


def test_a_point_needs_the_right_size_and_one_take(session, examples):
    with pytest.raises(UsageError, match="shape"):
        session.synthesize(Request(examples / "hello.flac", latent=np.zeros(3)))
    with pytest.raises(UsageError, match="one performance"):
        Request("a.wav", latent=np.zeros(16), takes=2)


def test_the_map_leads_back(session, sampled):
    content = style_map(session.checkpoint, sampled[0])
    json.dumps(content)
    assert [one["name"] for one in content["speakers"]] == ["calm one", "lively one"]
    assert content["explained"][0] == pytest.approx(1, abs=1e-6)  # two speakers differ along one line
    axes, centre = np.array(content["axes"]), np.array(content["centre"])
    np.testing.assert_allclose(axes @ axes.T, np.eye(2), atol=1e-6)
    first = sampled[0].cells[0]
    back = centre + np.array(content["speakers"][0]["at"]) @ axes
    np.testing.assert_allclose(back, first.latent[0], atol=1e-4)  # the first take is the style itself
    assert len(content["cells"][4]["at"]) == 2 and len(content["controls"]) == 5


def test_the_map_alone_is_a_picture_and_its_numbers(tmp_path, random_checkpoint):
    pytest.importorskip("matplotlib")
    assert main(["sample", "--map", str(tmp_path / "map.png"), "--checkpoint", str(random_checkpoint)]) == 0
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")
    assert len(json.loads((tmp_path / "map.json").read_text())["speakers"]) == 2


def test_numbers_alone_need_no_blender(examples, tmp_path, random_checkpoint, monkeypatch):
    monkeypatch.setenv("S2AG_BLENDER", "/no/such/blender")
    out = tmp_path / "sheet.json"
    common = ["--takes", "2", "--no-transcript", "--checkpoint", str(random_checkpoint)]
    assert main(["sample", str(examples / "hello.flac"), *common, "-o", str(out)]) == 0
    assert len(sheets.Sheet.load(out).cells) == 2


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "recording"),
        (["a.wav"], "output"),
        (["a.wav", "-o", "x.gif"], "suffix"),
        (["a.wav", "--takes", "9", "--styles", "a,b,c,d,e,f,g,h", "-o", "x.mp4"], "72"),
        (["--map", "x.svg"], ".png"),
        (["a.wav", "-o", "x.json", "-o", "./x.json"], "twice"),
        (["a.wav", "-o", "x.json", "--styles", "a,,b"], "names each"),
        (["a.wav", "-o", "x.json", "--styles", "a,b", "--style", "c"], "stands for --style"),
    ],
)
def test_wrong_samples_are_refused(arguments, said, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert main(["sample", *arguments]) == 2
    assert said in capsys.readouterr().err
