"""Client of the engine: starts its process, sends requests, decodes recordings for it, and keeps its state."""
