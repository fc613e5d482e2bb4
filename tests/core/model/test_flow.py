"""Flow matching: what is drawn from noise, what is given and kept, what is asked for, and how it is learned."""

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from rounding import bound_of  # noqa: E402
from s2ag.core.errors import UsageError  # noqa: E402
from s2ag.core.model.config import ModelConfig  # noqa: E402
from s2ag.core.model.denoiser import Depthwise  # noqa: E402
from s2ag.core.model.flow import FlowGenerator  # noqa: E402
from s2ag.core.model.flow_solver import solve, time_grid  # noqa: E402
from s2ag.core.model.mfcc_timing import mfcc_slice  # noqa: E402
from s2ag.core.model.seeds import given_input  # noqa: E402
from s2ag.core.motion import skeleton, stroke_requests  # noqa: E402
from s2ag.core.sound.prosody import FEATURES  # noqa: E402

SMALL = dict(flow_size=48, flow_condition=32, meanings=4)


def made_network(**changes):
    torch.manual_seed(0)
    network = FlowGenerator(ModelConfig.flow(speakers=2, **{**SMALL, **changes})).eval()
    for name, parameter in network.named_parameters():  # some begin at zero, so that a training begins at rest
        if "denoiser" in name:
            torch.nn.init.normal_(parameter, std=0.1)
    return network


@pytest.fixture(scope="module")
def network():
    return made_network()


def poses(batch, frames):
    directions = torch.from_numpy(skeleton.MEAN_UNIT) + 0.3 * torch.randn(batch, frames, 9, 3)
    return torch.nn.functional.normalize(directions, dim=-1)


def inputs(batch=2, frames=41, given=slice(0, 10), extras=0):
    torch.manual_seed(1)
    mask = torch.zeros(batch, frames, 1)
    mask[:, given] = 1
    seeds = given_input(poses(batch, frames), mask, torch.randn(batch, frames, extras) if extras else None)
    asked = torch.from_numpy(stroke_requests.encode_requests(np.array([[0, 0.5, 1, 1.5, 2, 1, 1]]), [(2, 2.5)], frames))
    return {
        "mfcc": torch.randn(batch, mfcc_slice(0, frames).stop, 40),
        "words": 0.06 * torch.randn(batch, frames, 300),
        "seeds": seeds,
        "style": torch.randn(batch, 16),
        "prosody": torch.randn(batch, frames, FEATURES),
        "asked": asked[None].repeat(batch, 1, 1),
        "noise": torch.randn(batch, frames, 27 + extras),
    }


def test_its_size_is_that_of_a_small_download():
    count = sum(p.numel() for p in FlowGenerator(ModelConfig.flow(speakers=24, meanings=30)).parameters())
    assert 2e6 < count < 3e6 and 2 * count < 10e6


@pytest.mark.parametrize("frames", [2, 3, 64, 97])
def test_any_length_gives_unit_directions(network, frames):
    made = network(**inputs(frames=frames, given=slice(0, 1)))
    assert made.shape == (2, frames, 9, 3)
    torch.testing.assert_close(made.norm(dim=-1), torch.ones(2, frames, 9))


@pytest.mark.parametrize("given", [slice(0, 10), slice(35, 41), slice(7, 8), slice(0, 0)])
def test_given_frames_are_kept_wherever_they_lie(network, given):
    chosen = inputs(given=given)
    made = network(**chosen)[:, given]
    wanted = chosen["seeds"][:, given, :27].unflatten(-1, (9, 3)) + network.mean
    torch.testing.assert_close(made, wanted, rtol=0, atol=1e-5)


def test_every_input_and_the_noise_matter(network):
    chosen = inputs()
    made = network(**chosen)
    for name, value in chosen.items():
        changed = {**chosen, name: value * 0 if name in ("seeds", "asked") else value + 0.5}
        assert not torch.allclose(made, network(**changed), atol=1e-4), name


