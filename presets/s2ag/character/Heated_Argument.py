import bpy

settings = bpy.context.window_manager.s2ag.settings
settings.style = "stern"
settings.style_second = "grand orator"
settings.style_mix = 0.4
settings.intensity = 1.25
settings.follow = 1.0
settings.arousal = 0.9
settings.valence = -0.8
settings.dominance = 0.7
settings.rate = 0.6
settings.hand = 0.0
settings.meaning = 1.0
settings.mirror = False
settings.speed = 1.0
settings.smoothing = 0.0
