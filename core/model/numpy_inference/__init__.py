"""Flow inference in numpy alone, for the shipped checkpoint in Blender and on the command line.

Arrays are ``(..., frames, channels)`` float32 throughout, so that a convolution along time is one product of its windows."""
