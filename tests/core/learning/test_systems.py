"""The eight systems: published sizes, corrected forms and their switches, and that each one learns."""

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from s2ag.core.errors import UsageError  # noqa: E402
from s2ag.core.learning.systems import gesticulator, spectrogram, word_timing  # noqa: E402
from s2ag.core.learning.systems.catalogue import ALL_SYSTEMS, SYSTEMS, BuildOptions  # noqa: E402
from s2ag.core.learning.systems.sample import END, START, Sample, WordTable, word_vectors  # noqa: E402
from s2ag.core.learning.systems.speech2gesture import Speech2Gesture  # noqa: E402
from s2ag.core.model import paper_networks  # noqa: E402
from s2ag.core.model.config import ModelConfig  # noqa: E402
from s2ag.core.model.discriminator import Discriminator  # noqa: E402
from s2ag.core.model.generator import Generator  # noqa: E402
from s2ag.core.model.table_features import published_features  # noqa: E402
from s2ag.core.model.wave_encoder import SAMPLES, WaveEncoder  # noqa: E402
from s2ag.core.sound.mfcc import mfcc  # noqa: E402

VECTORS = 0.06 * torch.randn(20, 300, generator=torch.Generator().manual_seed(0))


def count(module):
    return sum(p.numel() for p in module.parameters())


def sample(batch=6, seed=0):
    random = torch.Generator().manual_seed(seed)
    words = torch.zeros(batch, 34, dtype=torch.long)
    words[:, 3], words[:, 12], words[1:, 20] = 5, 6, 7
    loud = torch.rand(batch, 1, generator=random)
    directions = torch.nn.functional.normalize(
        torch.tensor([0.3, 0.8, 0.5]) + 0.3 * torch.randn(batch, 1, 9, 3, generator=random), dim=-1
    ).expand(-1, 34, -1, -1)
    return Sample(
        loud * torch.randn(batch, SAMPLES, generator=random) * 0.1,
        loud[..., None] * torch.randn(batch, 71, 14, generator=random) * 0.1,
        words,
        torch.rand(batch, 34, 5, generator=random),
        torch.arange(batch) % 3,
        directions.contiguous(),
    )


def built(name, **changes):
    torch.manual_seed(0)
    return ALL_SYSTEMS[name].build(BuildOptions(VECTORS, 3, **{"share": 0.1, "trained_words": False, **changes}))


def test_published_sizes():
    assert count(WaveEncoder()) == 69_728
    trimodal = paper_networks.trimodal(words=50, speakers=7)
    assert count(Generator(trimodal)) == 7_183_003 + 300 * 50 + 16 * 7
    assert round(count(Discriminator(trimodal)) / 1e6, 2) == 0.25
    assert count(Generator(paper_networks.without_affect(words=50, speakers=7)).gru) == 5_572_800 + 20 * 3 * 300 * 2
    assert round(count(Speech2Gesture(port=True).performer) / 1e6, 2) == 6.44
    assert round(count(Speech2Gesture().judge) / 1e6, 2) == 0.17
    words = count(WordTable(word_vectors(VECTORS, True), True))
    assert round((count(built("seq2seq", share=1.0, trained_words=True).performer) - words) / 1e6, 2) == 1.94


def test_ablations_differ_from_s2ag_in_one_encoder():
    whole, no_mfcc, no_affect = (
        set(Generator(preset(words=5)).state_dict())
        for preset in (paper_networks.published, paper_networks.without_mfcc, paper_networks.without_affect)
    )
    assert {name.split(".")[0] for name in whole ^ no_mfcc} == {"audio_encoder"}
    assert {name.split(".")[0] for name in whole ^ no_affect} == {"aff_encoder"}


def test_probes_change_the_judge_alone():
    """The ablation of the affective encoder takes it out of both networks; the probes take it out of one."""
    parts = {name: set(built(name).judge.state_dict()) for name in ("s2ag", "s2ag-no-affect", "s2ag-gtc-judge")}
    assert parts["s2ag-gtc-judge"] == parts["s2ag-no-affect"] != parts["s2ag"]
    assert set(built("no-affect-s2ag-judge").judge.state_dict()) == parts["s2ag"]
    performer = built("s2ag").performer.state_dict()
    for probe in ("s2ag-gtc-judge", "s2ag-no-judge"):
        for name, value in built(probe).performer.state_dict().items():
            assert torch.equal(value, performer[name])
    silent = built("s2ag-no-judge")
    assert silent.judge is None and "adversarial" not in silent.terms(sample(), silent.make(sample(), 0.5), 0.5)


