"""The network that a configuration describes."""

from .config import ModelConfig
from .encoders import Encoders
from .flow import FlowGenerator
from .generator import Generator


def make(config: ModelConfig) -> Encoders:
    """A network with random weights; all kinds share encoders, styles and the arguments of their ``forward``."""
    return FlowGenerator(config) if config.decoder == "flow" else Generator(config)
