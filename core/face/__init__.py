"""A recording becomes a speaking face: lips by its sounds, eyes and brows by its phrases. The value is :mod:`motion.face`."""
