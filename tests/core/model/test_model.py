"""The network: the published layers to the last parameter, the paper's graphs, and what `default` promises."""

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from s2ag.core.errors import UsageError  # noqa: E402
from s2ag.core.model import graph, paper_networks, recurrent  # noqa: E402
from s2ag.core.model.config import ModelConfig  # noqa: E402
from s2ag.core.model.discriminator import Discriminator  # noqa: E402
from s2ag.core.model.dropout import Dropout  # noqa: E402
from s2ag.core.model.generator import Generator  # noqa: E402
from s2ag.core.model.layers import ChannelNorm  # noqa: E402
from s2ag.core.model.mfcc_timing import mfcc_slice, nearest_mfcc  # noqa: E402
from s2ag.core.motion.skeleton import MEAN  # noqa: E402
from s2ag.core.sound.prosody import FEATURES  # noqa: E402


def parameters(module):
    return sum(p.numel() for p in module.parameters())


def default_inputs(batch=2, frames=40, seeds=10):
    given = torch.zeros(batch, frames, 28)
    given[:, :seeds, :27] = 0.1 * torch.randn(batch, seeds, 27)
    given[:, :seeds, 27] = 1
    mfcc = torch.randn(batch, mfcc_slice(0, frames).stop, 40)
    return mfcc, 0.06 * torch.randn(batch, frames, 300), given, torch.randn(batch, 16), torch.randn(batch, frames, FEATURES)


@pytest.fixture(scope="module")
def published():
    torch.manual_seed(0)
    config = paper_networks.published(words=50, speakers=7)
    return Generator(config).eval(), Discriminator(config).eval()


def test_published_has_exactly_the_public_codes_parameters(published):
    generator, discriminator = published
    assert parameters(generator.audio_encoder) == 59_158
    assert parameters(generator.text_encoder) == 1_454_432 + 300 * 50
    assert parameters(generator.aff_encoder) == 61_064
    assert parameters(generator.gru) == 5_572_800
    assert parameters(generator.out) == 49_227
    assert parameters(generator) == 7_197_497 + 300 * 50 + 16 * 7
    assert parameters(discriminator) == 313_068


def test_published_state_names_are_those_of_foreign_checkpoints(published):
    names = set(published[0].state_dict())
    assert {
        "audio_encoder.conv1.weight",
        "audio_encoder.batch_norm4.running_mean",
        "audio_encoder.linear1.bias",
        "text_encoder.embedding.weight",
        "text_encoder.tcn.network.3.conv2.weight_g",
        "text_encoder.tcn.network.0.conv1.weight_v",
        "text_encoder.decoder.weight",
        "aff_encoder.st_gcn1.gcn.conv.weight",
        "aff_encoder.st_gcn2.tcn.3.running_var",
        "aff_encoder.st_gcn2.residual.1.weight",
        "aff_encoder.batch_norm2.weight",
        "aff_encoder.conv4.bias",
        "speaker_embedding.0.weight",
        "speaker_embedding.1.bias",
        "speaker_mu.weight",
        "speaker_log_var.bias",
        "gru.weight_hh_l3_reverse",
        "out.2.weight",
    } <= names
    assert not [name for name in names if "matrices" in name or name == "mean"]


def test_published_takes_its_own_inputs(published):
    generator, discriminator = published
    words = torch.randint(0, 50, (3, 34))
    made = generator(torch.randn(3, 37, 71), words, torch.zeros(3, 34, 28), torch.randn(3, 16))
    assert made.shape == (3, 34, 9, 3)
    judged = discriminator(made)
    assert judged.shape == (3, 1) and ((judged > 0) & (judged < 1)).all()


def test_published_never_sees_the_seed_bit(published):
    seeds = torch.zeros(1, 34, 28)
    marked = seeds.clone()
    marked[:, :4, 27] = 1
    inputs = torch.randn(1, 37, 71), torch.zeros(1, 34, dtype=torch.long)
    style = torch.zeros(1, 16)
    assert torch.equal(published[0](*inputs, seeds, style), published[0](*inputs, marked, style))