def test_wrong_combinations_are_refused():
    with pytest.raises(UsageError, match="34 frames"):
        ModelConfig.default(audio="wave")
    with pytest.raises(UsageError, match="second view"):
        ModelConfig.default(affect="raw")


@pytest.mark.slow
@pytest.mark.parametrize("name", ALL_SYSTEMS)
def test_every_system_learns_what_it_is_shown(name):
    torch.set_num_threads(1)
    system, batch = built(name), sample()
    parts = [("performer", 3e-3)] + ([("judge", 1e-4)] if system.judge is not None else [])
    optimizers = {part: torch.optim.Adam(getattr(system, part).parameters(), rate) for part, rate in parts}
    system.train()
    errors, used = [], set()
    for _ in range(25):
        made = system.make(batch, 0.5)
        assert made.directions.shape == (6, 34, 9, 3)
        errors.append(float((made.directions - batch.directions).detach().abs().mean()))
        if system.judge is not None:
            optimizers["judge"].zero_grad()
            system.judge_loss(batch, made.directions.detach()).backward()
            optimizers["judge"].step()
        optimizers["performer"].zero_grad()
        terms = system.terms(batch, made, 0.5)
        sum(terms.values()).backward()
        optimizers["performer"].step()
        used |= {number for number, p in enumerate(system.performer.parameters()) if p.grad is not None}
        assert all(torch.isfinite(term) for term in terms.values())
    assert np.mean(errors[-5:]) < 0.8 * np.mean(errors[:3])
    assert len(used) > 0.7 * len(list(system.performer.parameters()))


@pytest.mark.parametrize("name", SYSTEMS)
def test_what_comes_after_the_seeds_is_not_looked_at(name):
    """A performance in use depends on what is heard and on four poses, never on the poses to be predicted."""
    system, batch = built(name).eval(), sample()
    future = batch.directions.clone()
    future[:, 4:] = future[:, 4:].flip(-1)
    other = Sample(batch.wave, batch.cepstra, batch.words, batch.timing, batch.speaker, future)
    with torch.inference_mode():
        torch.manual_seed(3)
        one = system.perform(batch)
        torch.manual_seed(3)
        two = system.perform(other)
    torch.testing.assert_close(one, two)
    past = batch.directions.flip(-1)
    with torch.inference_mode():
        torch.manual_seed(3)
        three = system.perform(Sample(batch.wave, batch.cepstra, batch.words, batch.timing, batch.speaker, past))
    assert (one[:, 4:] - three[:, 4:]).abs().max() > 1e-6 or name == "gesticulator"


def hears(name, **changes):
    system, batch = built(name).eval(), sample()
    parts = {part: getattr(batch, part) for part in ("wave", "cepstra", "words", "timing", "speaker", "directions")}
    with torch.inference_mode():
        results = []
        for given in (parts, {**parts, **{key: change(parts[key]) for key, change in changes.items()}}):
            torch.manual_seed(1)
            results.append(system.perform(Sample(**given)))
    return bool((results[0] - results[1]).abs().max() > 1e-7)


def test_each_hears_what_it_should():
    sound, cepstra = {"wave": lambda x: 0 * x}, {"cepstra": lambda x: x + 0.1}
    words, speaker = {"words": lambda x: torch.where(x > 0, 9, 0)}, {"speaker": lambda x: (x + 1) % 3}
    expected = {
        "seq2seq": "words", "s2g": "sound", "jem": "sound words", "gtc": "sound words speaker", "gesticulator": "sound words",
        "s2ag-no-mfcc": "sound words speaker", "s2ag-no-affect": "cepstra words speaker", "s2ag": "cepstra words speaker",
    }  # fmt: skip
    for name in SYSTEMS:
        found = {"sound": hears(name, **sound), "cepstra": hears(name, **cepstra), "words": hears(name, **words)}
        found["speaker"] = hears(name, **speaker)
        assert {key for key, value in found.items() if value} == set(expected[name].split()), name


