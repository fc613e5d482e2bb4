"""Word vectors: the table that ships, the user's own, and how a table is built."""
