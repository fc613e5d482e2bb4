"""Writes scenes to files: films, images, and exchange formats."""

from typing import TYPE_CHECKING

if not TYPE_CHECKING:
    from ..lazy_modules import lazily

    __getattr__ = lazily(__name__)
