"""From ten joints to any armature: numpy maths and rig families as data."""
