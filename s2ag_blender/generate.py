"""A door for scripts: gestures for a character's settings in three steps, see :mod:`.takes.generate`."""

from .takes.generate import Outcome, Plan, finish, plan, wait

__all__ = ["Outcome", "Plan", "finish", "plan", "wait"]
