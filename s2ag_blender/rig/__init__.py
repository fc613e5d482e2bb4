"""Reads an armature's rest pose and mapping, and solves poses on it."""

from typing import TYPE_CHECKING

if not TYPE_CHECKING:
    from ..lazy_modules import lazily

    __getattr__ = lazily(__name__)
