"""One run of the engine, and what it leaves on a character."""
