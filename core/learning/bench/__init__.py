"""The paper's table: eight systems trained and judged alike."""
