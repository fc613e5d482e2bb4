"""Writes motions to the timeline, as keyframes of actions and as NLA strips."""
