"""Training that begins with weights that are there."""

import pytest

torch = pytest.importorskip("torch", reason="the engine is not installed")

from s2ag.core.errors import S2agError  # noqa: E402
from s2ag.core.learning.train import warm_start  # noqa: E402
from s2ag.core.model import checkpoint  # noqa: E402
from s2ag.core.model.config import ModelConfig  # noqa: E402
from s2ag.core.model.flow import FlowGenerator  # noqa: E402
from s2ag.core.motion import hand_channels  # noqa: E402

FACTS = {"speakers": [{"name": name} for name in "abc"], "training": {"settings": {"frames": 64, "seed_frames": 10}}}


def flow(seed, **changes):
    torch.manual_seed(seed)
    network = FlowGenerator(ModelConfig.flow(**{"speakers": 3, "flow_size": 32, "flow_condition": 24, **changes}))
    for parameter in network.parameters():
        torch.nn.init.normal_(parameter, std=0.1)
    return network


@pytest.fixture
def known(tmp_path):
    network = flow(1)
    checkpoint.save(tmp_path / "known.safetensors", network, None, FACTS)
    return network, tmp_path / "known.safetensors"


def test_all_is_taken_over_by_a_network_of_the_same_form(known):
    network, path = known
    other = flow(2)
    assert warm_start.copy_weights(other, path) == []
    for name, value in network.state_dict().items():
        torch.testing.assert_close(other.state_dict()[name], value, rtol=2**-8 + 2**-11, atol=2**-22 + 2**-25)


def test_a_network_that_also_learns_hands_moves_its_arms_as_before(known):
    network, path = known
    other = flow(2, extras=hand_channels.SIZE)
    anew = warm_start.copy_weights(other, path)
    assert {name for name in anew if not name.startswith("extras_denoiser.")} == {"centre", "scale"}
    same = checkpoint.load(path).generator
    seeds, style = torch.zeros(1, 20, other.noise_size + 1), torch.randn(1, network.config.style_size)
    heard = torch.randn(1, 20, network.feature_size)
    noise = torch.randn(1, 20, other.noise_size)
    mine, theirs = (
        one.draw(heard, style, seeds[..., -n - 1 :], noise[..., :n])[0] for one, n in ((other, other.noise_size), (same, 27))
    )
    assert torch.equal(mine, theirs)


def test_other_speakers_begin_anew(known):
    other = flow(2, speakers=5)
    anew = warm_start.copy_weights(other, known[1])
    assert anew and all("speaker" in name for name in anew)


def test_what_is_no_checkpoint_is_refused(tmp_path):
    (tmp_path / "odd.safetensors").write_bytes(b"nothing")
    with pytest.raises(S2agError):
        warm_start.copy_weights(flow(1), tmp_path / "odd.safetensors")
