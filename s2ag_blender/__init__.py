"""The Blender side: the only part that imports ``bpy``. Importing this package alone imports nothing else."""
