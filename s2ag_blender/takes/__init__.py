"""Runs the engine for a character and manages the takes that result."""

from typing import TYPE_CHECKING

if not TYPE_CHECKING:
    from ..lazy_modules import lazily

    __getattr__ = lazily(__name__)
