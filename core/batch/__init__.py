"""Batches of clips: a manifest, repeatable stages that can be split into slices, and a pool of processes on one machine.

All state is in files: a stage of a clip is done if its record has the hash of its inputs and its output files exist. So a
batch can be killed at any time, started twice, and distributed over machines that share a folder.
"""
