"""A door for scripts from before the rooms: ``s2ag.core.performance.synthesis`` under its old name."""

from .performance.request import Request, Result
from .performance.synthesis import Session

__all__ = ["Request", "Result", "Session"]