def test_one_performance_does_not_depend_on_those_beside_it(network):
    chosen = inputs(batch=3)
    chosen["seeds"][1] = 0
    together = network(**chosen)
    alone = torch.cat([network(**{name: value[i : i + 1] for name, value in chosen.items()}) for i in range(3)])
    torch.testing.assert_close(together, alone, rtol=0, atol=bound_of(network, 41))


def test_features_of_given_frames_do_not_depend_on_where_others_end(network):
    seeds = inputs(batch=2, frames=80)["seeds"]
    seeds[1, 50:60] = seeds[1, :10]
    with torch.no_grad():
        together, alone = network._affect(seeds)[:1], network._affect(seeds[:1])
    torch.testing.assert_close(together, alone, rtol=0, atol=bound_of(network, 80))


def test_what_is_heard_once_serves_all(network):
    chosen = inputs()
    for name in ("mfcc", "words", "prosody", "asked"):
        chosen[name] = chosen[name][:1].expand_as(chosen[name])
    once = {name: value[:1] if name in ("mfcc", "words", "prosody", "asked") else value for name, value in chosen.items()}
    torch.testing.assert_close(network(**chosen), network(**once), rtol=0, atol=bound_of(network, 41))


def test_extras_are_drawn_beside_the_directions():
    network = made_network(extras=5)
    chosen = inputs(extras=5)
    assert network(**chosen).shape == (2, 41, 9, 3) and network.noise_size == 32


def test_arms_do_not_depend_on_extras_and_extras_depend_on_arms():
    network = made_network(extras=5)
    chosen = inputs(extras=5)
    heard = network.encode(*(chosen[name] for name in ("mfcc", "words", "seeds", "prosody", "asked")))
    directions, extras = network.draw(heard, chosen["style"], chosen["seeds"], chosen["noise"])
    others = chosen["noise"].clone()
    others[..., 27:] += 1
    same, changed = network.draw(heard, chosen["style"], chosen["seeds"], others)
    assert torch.equal(same, directions) and (changed - extras)[:, 10:].abs().min() > 0
    torch.testing.assert_close(changed[:, :10], chosen["seeds"][:, :10, 27:-1])
    others = chosen["noise"].clone()
    others[..., :27] += 1
    assert (network.draw(heard, chosen["style"], chosen["seeds"], others)[1] - extras)[:, 10:].abs().min() > 0


def test_a_velocity_reaches_no_farther_than_told(network):
    x, mask = torch.randn(1, 400, 27), torch.zeros(1, 400, 1)
    conditions = network.conditions(torch.zeros(1, 400, network.feature_size), torch.zeros(1, 16))
    changed = x.clone()
    changed[:, 200] += 1
    apart = network.denoiser(x, mask, conditions, torch.ones(1)) - network.denoiser(changed, mask, conditions, torch.ones(1))
    touched = apart.abs().amax((0, 2)).nonzero().flatten()
    reach = network.velocity_reach
    assert 200 - reach <= touched.min() < 200 - reach // 2 and 200 + reach // 2 < touched.max() <= 200 + reach


def test_the_time_may_come_with_the_conditions_or_with_the_poses(network):
    x, mask, time = torch.randn(2, 40, 27), torch.zeros(1, 40, 1), torch.tensor([0.2, 0.7])
    features, style = torch.randn(2, 40, network.feature_size), torch.randn(2, 16)
    once = network.denoiser(x, mask, network.conditions(features, style), time)
    twice = network.denoiser(x, mask, network.conditions(features, style, time))
    torch.testing.assert_close(twice, once, rtol=0, atol=bound_of(network, 40))


