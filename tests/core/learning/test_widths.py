"""What shrinks with the bench's widths, and what a generator still sees of the given poses."""

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from s2ag.core.learning.systems.catalogue import ALL_SYSTEMS, BuildOptions, scale_judge, scale_widths  # noqa: E402
from s2ag.core.model import paper_networks  # noqa: E402
from s2ag.core.model.affective_encoder import AffectiveEncoder  # noqa: E402


def built(name, share, seed=0):
    torch.manual_seed(seed)
    return ALL_SYSTEMS[name].build(BuildOptions(torch.zeros(20, 200), 1, share, trained_words=False))


def share_of_poses(name, share):
    """The share of a GRU's inputs that tell of the given poses."""
    generator = built(name, share).generator
    return generator.config.seed_size / generator.gru.weight_ih_l0.shape[1]


def test_given_poses_keep_a_share_of_the_inputs():
    """Raw poses do not shrink, so that the share of both grows; encoded ones were 2 of 22 when they did."""
    published = [share_of_poses(name, 1.0) for name in ("s2ag", "s2ag-no-affect")]
    assert published == [pytest.approx(8 / 88), pytest.approx(28 / 108)]
    quarter = [share_of_poses(name, 0.25) for name in ("s2ag", "s2ag-no-affect")]
    assert quarter == [pytest.approx(8 / 28), pytest.approx(28 / 48)]
    assert quarter[0] / quarter[1] > published[0] / published[1]


@pytest.mark.parametrize("name", ["s2ag", "s2ag-no-mfcc"])
def test_the_generators_encoder_has_its_published_size_and_the_judge_is_scaled(name):
    whole, quarter = built(name, 1.0), built(name, 0.25)
    shapes = [{key: value.shape for key, value in one.generator.aff_encoder.state_dict().items()} for one in (whole, quarter)]
    assert shapes[0] == shapes[1]
    sizes = [sum(p.numel() for p in one.judge.discriminator.aff_encoder.parameters()) for one in (whole, quarter)]
    assert sizes[1] < 0.1 * sizes[0]


def read_out(encoder):
    """The share of the last given pose's variance that a linear map of four frames of features tells, of other poses."""
    random = torch.Generator().manual_seed(0)
    there = torch.randn(400, 8, 1, generator=random)
    moving = there + 0.3 * torch.randn(400, 8, 1, generator=random) * torch.linspace(-1, 1, 34)
    poses = (moving.transpose(1, 2) @ (0.12 * torch.randn(8, 27, generator=random))).unflatten(-1, (9, 3))
    poses[:, 4:] = 0  # not given
    with torch.inference_mode():
        features = encoder.train()(poses)[:, :4].flatten(1)  # normalised by this batch
    wanted, known = poses[:, 3].flatten(1), torch.cat([features, torch.ones(400, 1)], 1)
    guess = known[200:] @ torch.linalg.lstsq(known[:200], wanted[:200]).solution
    return 1 - float((guess - wanted[200:]).square().sum() / (wanted[200:] - wanted[200:].mean(0)).square().sum())


def test_the_last_given_pose_can_be_read_out_at_a_quarter_as_at_the_published_width():
    """As it is before training, mean of five; the scaled encoder of the discriminator is what the generator had."""
    published, found = paper_networks.published(), {}
    quarter = scale_widths(published, 0.25)
    for name, config in {"whole": published, "quarter": quarter, "scaled": scale_judge(quarter, 0.25)}.items():
        torch.manual_seed(0)
        found[name] = np.mean([read_out(AffectiveEncoder(config)) for _ in range(5)])
    assert abs(found["quarter"] - found["whole"]) < 0.05 and found["quarter"] > found["scaled"] + 0.2, found
