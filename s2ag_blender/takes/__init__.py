"""Runs the engine for a character and manages the takes that result."""
