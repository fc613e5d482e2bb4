"""What the bench owes the public codes: proportions when networks shrink, the order of warm-up, and whose ids are used."""

import copy
import json

import numpy as np
import pytest

torch = pytest.importorskip("torch")
pytest.importorskip("librosa")

from s2ag.core.cli.main import main  # noqa: E402
from s2ag.core.learning.bench import weights  # noqa: E402
from s2ag.core.learning.bench.run import Runner  # noqa: E402
from s2ag.core.learning.bench.setting import SETTINGS  # noqa: E402
from s2ag.core.learning.bench.training import Training  # noqa: E402
from s2ag.core.learning.systems.catalogue import ALL_SYSTEMS, BuildOptions  # noqa: E402
from s2ag.core.learning.train import state  # noqa: E402
from s2ag.core.model import checkpoint  # noqa: E402
from s2ag.core.motion.motion import Motion  # noqa: E402

FOUR = ("s2ag", "s2ag-no-mfcc", "s2ag-no-affect", "gtc")
PUBLISHED = {"s2ag": 313_068 / 7_197_497, "s2ag-no-mfcc": 313_068 / 7_208_067, "s2ag-no-affect": 0.0354, "gtc": 0.0354}
"""Parameters of discriminator over generator, word and speaker tables aside (reference sections A.7 to A.10)."""


def runner(corpus, folder, **changes):
    return Runner(folder, str(corpus), SETTINGS["tiny"].replace(**changes), say=lambda text: None)


def proportion(name, share):
    system = ALL_SYSTEMS[name].build(BuildOptions(torch.zeros(20, 300), 1, share, trained_words=False))
    judge, performer = (sum(p.numel() for p in part.parameters()) for part in (system.judge, system.performer))
    return judge / performer


@pytest.mark.parametrize("name", FOUR)
def test_a_quarter_of_the_widths_keeps_the_proportion_of_discriminator_and_generator(name):
    """Within a tenth: biases and what is given (poses, word vectors, frames) do not shrink with the square of the widths."""
    assert proportion(name, 1.0) == pytest.approx(PUBLISHED[name], rel=0.01)
    assert proportion(name, 0.25) == pytest.approx(PUBLISHED[name], rel=0.1)


def huber(made, real, beta):
    apart = (made - real).abs()
    return torch.where(apart < beta, 0.5 * apart**2 / beta, apart - beta / 2)


def reference(system, batches, pause, seed):
    """Losses of each step in the public codes' order: up to ``pause`` no step of the discriminator and no term from it."""
    judge, log = system.judge.discriminator, []
    adam = [torch.optim.Adam(part.parameters(), rate, (0.5, 0.999)) for part, rate in ((system.performer, 5e-4), (judge, 1e-4))]
    system.train()
    for step, batch in enumerate(batches):
        torch.manual_seed(hash((seed, step)) % 2**31)
        words, sound = system.table(batch.words), batch.mfcc if system.config.audio == "mfcc" else batch.wave
        ids = batch.speaker
        made = system.performer(sound, words, batch.seeds, None, ids, ids.new_empty(len(ids), 0), round(len(ids) / 4))
        losses = {}
        if step >= pause:
            real, fake = judge(batch.directions), judge(made.directions.detach())
            losses["judge"] = -(torch.log(real + 1e-8) + torch.log(1 - fake + 1e-8)).mean()
            adam[1].zero_grad()
            losses["judge"].backward()
            adam[1].step()
        losses["huber"] = 500 * huber(made.directions, batch.directions, 0.1).mean()
        losses["divergence"] = 0.1 * -0.5 * (1 + made.logvar - made.mu**2 - made.logvar.exp()).mean()
        count = len(made.other)
        apart = huber(made.directions[:count], made.other, 0.05).sum((1, 2, 3))
        spread = (made.style[:count] - made.other_style).abs().mean(1).detach() + 1e-5
        losses["diversity"] = 0.05 * (-apart / spread).clamp(min=-1000).mean()
        if step >= pause:
            losses["adversarial"] = 5 * -torch.log(judge(made.directions) + 1e-8).mean()
        adam[0].zero_grad()
        sum(value for name, value in losses.items() if name != "judge").backward()
        adam[0].step()
        log.append({name: float(value.detach()) for name, value in losses.items()})
    return log


