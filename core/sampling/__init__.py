"""Takes to choose from: sheets of sampled takes, and the map of the style space."""
