"""Many clips: a manifest, stages that can be repeated and cut into slices, and a crew of processes on one machine.

Nothing is remembered but in files: a stage of a clip is done when its record names the content it was made from and the
files it made are there. So a batch can be killed at any moment, started twice, and spread over machines that share a folder.
"""