@pytest.mark.parametrize(("name", "order", "steps", "pause"), [
    ("s2ag", "code", 10, 2), ("s2ag", "paper", 4, 0), ("s2ag-no-affect", "code", 9, 2), ("gtc", "code", 10, 1),
    ("gtc", "paper", 10, 1), ("s2ag", "code", 4, 1),
])  # fmt: skip
def test_steps_are_in_the_order_of_the_public_code(corpus, tmp_path, name, order, steps, pause):
    """Two batches are a pass. S2AG pauses its discriminator for one (or a quarter, if that is less), GTC for a tenth."""
    run = runner(corpus, tmp_path, warm_up=order, epochs=1000, steps=steps, batch=64)
    run.setting = run.setting.replace(batch=len(run.data.windows[0]) // 2)
    system = run.system(name, 1)
    plain = copy.deepcopy(system)
    training = Training(system, run.data, run.setting, 1, tmp_path / "t")
    shown = min(steps, pause + 3)
    batches = [run.data.sample(training._windows(step)) for step in range(shown)]
    first = [p.detach().clone() for p in system.judge.parameters()]
    for wanted, batch in zip(reference(plain, batches, pause, 1), batches, strict=True):
        step = training.done
        found = {key: float(value) for key, value in training.step(batch).items()}
        assert found == pytest.approx(wanted, rel=2e-3, abs=1e-4) and ("judge" in found) == (step >= pause)
        still = all(torch.equal(a, b) for a, b in zip(first, system.judge.parameters(), strict=True))
        assert still == (step < pause)


def test_strangers_ids_are_learned_and_own_ones_performed(corpus, tmp_path):
    run = runner(corpus, tmp_path, training_ids="strangers")
    batch = run.data.sample(run.data.windows[0][:1])
    strange, gtc = run.system("s2ag", 1), run.system("gtc", 1)
    assert strange._ids(batch).tolist() == [1 - int(batch.speaker)] and gtc._ids(batch).tolist() == batch.speaker.tolist()
    table = strange.generator.speaker_embedding[0]
    strange.make(batch, 0.5).directions.sum().backward()
    assert table.weight.grad[int(batch.speaker)].abs().max() == 0 < table.weight.grad[1 - int(batch.speaker)].abs().max()
    heard = []
    table.register_forward_hook(lambda module, given, made: heard.append(given[0]))
    strange.eval().perform(batch)
    assert heard[0].tolist() == batch.speaker.tolist()


@pytest.mark.slow
def test_both_protocols_of_test_ids_stand_in_the_table(corpus, tmp_path):
    run = runner(corpus, tmp_path, warm_up="paper", training_ids="strangers")
    assert run.go(["seq2seq", "s2ag"], "")
    facts = {name: json.loads((tmp_path / f"{name}-1" / "figures.json").read_text()) for name in ("seq2seq", "s2ag")}
    assert set(facts["seq2seq"]["draws"]) == {"own"} and set(facts["s2ag"]["draws"]) == {"own", "random"}
    assert facts["s2ag"]["draws"]["own"] != facts["s2ag"]["draws"]["random"]
    assert {path.parent.name for path in tmp_path.glob("*/weights.safetensors")} == {"s2ag-1"}
    text = (tmp_path / "table.md").read_text()
    rows = [[cell.strip() for cell in line.split("|")[1:3]] for line in text.splitlines() if line.startswith("|")]
    assert ["S2AG", "own"] in rows and ["S2AG", "random"] in rows and ["Seq2Seq", ""] in rows
    assert "strangers' ids" in text and "from the start" in text and "S2AG, random ids" in text


def test_random_ids_are_drawn_from_all_speakers(corpus, tmp_path):
    run = runner(corpus, tmp_path)
    system, heard = run.system("gtc", 1), []
    system.generator.speaker_embedding[0].register_forward_hook(lambda module, given, made: heard.append(given[0]))
    for ids in ("own", "random", "random"):
        run._bench.perform(system, 5, ids=ids)
    own, drawn, again = (part.numpy() for part in heard)
    np.testing.assert_array_equal(own, run.data.corpus.speaker[run._bench.windows[:, 0]])
    np.testing.assert_array_equal(drawn, again)
    assert set(drawn) == {0, 1} and (drawn != own).any()


def test_weights_of_a_bench_perform_like_any_checkpoint(corpus, tmp_path, examples, capsys):
    run = runner(corpus, tmp_path / "b")
    gtc = run.system("gtc", 1)
    kept = weights.save(gtc, run.data, tmp_path, {"kind": "gtc"})
    assert torch.equal(checkpoint.load(kept).generator.text_encoder.embedding.weight, gtc.table.weight)
    out = tmp_path / "o.npz"
    command = ["synth", str(examples / "hello.flac"), "--transcript", str(examples / "hello.json"), "-o", str(out)]
    assert main([*command, "--checkpoint", str(kept)]) == 0
    assert "vocabulary" not in capsys.readouterr().err
    motion = Motion.load(out)
    assert len(motion.directions) > 34 and np.isfinite(motion.directions).all()
    seq2seq = run.system("seq2seq", 1)
    assert weights.save(seq2seq, run.data, tmp_path, {}) is None
    state.save(tmp_path / "state.safetensors", {"system": seq2seq}, {})
    assert main([*command, "--checkpoint", str(tmp_path / "state.safetensors")]) == 2
    assert "weights.safetensors of S2AG" in capsys.readouterr().err


@pytest.mark.slow
def test_the_command_line_says_how_long_how_wide_and_with_which_judge(corpus, tmp_path, capsys):
    """A step of one system, and what was asked stands in the bench's settings; passes and batches do not limit each other."""
    tiny, common = SETTINGS["tiny"], ["bench", "--data", str(corpus), "--setting", "tiny", "--systems", "s2ag", "--draws", "1"]
    asked = ["--steps", "2", "--share", "0.1", "--batch", "4", "--select", "fgd", "--validate-every", "1", "--judge", "off"]
    assert main([*common, *asked, "--out", str(tmp_path / "b")]) == 0
    held = json.loads((tmp_path / "b" / "setting.json").read_text())
    told = [held[name] for name in ("steps", "share", "batch", "select", "validate_every", "judge")]
    assert told == [2, 0.1, 4, "fgd", 1, "off"]
    report = json.loads((tmp_path / "b" / "table.json").read_text())
    assert report["systems"]["s2ag"]["steps"] == 2 and "have no discriminators" in (tmp_path / "b" / "table.md").read_text()
    assert not any("judge" in line for line in (tmp_path / "b" / "s2ag-1" / "log.jsonl").read_text().splitlines())
    core = SETTINGS["core"]
    assert core.length(6400) == 400 and core.lasting(None, 1000).length(6400) == 1000
    assert core.lasting(40, None).length(6400) == 4000
    assert core.lasting(2, 1000).length(6400) == 200 and tiny.lasting(2, None).length(80) == 20
    assert main([*common, "--steps", "0", "--out", str(tmp_path / "c")]) == 2 and "1 or more" in capsys.readouterr().err
