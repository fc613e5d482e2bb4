"use strict";
// The study's page: clips one after the other, or two side by side, questions on each, answers kept in this browser.
(() => {
  const study = window.STUDY;
  const find = (id) => document.getElementById(id);
  const slot = (number) => `s2ag-study/${study.id}/${number}`;
  const current = () => slot("current");
  let record = null;
  let began = 0;
  let seen = new Set();
  const paired = Boolean(study) && study.form !== "rating";
  const videos = paired ? ["clip", "right"] : ["clip"];
  const degrees = ["left, clearly", "left, slightly", "equal", "right, slightly", "right, clearly"];

  function show(name) {
    for (const section of ["welcome", "trial", "done"]) find(section).hidden = section !== name;
  }

  function fail(text) {
    find("broken").textContent = text;
    find("broken").hidden = false;
  }

  function store() {
    try {
      localStorage.setItem(slot(record.participant), JSON.stringify(record));
      localStorage.setItem(current(), String(record.participant));
    } catch (error) {
      fail("This browser keeps no data, so answers would be lost. Please allow it, or use another browser.");
    }
  }

  function recall(number) {
    try {
      const kept = JSON.parse(localStorage.getItem(slot(number)));
      return kept && Array.isArray(kept.answers) ? kept : null;
    } catch (error) {
      return null;
    }
  }

  function order() {
    return study.orders[(record.participant - 1) % study.orders.length];
  }

  function begin(number) {
    record = recall(number) || { study: study.id, participant: number, started: new Date().toISOString(), answers: [] };
    store();
    next();
  }

  function next() {
    const place = record.answers.length;
    const clips = order();
    if (place >= clips.length) {
      show("done");
      return;
    }
    show("trial");
    find("progress").textContent = `${paired ? "Pair" : "Clip"} ${place + 1} of ${clips.length}`;
    [].concat(clips[place]).forEach((name, side) => {
      find(videos[side]).src = `clips/${name}`;
    });
    seen = new Set();
    began = Date.now();
    ask(false);
  }

  function ask(open) {
    const form = find("answers");
    find("hint").hidden = open;
    if (open) {
      for (const field of form.querySelectorAll("fieldset")) field.disabled = false;
      return;
    }
    form.replaceChildren(...study.questions.map(question), submit());
  }

  function question(asked) {
    const field = document.createElement("fieldset");
    field.disabled = true;
    const legend = document.createElement("legend");
    legend.textContent = asked.text;
    const scale = document.createElement("div");
    scale.className = "scale";
    const first = paired ? -2 : 1;
    for (let value = first; value <= first + 4; value += 1) {
      const label = document.createElement("label");
      const input = document.createElement("input");
      Object.assign(input, { type: "radio", name: asked.id, value: String(value), required: true });
      const text = document.createElement("span");
      if (paired) text.textContent = degrees[value + 2];
      else text.textContent = value === 1 ? `1: ${asked.low}` : value === 5 ? `5: ${asked.high}` : String(value);
      label.append(input, text);
      scale.append(label);
    }
    field.append(legend, scale);
    return field;
  }

  function submit() {
    const field = document.createElement("fieldset");
    field.disabled = true;
    field.style.border = "none";
    const button = document.createElement("button");
    button.type = "submit";
    button.textContent = "Next";
    field.append(button);
    return field;
  }

  function answer(event) {
    event.preventDefault();
    const given = new FormData(find("answers"));
    const shown = order()[record.answers.length];
    const entry = { ...(paired ? { left: shown[0], right: shown[1] } : { clip: shown }), seconds: (Date.now() - began) / 1000 };
    for (const asked of study.questions) {
      if (!given.has(asked.id)) return;
      const value = Number(given.get(asked.id));
      entry[asked.id] = value;
    }
    record.answers.push(entry);
    store();
    next();
  }

  function table() {
    const names = ["participant", ...(paired ? ["left", "right"] : ["clip"]), ...study.questions.map((asked) => asked.id), "seconds"];
    const rows = record.answers.map((entry) => names.map((name) => (name === "participant" ? record.participant : entry[name])));
    return [names, ...rows].map((row) => row.join(",")).join("\n") + "\n";
  }

  function save(text, kind, suffix) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type: kind }));
    link.download = `answers-${record.participant}.${suffix}`;
    link.click();
    find("saved").textContent = `${link.download} is saved.`;
    try {
      localStorage.removeItem(current());
    } catch (error) {
      return;
    }
  }

  if (!study || !Array.isArray(study.orders)) {
    fail("The study's data is missing: study-data.js must lie beside this page.");
    return;
  }
  document.title = study.title;
  find("title").textContent = study.title;
  find("intro").textContent = study.intro;
  find("hint").textContent = paired
    ? "Please watch both clips to their ends; then the questions open."
    : "Please watch the clip to its end; then the questions open.";
  find("right").hidden = !paired;
  document.querySelector("main").classList.toggle("wide", paired);
  for (const name of videos) {
    find(name).addEventListener("ended", () => {
      seen.add(name);
      if (seen.size === videos.length) ask(true);
    });
    find(name).addEventListener("play", () => {
      for (const other of videos) if (other !== name) find(other).pause();
    });
    find(name).addEventListener("error", () => fail("This clip cannot be played here. Please use another browser."));
  }
  find("answers").addEventListener("submit", answer);
  find("begin").addEventListener("submit", (event) => {
    event.preventDefault();
    begin(Number(find("number").value));
  });
  find("save-json").addEventListener("click", () => save(JSON.stringify(record, null, 1), "application/json", "json"));
  find("save-csv").addEventListener("click", () => save(table(), "text/csv", "csv"));
  let unfinished = null;
  try {
    unfinished = Number(localStorage.getItem(current())) || null;
  } catch (error) {
    unfinished = null;
  }
  if (unfinished) begin(unfinished);
  else show("welcome");
})();
