import bpy

settings = bpy.context.window_manager.s2ag.settings
settings.style = "grand orator"
settings.style_second = "brisk presenter"
settings.style_mix = 0.35
settings.intensity = 1.1
settings.follow = 1.0
settings.arousal = 0.3
settings.valence = 0.2
settings.dominance = 0.6
settings.rate = 0.1
settings.hand = 0.0
settings.meaning = 1.0
settings.mirror = False
settings.speed = 1.0
settings.smoothing = 0.0
