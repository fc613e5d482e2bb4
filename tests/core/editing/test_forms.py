"""A gesture that an edit adds has one of its forms, by the seed, as those of a performance have."""

from s2ag.core.editing import gestures
from s2ag.core.editing.director import Director
from s2ag.core.synthesis.request import Request
from s2ag.core.synthesis.session import Session


def test_the_seed_chooses_the_form_of_a_gesture_that_is_added(examples):
    director, hands = Director(Session()), set()
    for seed in range(1, 6):
        request = Request(examples / "hello.flac", transcript=examples / "hello.txt", seed=seed)
        result = director.direct(request, [{"do": "add", "at": 7.0, "kind": "rise"}])
        found = gestures.nearest_gesture(result.motions[0], 7.0)
        assert found is not None and found.kind == "rise" and abs(found.at - 7.0) < 0.08
        assert all("suddenly" in warning for warning in result.warnings)  # than a calm take does
        hands.add(found.hand == "both")
    assert hands == {True, False}
