"""Creates the network that a configuration describes."""

from .config import ModelConfig
from .encoders import Encoders
from .flow import FlowGenerator
from .generator import Generator


def make_generator(config: ModelConfig) -> Encoders:
    """Create a network with random weights; all kinds share encoders, styles and the arguments of ``forward``."""
    return FlowGenerator(config) if config.decoder == "flow" else Generator(config)
