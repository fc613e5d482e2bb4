"""The benchmark: the systems of the paper's table, trained and evaluated alike."""
