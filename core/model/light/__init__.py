"""The network that draws performances, in numpy alone: what ships performs by it, in Blender and on the command line.

Arrays are ``(..., frames, channels)`` float32 throughout, so that a convolution along time is one product of its windows.
"""
