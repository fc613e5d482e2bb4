"""Motions as unit directions of nine body edges per frame, with hands, fingers, pelvis and face; and the limits of a body."""
