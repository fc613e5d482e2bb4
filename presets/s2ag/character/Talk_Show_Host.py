import bpy

settings = bpy.context.window_manager.s2ag.settings
settings.style = "warm host"
settings.style_second = "eager storyteller"
settings.style_mix = 0.3
settings.intensity = 1.1
settings.follow = 1.0
settings.arousal = 0.5
settings.valence = 0.7
settings.dominance = 0.2
settings.rate = 0.4
settings.hand = 0.0
settings.meaning = 1.0
settings.mirror = False
settings.speed = 1.0
settings.smoothing = 0.0
