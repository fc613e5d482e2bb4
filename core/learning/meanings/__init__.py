"""Makes the table of words that call for gestures, core/assets/meanings/en.words.json, from WordNet."""
