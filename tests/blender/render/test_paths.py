"""Outputs whose names look like templates, numbers of frames or addresses."""

import pytest
from s2ag.s2ag_blender.program import EventWriter
from s2ag.s2ag_blender.render import job as jobs


@pytest.mark.parametrize("name", ["take {x}", "12:30 {blend_name}", "100% {{"])
def test_a_path_is_a_path(tmp_path, wave, name):
    folder = tmp_path / name
    folder.mkdir()
    wave(2).save(tmp_path / "motion.npz")
    outputs = [str(folder / (name + suffix)) for suffix in (".png", ".mp4", " a.##.png", ".blend", " #1.mp4")]
    content = {"motions": [str(tmp_path / "motion.npz")], "character": "mannequin", "engine": "cycles", "samples": 1}
    jobs.perform(jobs.Job.of({**content, "resolution": [16, 16], "outputs": outputs}), EventWriter(lambda line: None))
    made = {path.name for path in folder.iterdir()}
    assert {f"{name}.png", f"{name}.mp4", f"{name}.blend", f"{name} #1.mp4"} <= made and len(made) == 7, made
    av = pytest.importorskip("av", reason="beside this Blender nothing reads films")
    with av.open(f"file:{outputs[1]}") as film:
        assert len(list(film.decode(video=0))) == 3
