"""What is heard: samples, MFCC, prosody, speech and silence."""