def test_published_text_sees_no_coming_word(published):
    words = torch.zeros(1, 34, dtype=torch.long)
    later = words.clone()
    later[:, 20] = 5
    encoder = published[0].text_encoder
    before, after = encoder(words), encoder(later)
    assert torch.equal(before[:, :20], after[:, :20]) and not torch.equal(before[:, 20:], after[:, 20:])


def test_paper_has_the_sizes_of_table_1():
    generator, discriminator = (kind(paper_networks.paper()).eval() for kind in (Generator, Discriminator))
    encoder = generator.aff_encoder
    assert generator.audio_encoder.linear1.out_features == 32
    assert generator.text_encoder.decoder.out_features == 32
    assert generator.speaker_mu.out_features == 16
    assert encoder.st_gcn1.gcn.conv.kernel_size == (5, 1) and encoder.st_gcn1.tcn[2].kernel_size == (5, 1)
    assert encoder.st_gcn1.tcn[2].out_channels == encoder.st_gcn2.tcn[2].out_channels == encoder.conv4.out_channels == 16
    assert (generator.gru.hidden_size, discriminator.gru.hidden_size) == (150, 150)
    made = generator(torch.randn(1, 71, 37), torch.zeros(1, 34, 300), torch.zeros(1, 34, 28), torch.zeros(1, 16))
    assert made.shape == (1, 34, 9, 3)


@pytest.mark.parametrize(
    ("nodes", "links", "sums"),
    [(9, graph.edge_links("chain"), [7, 5, 3, 6, 4, 3, 6, 4, 3]), (3, graph.PART_LINKS, [3, 3, 3])],
)
def test_published_adjacencies(nodes, links, sums):
    stack = graph.adjacency(nodes, links, 2, "spatial")
    assert stack.shape == (5, nodes, nodes)
    assert (stack > 0).sum((0, 1)).tolist() == sums
    np.testing.assert_allclose(stack.sum((0, 1)), 1, rtol=1e-6)
    np.testing.assert_array_equal(stack[0] > 0, np.eye(nodes, dtype=bool))


def test_published_adjacency_separates_inner_from_outer_neighbours():
    stack = graph.adjacency(9, graph.edge_links("chain"), 2, "spatial") > 0

    def neighbours(group, edge):
        return set(np.flatnonzero(stack[group, :, edge]))

    assert (neighbours(1, 0), neighbours(2, 0), neighbours(3, 0)) == ({1, 3, 6}, set(), {2, 4, 7})
    assert (neighbours(1, 3), neighbours(2, 3)) == ({4}, {0})
    assert (neighbours(3, 3), neighbours(4, 3)) == ({1, 5, 6}, set())
    assert (neighbours(2, 5), neighbours(4, 5)) == ({4}, {3})


def test_paper_adjacencies_are_literal():
    one, two = (graph.adjacency(9, graph.edge_links("line"), hops, "unweighted")[0] for hops in (1, 2))
    first = [{1, 3, 6}, {0, 2, 3, 6}, {1}, {0, 1, 4, 6}, {3, 5}, {4}, {0, 1, 3, 7}, {6, 8}, {7}]
    second = [{2, 4, 7}, {4, 7}, {0, 3, 6}, {2, 5, 7}, {0, 1, 6}, {3}, {2, 4, 8}, {0, 1, 3}, {6}]
    for edge in range(9):
        assert set(np.flatnonzero(one[edge])) == first[edge] | {edge}
        assert set(np.flatnonzero(two[edge] - one[edge])) == second[edge]
    parts = graph.adjacency(3, graph.PART_LINKS, 1, "unweighted")
    assert parts.tolist() == [[[1, 1, 1], [1, 1, 0], [1, 0, 1]]]


def test_graph_convolution_sums_over_neighbours():
    from s2ag.core.model.affective_encoder import GraphConvolution

    matrices = torch.from_numpy(graph.adjacency(3, graph.PART_LINKS, 1, "unweighted"))
    layer = GraphConvolution(1, 1, 1, matrices)
    with torch.no_grad():
        layer.conv.weight.fill_(1.0)
        layer.conv.bias.zero_()
    assert layer(torch.tensor([1.0, 10.0, 100.0]).view(1, 1, 3, 1)).flatten().tolist() == [111, 11, 101]


