"""Data in which gesture follows from speech, words, speaker and affect by known shares, to test the paper's claim."""
