"""What is moved: nine unit directions a frame, and what a body allows."""

from .motion import Motion

__all__ = ["Motion"]