def gradients(module, x, weights, forward):
    module.zero_grad()
    x = x.clone().requires_grad_()
    made = forward(x)
    (made * weights).sum().backward()
    return [made.detach(), x.grad, *(p.grad.clone() for p in module.parameters())]


@pytest.mark.parametrize("layers", [1, 2])
def test_the_written_out_gru_has_the_values_and_gradients_of_torchs(layers):
    torch.manual_seed(0)
    gru = torch.nn.GRU(19, 7, layers, batch_first=True, bidirectional=True).double()
    x, weights = torch.randn(3, 11, 19).double(), torch.randn(3, 11, 14).double()
    ours = gradients(gru, x, weights, lambda x: torch.cat(recurrent.bidirectional(gru, x), -1))
    theirs = gradients(gru, x, weights, lambda x: gru(x)[0])
    for a, b in zip(ours, theirs, strict=True):
        torch.testing.assert_close(a, b)


def test_the_written_out_gru_keeps_its_state_exact_at_low_precision():
    torch.manual_seed(0)
    gru = torch.nn.GRU(19, 7, 2, batch_first=True, bidirectional=True)
    x, weights = torch.randn(3, 11, 19), torch.randn(3, 11, 14)

    def low(x):
        with torch.autocast("cpu", torch.bfloat16):
            return torch.cat(recurrent.bidirectional(gru, x), -1)

    made, *rest = gradients(gru, x, weights, low)
    assert made.dtype == torch.float32
    for a, b in zip([made, *rest], gradients(gru, x, weights, lambda x: gru(x)[0]), strict=True):
        assert a.dtype == b.dtype and (a - b).norm() < 0.02 * b.norm()


def test_channel_norm_is_layer_norm_over_axis_1():
    torch.manual_seed(0)
    norm = ChannelNorm(6).double()
    torch.nn.init.normal_(norm.weight), torch.nn.init.normal_(norm.bias)
    x, weights = torch.randn(2, 6, 5, 3).double() + 2, torch.randn(2, 6, 5, 3).double()
    layer_norm = torch.nn.functional.layer_norm
    theirs = gradients(norm, x, weights, lambda x: layer_norm(x.movedim(1, -1), (6,), norm.weight, norm.bias).movedim(-1, 1))
    for a, b in zip(gradients(norm, x, weights, norm), theirs, strict=True):
        torch.testing.assert_close(a, b)


def test_dropout_keeps_the_mean_and_drops_the_share():
    torch.manual_seed(0)
    layer, x = Dropout(0.25), torch.ones(999, 103)
    made = layer(x)
    assert float((made == 0).float().mean()) == pytest.approx(0.25, abs=0.01)
    assert float(made.mean()) == pytest.approx(1, abs=0.01) and float(made.max()) == pytest.approx(4 / 3)
    assert (made == 0).float().mean(0).std() < 0.03
    assert layer.eval()(x) is x


@pytest.mark.parametrize("frames", [1, 34, 97])
def test_default_takes_any_length_and_gives_unit_directions(frames):
    made = Generator(ModelConfig.default()).eval()(*default_inputs(frames=frames, seeds=min(frames, 10)))
    assert made.shape == (2, frames, 9, 3)
    torch.testing.assert_close(made.norm(dim=-1), torch.ones(2, frames, 9))


def test_default_takes_any_mfcc_rate():
    mfcc, words, seeds, style, prosody = default_inputs()
    generator = Generator(ModelConfig.default()).eval()
    for count in (20, 40, 160):
        assert generator(torch.randn(2, count, 40), words, seeds, style, prosody).shape == (2, 40, 9, 3)


def test_default_does_not_depend_on_its_batch():
    generator = Generator(ModelConfig.default()).eval()
    inputs = default_inputs(batch=3)
    together = generator(*inputs)
    alone = torch.cat([generator(*(x[i : i + 1] for x in inputs)) for i in range(3)])
    torch.testing.assert_close(together, alone, rtol=1e-4, atol=1e-5)


