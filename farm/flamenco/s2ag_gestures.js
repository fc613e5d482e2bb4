// SPDX-License-Identifier: GPL-3.0-or-later
//
// Flamenco job type: gesturing characters from a manifest, by `s2ag batch`. How to install it: docs/farm.md.
//
// One task checks the manifest; then, for every chunk of clips, synth -> render -> encode; the last task says what failed.
// All tasks are the same command with a range of clips, so any of them can run twice, on any worker, after any crash.

const JOB_TYPE = {
  label: "S2AG Gestures",
  description: "Voice recordings to gesturing characters: motion, BVH, FBX, GLB, USD and films.",
  settings: [
    { key: "manifest", type: "string", subtype: "file_path", required: true,
      description: "Manifest (.csv or .jsonl) on storage that all workers share" },
    { key: "folder", type: "string", subtype: "dir_path", required: true,
      description: "Folder of the results, on storage that all workers share" },
    { key: "clips", type: "string", required: true, default: "1-100",
      description: "Clips to make, as in 1-1000; `s2ag batch plan` tells how many there are" },
    { key: "chunk_size", type: "int32", default: 8, propargs: { min: 1, max: 1000 }, visible: "submission",
      description: "Clips of one task: Blender starts once for all of them" },
    { key: "outputs", type: "string", default: "bvh", visible: "submission",
      description: "Outputs where the manifest names none, as in bvh,mp4" },
    { key: "preset", type: "string", choices: ["preview", "hd", "film", "transparent", "exr"], default: "preview",
      visible: "submission", description: "Look of pictures where the manifest names none" },
    { key: "films", type: "bool", default: true, visible: "submission",
      description: "Whether any clip needs Blender; without, only motion is made" },
    { key: "s2ag", type: "string", default: "{s2ag}", visible: "hidden",
      description: "The command s2ag, as the workers know it" },
    { key: "checkpoint", type: "string", default: "", visible: "hidden", description: "Another network than the shipped one" },
  ],
};

function compileJob(job) {
  const settings = job.settings;
  const common = ["-o", settings.folder, "--outputs", settings.outputs, "--preset", settings.preset];
  if (settings.checkpoint) common.push("--checkpoint", settings.checkpoint);

  function task(name, type, stage, more) {
    const made = author.Task(name, type);
    const args = ["batch", stage, settings.manifest].concat(common, more);
    made.addCommand(author.Command("exec", { exe: settings.s2ag, args: args }));
    job.addTask(made);
    return made;
  }

  const plan = task("plan", "misc", "plan", []);
  const stages = settings.films ? ["synth", "render", "encode"] : ["synth"];
  const types = { synth: "misc", render: "blender", encode: "ffmpeg" };
  const last = [];
  frameChunker(settings.clips, settings.chunk_size).forEach(function (chunk) {
    let before = plan;
    stages.forEach(function (stage) {
      // One bad clip must not stop the rest of its chunk: the last task tells of it.
      const here = task(stage + "-" + chunk, types[stage], stage, ["--clips", chunk, "--tolerate"]);
      here.addDependency(before);
      before = here;
    });
    last.push(before);
  });
  const status = task("status", "misc", "status", ["--clips", settings.clips]);
  last.forEach(function (end) { status.addDependency(end); });
}
