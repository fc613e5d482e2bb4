"""Transcripts: reading, speech recognition and forced alignment of words with the recording."""
