"""Facial animation from a recording: lips from its phones, eyes and brows from its phrases (see :mod:`motion.face`)."""
