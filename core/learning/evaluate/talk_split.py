"""Which captured talk and which voices settings may be chosen on, and which are only reported: one split, declared here.

What a training, a director's library or a number of the rules is chosen on says nothing about how good it is elsewhere.
A report therefore measures on the second part, of which nothing else in the project reads anything.
"""

from fnmatch import fnmatch

CAPTURED_CHOSEN_ON = ("m_conversation", "f_gestic_presentation_right_01", "m_gestic_presentation_left_01")
"""Names of captured talk that may be taught and that settings may be chosen on: 65 s, all with both hands."""
CAPTURED_REPORTED = ("f_gestic_presentation_left_01", "f_trolley_talk", "f_umbrella_talk_01")
"""Names of captured talk that is kept for reports: 80 s, 16 s with both hands, 64 s with one hand busy."""
KINDS = {
    "a man's conversation": ("m_conversation",),
    "a man presents": ("m_gestic_presentation_left_01",),
    "a woman presents": ("f_gestic_presentation_right_01", "f_gestic_presentation_left_01"),
    "one hand busy": ("f_trolley_talk", "f_umbrella_talk_01"),
}
"""The kinds of people that captured talk shows. People who listen do not talk, and SmartBody's clips are emblems."""
VOICES_CHOSEN_ON = ("hello*", "p001*", "p002*", "sense_and_sensibility_*", "arctic_a*", "arctic_b0[0-4]*")
"""Patterns of file names of voices that settings may be chosen on; the rules of today were, on the first four."""
VOICES_REPORTED = ("arctic_b05*", "thorsten_emotional/*")
"""Patterns of voices kept for reports: the last sentences of a woman's reading, and a man who acts emotions in German."""


def may_choose_on(name: str) -> bool:
    """Whether settings may be chosen on, and a network taught by, captured talk or a voice of this name.

    A name of a file, with or without its ending; of ``thorsten_emotional/`` with its folder. What is not listed may.
    """
    return name not in CAPTURED_REPORTED and not any(fnmatch(name, pattern) for pattern in VOICES_REPORTED)