def test_default_uses_every_input():
    torch.manual_seed(1)
    generator = Generator(ModelConfig.default()).eval()
    inputs = default_inputs()
    made = generator(*inputs)
    for i, x in enumerate(inputs):
        changed = [*inputs]
        changed[i] = x + 0.5 if i != 2 else torch.zeros_like(x)
        assert not torch.allclose(made, generator(*changed), atol=1e-4)


def test_default_ignores_poses_outside_the_seed_mask():
    generator = Generator(ModelConfig.default()).eval()
    mfcc, words, seeds, style, prosody = default_inputs()
    dirty = seeds.clone()
    dirty[:, 10:, :27] = 1.0
    assert torch.equal(generator(mfcc, words, seeds, style, prosody), generator(mfcc, words, dirty, style, prosody))


def test_controls_move_the_style_and_rest_at_zero():
    generator = Generator(ModelConfig.default(speakers=2))
    style = torch.randn(3, 16)
    assert torch.equal(generator.steer(style, torch.zeros(3, 5)), style)
    once, twice = (generator.steer(style, scale * torch.eye(5)[:3]) - style for scale in (1, 2))
    torch.testing.assert_close(twice, 2 * once)
    assert once.abs().sum(1).min() > 0


def test_networks_without_prosody_and_controls_have_no_weights_for_them():
    for config in (ModelConfig(), paper_networks.paper(), paper_networks.published(9, 2)):
        names = set(Generator(config).state_dict())
        assert not [name for name in names if name.startswith(("prosody", "controls"))]


def test_untrained_default_stands_near_the_mean_pose():
    made = Generator(ModelConfig.default()).eval()(*default_inputs())
    assert (made - torch.from_numpy(MEAN)).abs().mean().item() < 0.3


def test_speakers_are_distributions_and_styles_are_repeatable():
    generator = Generator(ModelConfig.default(speakers=5))
    mu, logvar = generator.speaker(torch.tensor([4, 0]))
    assert mu.shape == logvar.shape == (2, 16)
    a, b = (generator.sample_style(mu, logvar, torch.Generator().manual_seed(3)) for _ in range(2))
    assert torch.equal(a, b)
    assert not torch.equal(a, generator.sample_style(mu, logvar, torch.Generator().manual_seed(4)))


@pytest.mark.parametrize("config", [ModelConfig.default(8), paper_networks.paper(3), paper_networks.published(9, 2)])
def test_configuration_round_trips_through_json(config):
    import json

    assert ModelConfig.from_dict(json.loads(json.dumps(config.to_dict()))) == config


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"gru_sise": 3}, "gru_sise"),
        ({"gru_size": "wide"}, "gru_size"),
        ({"norm": "group"}, "norm"),
        ({"mfcc_axis": "coefficient"}, "fixed lengths"),
        ({"mfcc_kernels": [5]}, "kernel"),
        ({"discriminator_pool": "linear"}, "fixed number"),
    ],
)
def test_bad_configuration_is_named(settings, says):
    with pytest.raises(UsageError, match=says):
        ModelConfig.from_dict(settings)


def test_mfcc_frames_follow_pose_frames():
    starts = np.arange(0, 4000, 7)
    off = nearest_mfcc(starts) * 512 / 16000 - starts / 15
    assert np.abs(off).max() <= 0.0161
    assert nearest_mfcc(6) == 13  # 12.5 frames: halves go up
    lengths = {mfcc_slice(start, start + 34).stop - mfcc_slice(start, start + 34).start for start in range(100)}
    assert lengths == {71}


@pytest.mark.parametrize("value", [[1, None], [True], ["1"], [1.5], 3, None])
def test_settings_of_several_numbers_are_numbers(value):
    from s2ag.core.errors import UsageError

    with pytest.raises(UsageError, match="flow_dilations"):
        ModelConfig.from_dict({"decoder": "flow", "flow_dilations": value})
