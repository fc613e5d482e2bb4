"""Word vectors: the shipped table, vectors of the user, and how a table is built."""
