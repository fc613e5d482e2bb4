import bpy

settings = bpy.context.window_manager.s2ag.settings
settings.style = "nervous"
settings.style_second = ""
settings.style_mix = 0.5
settings.intensity = 0.8
settings.follow = 1.0
settings.arousal = 0.2
settings.valence = -0.3
settings.dominance = -0.7
settings.rate = -0.1
settings.hand = 0.0
settings.meaning = 1.0
settings.mirror = False
settings.speed = 1.0
settings.smoothing = 0.0
