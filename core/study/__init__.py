"""The paper's user study from anybody's clips (paper section 5.5)."""
