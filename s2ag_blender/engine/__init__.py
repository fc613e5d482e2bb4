"""Client of the engine: starts its process, sends requests, decodes recordings for it, and keeps its state."""

from typing import TYPE_CHECKING

if not TYPE_CHECKING:
    from ..lazy_modules import lazily

    __getattr__ = lazily(__name__)