def test_the_ports_bugs_are_switches():
    assert built("gtc").config.head_slope == 0.01 and built("gtc", faithful=True).config.head_slope == 1.0
    assert not built("s2g").port and built("s2g", faithful=True).port
    strangers = built("s2ag", strangers=True)
    batch = sample(2)
    assert set(strangers._ids(batch).tolist()) == {2}
    assert torch.equal(built("s2ag")._ids(batch), batch.speaker)
    assert built("s2g", faithful=True).perform(sample(2)).shape == (2, 34, 9, 3)


def test_time_is_time_in_the_corrected_speech2gesture():
    """Another sound in the last third of the window changes late columns of what is heard, and early ones not at all."""
    system = built("s2g", share=0.25).eval()
    heard = torch.randn(2, 1, 70, 64)
    changed = heard.clone()
    changed[:, :, 47:] *= -1
    with torch.inference_mode():
        rows = (system.performer.audio(heard) - system.performer.audio(changed)).abs().amax((0, 1, 3))
    assert system.performer.audio(heard).shape[-1] == 1  # no mel band is left
    assert rows[0] == 0 and rows[-2:].min() > 0


def test_word_sequences():
    words = torch.zeros(2, 34, dtype=torch.long)
    words[0, 4], words[0, 30], words[1, 0] = 7, 5, 9
    batch = Sample(*[torch.zeros(2)] * 2, words, *[torch.zeros(2)] * 3)
    rows, lengths = batch.sequences()
    assert rows.tolist() == [[START, 7, 5, END], [START, 9, END, 0]] and lengths.tolist() == [4, 3]


def test_mfcc_of_a_sample_are_the_published_features():
    audio = np.random.default_rng(0).normal(size=SAMPLES).astype(np.float32)
    cepstra = torch.from_numpy(mfcc(audio) / 1000)[None]
    batch = Sample(torch.zeros(1), cepstra, *[torch.zeros(1)] * 4)
    torch.testing.assert_close(batch.mfcc[0].numpy(), published_features(audio), rtol=1e-5, atol=1e-6)


@pytest.mark.slow
def test_log_mel_is_librosas():
    librosa = pytest.importorskip("librosa")
    audio = np.random.default_rng(0).normal(size=20000).astype(np.float32)
    centres = torch.arange(30) * 512 + 512
    found = spectrogram.log_mel(torch.from_numpy(audio)[None], centres, 1024, 64)[0].numpy()
    wanted = librosa.feature.melspectrogram(y=audio, sr=16000, n_fft=1024, hop_length=512, n_mels=64, center=False)
    np.testing.assert_allclose(found, np.log(wanted.T[:30] + 1e-10), atol=1e-3)
    level = spectrogram.decibels(torch.from_numpy(found)[None])
    assert level.max() == 0 and level.min() >= -80


def test_timing_of_a_word():
    found = word_timing.word_timing_features([("beautiful", 0.2, 0.8)], 15)
    assert not found[:3].any() and not found[12:].any()
    np.testing.assert_allclose(found[6], [0.2, 0.4, 0.6, 1 / 3, 3 / 6], atol=1e-6)
    assert [word_timing.syllables(word) for word in ("a", "make", "table", "the", "hmm")] == [1, 1, 2, 1, 1]


def test_gesticulators_schedule():
    assert gesticulator.schedule(0.0) == (False, 0)
    assert [gesticulator.schedule((7.5 + k) / 100)[1] for k in range(5)] == [16, 8, 4, 2, 2]
    assert gesticulator.schedule(1.0) == (True, 2)


@pytest.mark.parametrize("name", ["gesticulator", "s2ag", "seq2seq"])
def test_word_vectors_of_another_width(name):
    """A data set may hold vectors of 768 numbers, as BERT's are."""
    system = SYSTEMS[name].build(BuildOptions(torch.randn(20, 768), 3, 0.1, trained_words=False)).eval()
    assert system.perform(sample(2)).shape == (2, 34, 9, 3)
