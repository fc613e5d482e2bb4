"""Characters: the mannequin, the human, and those from files."""
