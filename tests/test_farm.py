"""What studios install on their farms: the OpenJD template runs for real, the Flamenco script compiles to the right tasks."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
TEMPLATE = ROOT / "farm" / "openjd" / "s2ag_gestures.yaml"
SCRIPT = ROOT / "farm" / "flamenco" / "s2ag_gestures.js"

HARNESS = """
const vm = require("vm"), fs = require("fs");
function Task(name, type) {
  const task = {name, type, commands: [], dependencies: []};
  task.addCommand = command => { task.commands.push(command); };
  task.addDependency = other => { if (!other || !other.name) throw "no task"; task.dependencies.push(other.name); };
  return task;
}
function frameChunker(range, size) {
  const frames = [];
  range.split(",").forEach(part => {
    const ends = part.split("-").map(Number);
    for (let frame = ends[0]; frame <= (ends[1] || ends[0]); frame++) frames.push(frame);
  });
  const chunks = [];
  for (let i = 0; i < frames.length; i += size) {
    const chunk = frames.slice(i, i + size), last = chunk[chunk.length - 1];
    chunks.push(chunk.length > 1 && last - chunk[0] === chunk.length - 1 ? chunk[0] + "-" + last : chunk.join(","));
  }
  return chunks;
}
const world = {
  author: {Task, Command: (name, parameters) => ({name, parameters})}, frameChunker,
  print() {}, alert() {}, formatTimestampLocal: String, path: require("path").posix, process: {platform: "linux"},
};
vm.createContext(world);
vm.runInContext(fs.readFileSync(process.argv[1], "utf8") + ";this.JOB_TYPE = JOB_TYPE;", world);
const tasks = [];
const settings = {};
world.JOB_TYPE.settings.forEach(one => { settings[one.key] = one.default; });
Object.assign(settings, JSON.parse(process.argv[2]));
world.compileJob({settings, name: "job", created: new Date(), addTask: task => tasks.push(task)});
console.log(JSON.stringify({tasks, settings: world.JOB_TYPE.settings}));
"""


@pytest.fixture
def compiled():
    """A function from settings to the compiled job."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node, which stands in for Flamenco's own JavaScript engine, is not installed")

    def compile_job(**settings):
        command = [node, "-e", HARNESS, str(SCRIPT), json.dumps({"manifest": "/m.csv", "folder": "/out", **settings})]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return compile_job


def test_a_thousand_clips_make_chunks_in_the_right_order(compiled):
    tasks = {task["name"]: task for task in compiled(clips="1-1000", chunk_size=8)["tasks"]}
    assert len(tasks) == 1 + 3 * 125 + 1
    assert tasks["plan"]["dependencies"] == []
    assert tasks["synth-1-8"]["dependencies"] == ["plan"]
    assert tasks["render-993-1000"]["dependencies"] == ["synth-993-1000"]
    assert tasks["encode-9-16"]["dependencies"] == ["render-9-16"]
    assert sorted(tasks["status"]["dependencies"]) == sorted(name for name in tasks if name.startswith("encode"))
    assert {tasks[f"{stage}-1-8"]["type"] for stage in ("synth", "render", "encode")} == {"misc", "blender", "ffmpeg"}


def test_clips_without_films_are_only_synthesised(compiled):
    names = [task["name"] for task in compiled(clips="1-3,7", chunk_size=2, films=False)["tasks"]]
    assert names == ["plan", "synth-1-2", "synth-3,7", "status"]


def test_its_commands_are_ones_that_s2ag_understands(compiled):
    from s2ag.core.cli.parser import parser

    job = compiled(clips="1-3", chunk_size=2, checkpoint="/net.safetensors", outputs="bvh,mp4", preset="hd")
    for task in job["tasks"]:
        (command,) = task["commands"]
        assert command["name"] == "exec" and command["parameters"]["exe"] == "{s2ag}"
        options = parser().parse_args(command["parameters"]["args"])
        assert options.verb == task["name"].split("-")[0] and str(options.folder) == "/out"
        assert options.tolerate == (options.verb in ("synth", "render", "encode"))
    kinds = {"string", "int32", "float", "bool"}
    assert all(one["type"] in kinds and one.get("description") for one in job["settings"])


@pytest.fixture(scope="session")
def openjd():
    """The command ``openjd`` beside this Python or on the path."""
    beside = Path(sys.executable).with_name("openjd")
    found = str(beside) if beside.exists() else shutil.which("openjd")
    if not found:
        pytest.skip("openjd-cli is not installed")
    return found


def test_the_template_is_valid(openjd):
    done = subprocess.run([openjd, "check", str(TEMPLATE)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.slow
def test_the_template_makes_clips(openjd, examples, tmp_path):
    """The whole graph, really run: plan, two chunks of synthesis, then what the films need, then the status."""
    pytest.importorskip("torch", reason="the engine is not installed")
    films = _has_blender()
    rows = [{"audio": str(examples / "hello.flac"), "no_transcript": True, "name": f"clip{n}", "seed": n} for n in (1, 2, 3)]
    rows[2] |= {"outputs": ["bvh", "mp4"], "resolution": "64x48", "fps": 2} if films else {}
    (tmp_path / "clips.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    out = tmp_path / "out"
    out.mkdir()
    command = tmp_path / "s2ag"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m s2ag "$@"\n')
    command.chmod(0o755)
    settings = {"Manifest": tmp_path / "clips.jsonl", "Out": out, "Clips": "1-3", "ChunkSize": 2, "S2ag": command}
    parameters = [part for name, value in settings.items() for part in ("-p", f"{name}={value}")]
    run = [openjd, "run", str(TEMPLATE), "--step", "Status", "--run-dependencies", *parameters]
    done = subprocess.run(run, capture_output=True, text=True, env={**os.environ, "S2AG_DEBUG": "1"})
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr
    assert {path.name for path in (out / "bvh").iterdir()} == {"clip1.bvh", "clip2.bvh", "clip3.bvh"}
    assert json.loads((out / "summary.json").read_text())["complete"]
    assert (out / "mp4" / "clip3.mp4").is_file() == films


def _has_blender() -> bool:
    from s2ag.core.cli import blender
    from s2ag.core.errors import BlenderUnavailable
    from s2ag.s2ag_blender.render import opengl

    try:
        blender.command("render.serve")
    except BlenderUnavailable:
        return False
    return opengl.is_available()
