"""Audio: decoding, MFCC, pitch, prosody and voice activity."""
