import bpy

person = bpy.context.object
settings = (person if person.type == "ARMATURE" else person.find_armature()).s2ag

settings.style = "warm host"
settings.style_second = "eager storyteller"
settings.style_mix = 0.3
settings.intensity = 1.1
settings.arousal = 0.5
settings.valence = 0.7
settings.dominance = 0.2
settings.rate = 0.4
settings.hand = 0.0
settings.meaning = 1.0
settings.mirror = False
settings.speed = 1.0
settings.smoothing = 0.0