def test_the_depthwise_convolution_has_the_values_and_gradients_of_torchs():
    torch.manual_seed(0)
    layer = Depthwise(6, 5, 2).double()
    x, weights = torch.randn(2, 17, 6).double().requires_grad_(), torch.randn(2, 17, 6).double()
    theirs = x.detach().clone().requires_grad_()
    kernel = layer.weight.detach().T[:, None].clone().requires_grad_()
    made = layer(x)
    wanted = torch.nn.functional.conv1d(theirs.transpose(1, 2), kernel, padding=4, dilation=2, groups=6).transpose(1, 2)
    torch.testing.assert_close(made, wanted)
    (made * weights).sum().backward(), (wanted * weights).sum().backward()
    torch.testing.assert_close(x.grad, theirs.grad)
    torch.testing.assert_close(layer.weight.grad, kernel.grad[:, 0].T)


@pytest.mark.parametrize("bend", [1.0, 1.7])
def test_the_solver_follows_a_field_to_second_order(bend):
    start, moments = torch.ones(1, 1), [time_grid(ModelConfig.flow(flow_steps=steps, flow_bend=bend)) for steps in (16, 32)]
    errors = [float((solve(lambda x, t: x * t, start, one) - np.exp(0.5)).abs()) for one in moments]
    assert errors[0] < 0.01 and errors[1] < 0.3 * errors[0]


def test_steps_of_a_flow_go_from_noise_to_the_performance():
    equal, bent = (np.diff(time_grid(ModelConfig.flow(flow_steps=4, flow_bend=bend))) for bend in (1.0, 1.7))
    np.testing.assert_allclose(equal, 0.25, rtol=1e-12)
    assert (np.diff(bent) > 0).all() and bent.sum() == pytest.approx(1, rel=1e-12)
    for wrong in ({"flow_steps": 0}, {"flow_steps": 1000}, {"flow_bend": 0.0}):
        with pytest.raises(UsageError, match="out of range"):
            ModelConfig.flow(**wrong)


def test_strokes_as_channels():
    table = np.array([[0, 0.4, 1.0, 1.6, 2, 1, 0.8], [1, 0, 0.2, 0.5, 0, 2, 5.0]])
    rows = stroke_requests.stroke_rows(table, np.array([0, 30, 60]))
    assert np.flatnonzero(rows == 0).tolist() == list(range(6, 25)) and np.flatnonzero(rows == 1).tolist() == list(
        range(30, 38)
    )
    channels = stroke_requests.encode_requests(table[:1], [(1.7, 1.9)], 30)
    assert channels.shape == (30, 7) and not channels[:6].any()
    assert channels[15].tolist() == pytest.approx([1, 1, 1, 0, 1, 0.8, 3]) and channels[26].tolist() == [1, 0, 0, 0, 0, 0, 0]
    assert channels[:, 2].argmax() == 15
    assert not stroke_requests.encode_requests(np.zeros((0, 7)), [], 5).any()


def test_less_noise_and_farther_styles_are_settings():
    network, chosen = made_network(), inputs()
    made = network(**chosen)
    for changes in ({"flow_noise": 0.8}, {"flow_style": 2.0}, {"flow_voice": 1.5}):
        other = made_network(**changes)
        assert not torch.allclose(other(**chosen), made, atol=1e-4)
    middle = network.speaker(torch.arange(2))[0].mean(0)
    far = made_network(flow_style=2.0).exaggerate_style(chosen["style"])
    torch.testing.assert_close(far - middle, 2 * (chosen["style"] - middle))
    torch.testing.assert_close(network.exaggerate_style(chosen["style"]), chosen["style"])


def test_only_voice_and_prosody_are_emphasized():
    network, size = made_network(flow_voice=1.5), ModelConfig.flow()
    features = torch.randn(2, 30, network.feature_size)
    changed = (network.emphasize_speech(features) != features).any(1).any(0)
    voice, words = size.seed_size + size.mfcc_size, size.seed_size + size.mfcc_size + size.text_size
    assert not changed[: size.seed_size].any() and changed[size.seed_size : voice].all()
    assert not changed[voice:words].any() and changed[words : words + size.prosody_size].all()
    assert not changed[words + size.prosody_size :].any()
    torch.testing.assert_close(made_network().emphasize_speech(features), features)
