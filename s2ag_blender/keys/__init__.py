"""Writes motions to the timeline, as keyframes of actions and as NLA strips."""

from typing import TYPE_CHECKING

if not TYPE_CHECKING:
    from ..lazy_modules import lazily

    __getattr__ = lazily(__name__)
