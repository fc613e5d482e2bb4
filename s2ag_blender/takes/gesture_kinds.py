"""What the kinds of gesture show, as menus tell it: a sentence each, and a small picture of the pose."""

import functools
from typing import Any

import bpy
import bpy.utils.previews

from ...core.meaning import gesture_picture, vocabulary

SHOWN = {
    "shrug": "Shoulders and palms go up: nobody knows", "negation": "A flat hand wipes it away, the head shakes",
    "refusal": "Both palms stop somebody", "big": "Both hands show how large it is",
    "small": "Both hands show how little it is", "one": "One finger is shown", "two": "Two fingers are shown",
    "three": "Three fingers are shown", "me": "A hand goes to the own chest", "you": "An open hand goes to the listener",
    "here": "A finger points down, in front", "there": "A stretched arm points to the side",
    "contrast": "One hand weighs against the other", "step": "A hand sets down one thing after the other",
    "question": "An open hand asks", "rise": "Flat hands go up", "fall": "A flat hand goes down",
    "grow": "Both hands go apart, and it grows", "shrink": "Both hands come together, and it shrinks",
    "high": "A hand shows how high it is", "low": "A hand shows how low it is", "long": "Both hands draw out how long it is",
    "wide": "Both arms open wide", "narrow": "Two flat hands leave little between them",
    "circle": "A finger draws a circle in the air", "around": "Both arms go around, out to the sides",
    "surface": "Flat hands glide over something level", "line": "A flat hand draws a line forward",
    "container": "Both hands hold a bowl of air", "in": "Both hands put something in", "out": "A hand takes something out",
    "across": "A hand goes in an arc from side to side", "forward": "A hand goes straight ahead",
    "back": "A hand goes back over the shoulder", "come": "A hand beckons twice", "away": "A hand wipes something aside",
    "far": "A hand reaches out to something far off", "near": "Both hands come close to each other",
    "merge": "Both hands meet in the middle", "split": "Both hands part from the middle", "cut": "A hand chops down",
    "mix": "A hand stirs", "swap": "Both hands change places", "turn": "A hand turns over",
    "balance": "Both hands go up and down like scales", "soso": "A flat hand tips to and fro",
    "repeat": "A hand goes round twice", "many": "Both hands set down one beside the other",
    "few": "Thumb and finger leave a little gap", "whole": "Both arms go round all of it",
    "part": "A flat hand cuts off a piece", "push": "Both palms push something away",
    "pull": "Both fists draw something near", "throw": "A hand throws something forward", "force": "A fist comes down",
    "block": "A palm holds something off", "give": "Open hands give something to the listener",
    "take": "A hand grasps something and takes it", "hold": "Both hands hold something firmly",
    "open": "Both hands open like a door", "close": "Both hands close like a door", "fast": "A flat hand shoots past",
    "slow": "Flat hands sink slowly", "past": "A hand points back over the shoulder",
    "future": "A hand goes ahead in an arc", "now": "Both hands point down: here and now",
    "think": "A hand goes to the temple", "heart": "A flat hand lies on the heart",
    "thanks": "Both palms meet before the chest", "greet": "A raised hand waves",
    "certain": "Flat hands press down: that is settled", "listen": "A hand goes behind the ear",
    "attention": "A raised finger asks for attention", "we": "An open hand goes round to all",
    "left": "The left hand points to the left", "right": "The right hand points to the right",
    "four": "Four fingers are shown", "five": "Five fingers are shown", "six": "Six fingers are shown, by both hands",
    "seven": "Seven fingers are shown, by both hands", "eight": "Eight fingers are shown, by both hands",
    "nine": "Nine fingers are shown, by both hands", "ten": "Ten fingers are shown", "wave": "A hand goes across in waves",
    "shake": "Both hands tremble", "point": "A finger points at something in front",
    "nothing": "Flat hands wipe the table clean", "eat": "A hand goes to the mouth",
    "write": "A hand writes into the other one", "phone": "A hand holds a telephone to the ear",
}  # fmt: skip
"""Kind of gesture -> what it shows."""
_PICTURES: list[Any] = []


@functools.cache  # Blender keeps no reference to the texts of a menu
def pictured(kinds: tuple[tuple[str, str, str], ...]) -> list[tuple]:
    """Return items of kinds with their pictures."""
    return [(name, label, told, _icon(name), number) for number, (name, label, told) in enumerate(kinds)]


def _icon(name: str) -> int:
    """Return the number of the icon that shows a kind, 0 for none; without a window nobody sees it, and it is not drawn."""
    shown = vocabulary.load_vocabulary().gestures
    if bpy.app.background or name not in shown:
        return 0
    if not _PICTURES:
        _PICTURES.append(bpy.utils.previews.new())
    if name in _PICTURES[0]:
        return _PICTURES[0][name].icon_id
    picture = _PICTURES[0].new(name)
    picture.image_size = picture.icon_size = gesture_picture.SIZE, gesture_picture.SIZE
    pixels = gesture_picture.draw(shown[name]).ravel().tolist()
    picture.image_pixels_float = picture.icon_pixels_float = pixels
    return picture.icon_id


def drop_pictures() -> None:
    """Drop the pictures, which Blender would miss at its end."""
    pictured.cache_clear()
    for pictures in _PICTURES:
        bpy.utils.previews.remove(pictures)
    _PICTURES.clear()
