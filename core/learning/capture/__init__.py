"""Motion from films of people: pose, cleaning, data sets and performers. Of the Python package alone."""
