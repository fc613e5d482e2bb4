"""Shapes assembled talk by its performer and its affect: size, height, openness, posture, and home.

What affect does to a body follows what is known of people (Wallbott 1998; Pollick et al. 2001; Kleinsmith and
Bianchi-Berthouze 2013): arousal makes it larger, faster and higher, valence open or closed, dominance upright and wide or
contracted. By how much, in degrees for an affect of 1, is set until both ends are told from the middle by eye.

Other numbers that give no reason were tried as those of :mod:`talking` were.
"""

from dataclasses import dataclass

import numpy as np

from ...motion import rest, skeleton
from ...motion.interpolation import ramp
from .captured_talk import Footage
from .manner import Manner
from .posture import turn
from .scene import Scene
from .smoothing import smooth
from .speakers import Performer

_ARMS, _TRUNK = list(skeleton.ARM_EDGES), [0, 1, 2, 3, 6]
_SIDES = (((4, 5), -1.0), ((7, 8), 1.0))
"""Edges of each arm, and the sign of outwards on the x axis."""
_SLOW, _QUICK, _SHARED = 1.1, 0.11, 0.45
"""Seconds of Gaussians: about which mean arms are larger or smaller; between the last two, 0.4 to 1.7 Hz, lies what trunk and
head take over of the arms."""
_SIZE_AROUSAL = 0.62
"""Octaves of size by which arousal of 1 widens movements: by half. With tempo, hands are to go at least 1.5 times as fast then,
and at most 0.6 times at -1."""
_LARGEST = 1.7
"""Largest size: beyond it arms would turn around the body."""
_OF_EDGES = np.array([1.4, 0.9, 1.4, 0.9])[:, None]
"""Factors of size of upper arms and forearms: hands that go home come from forearms mostly, and people move from the shoulder
more; without these performances are told by the forearm's share."""
_WAVES, _SIZE_SPREAD, _GAIN_SPREAD = 4.0, 0.16, 0.3
"""Seconds in which size and the gain of trunk and head go up or down, and the deviations of their logarithms: people are not
constant."""
_ASIDE_OTHER, _WAITING = 0.9, 4.0
"""How much smaller the hand that does not lead moves, for a performer who leaves all to one, and the seconds over which its
place is smoothed in the same measure: it waits where it is."""
_LATE, _TURNS = 2.0, 4.0
"""Frames (0.13 s) by which one hand is late after the other, and the seconds in which they change places in it: two hands that
move as each other's image tell performances most."""
_PERCH = 0.85
"""How far hands stay about the middle of those seconds: people's beats start from a perch and come back to it, and movements
that were made smaller about a place that wanders seldom do."""
_LAGS = (-2, -1, 0, 1, 2)
"""Frames by which arms that predict trunk and head are shifted: before and after them by 0.13 s."""
_PENALTY = 0.02
"""Ridge of that prediction, as a share of the inputs' mean square."""
_FOLLOW = {"head": 1.0, "trunk": 1.2}
"""Gains of what arms predict of head and trunk."""
_OWN_HEAD, _OWN_LEAN = 0.6, 0.5
"""Shares of the footage's own slow head and trunk that are kept."""
_ASIDE_OF_HANDS, _OWN_ASIDE, _PLACED = -0.3, 0.5, 2.0
"""Mean sideways part of captured bent forearms (inwards), the share of the footage's own difference from it that is kept, and
the seconds over which it is taken: where hands live is the performer's and the mood's, not of the piece that is shown."""
_OPEN, _CLOSE = (15, 40), (10, 24)
"""Degrees by which elbows and forearms go outwards for a valence of 1, and inwards for -1: arms that close far would cross."""
_SLOW_TRUNK = 1.5
"""Seconds of the Gaussian that tells slow leans and turns from quick ones."""
_SINK, _PAUSE, _SILENCE = 0.7, 0.35, 1.6
"""Seconds in which hands go home and come back, of the shortest pause in which they do, and of one in which all do wholly."""
_SOONER, _EARLIER = 0.1, 0.45
"""Seconds by which hands leave before the voice ends, and start before it goes on."""
_DEPTHS, _DEPTH_AROUSAL, _WHOLLY = (0.2, 0.8), 0.35, 0.97
"""Least and most of the performer's way home in a short pause, what arousal of 1 takes from it, and the way in a long one."""
_LATER, _LESS = 1.0, 0.0
"""Most seconds by which the second hand goes home after the first, and the least share of its way: hands that move as each
other's image tell performances most."""
_PHRASES = 0.3
"""Seconds of the Gaussian by which phrases with and without gestures pass into each other."""
_SUNK, _MOST_SUNK = 0.38, 0.5
"""How far hands stay home while they gesture for arousal of -1, and at most."""

_BEHIND = -0.1
"""Forward part of an upper arm (6 degrees back) from which on it hardly goes farther behind the shoulder."""
_ASIDE = 0.28
"""Sideways part of an upper arm (16 degrees out) from which on it hardly goes farther: a captured talker has elbows akimbo."""
_REST_BEHIND, _REST_ASIDE = 0.3, 0.35
"""Shares of what goes beyond these that are kept, so that elbows do not stop at a wall."""

_FRONT = skeleton.normalize(
    np.array([[-0.2, 0.96, 0.06], [0.55, 0.2, 0.78], [0.2, 0.96, 0.06], [-0.55, 0.2, 0.78]])
)
"""Arms of hands that wait before the belly."""


@dataclass(frozen=True)
class Following:
    """How trunk and head follow the arms' quick movements in captured talk: ``weights`` ``(12 x lags, 15)``."""

    weights: np.ndarray

    @classmethod
    def learn(cls, talk: tuple[Footage, ...]) -> "Following":
        """Fit by ridge regression on captured talk."""
        inputs = np.concatenate([_lagged(_quick(one.directions[:, _ARMS])) for one in talk])
        outputs = np.concatenate([_quick(one.directions[:, _TRUNK]).reshape(-1, 15) for one in talk])
        penalty = _PENALTY * len(inputs) * np.mean(inputs**2) * np.eye(inputs.shape[1])
        return cls(np.linalg.solve(inputs.T @ inputs + penalty, inputs.T @ outputs))

    def predict(self, arms: np.ndarray) -> np.ndarray:
        """Return quick movements of trunk and head ``(frames, 5, 3)`` that go with arms ``(frames, 4, 3)``."""
        return (_lagged(_quick(arms)) @ self.weights).reshape(len(arms), 5, 3)


def _quick(values: np.ndarray) -> np.ndarray:
    return smooth(values, _QUICK) - smooth(values, _SHARED)


def _lagged(arms: np.ndarray) -> np.ndarray:
    flat = arms.reshape(len(arms), -1)
    return np.concatenate([np.roll(flat, lag, axis=0) for lag in _LAGS], axis=1)


def talk_body(
    directions: np.ndarray,
    gesturing: np.ndarray,
    manner: Manner,
    scene: Scene,
    arousal: np.ndarray,
    random: np.random.Generator,
) -> np.ndarray:
    """Return an assembled performance ``(frames, 9, 3)`` in its performer's size and hands, which go home in pauses.

    ``gesturing`` ``(frames,)`` is 1 in phrases of talk, ``arousal`` ``(frames,)`` goes from -1.5 to 1.5.
    """
    body = directions.astype(float).copy()
    time = np.arange(len(body)) / skeleton.FPS
    home = _home_weight(gesturing, manner, scene, arousal, time, random)
    _part(body, random)
    body[:, _ARMS] = _sized(body[:, _ARMS], manner, arousal, random)
    body = skeleton.normalize(body)
    _go_home(body, manner, home)
    return body


def express(
    body: np.ndarray,
    performer: Performer,
    manner: Manner,
    affect: np.ndarray,
    following: Following,
    random: np.random.Generator,
) -> np.ndarray:
    """Return a body ``(frames, 9, 3)`` whose trunk and head go along, where its performer has the hands, in the posture of its
    ``affect`` ``(frames, 3)``: arousal, valence, dominance, -1.5 to 1.5.
    """
    body = body.copy()
    _steady(body, following.predict(body[:, _ARMS]), random)
    _place(body, manner, affect, random)
    _rein_in(body)
    _posture(body, performer, affect)
    return skeleton.normalize(body)


def _part(body: np.ndarray, random: np.random.Generator) -> None:
    """Let one hand be late after the other, each in its turn, in place."""
    late = _LATE * np.tanh(_wander(len(body), _TURNS, random))
    frames = np.arange(len(body), dtype=float)
    for (edges, _), sign in zip(_SIDES, (-1, 1), strict=True):
        at = np.clip(frames - np.maximum(sign * late, 0), 0, len(body) - 1)
        low = np.minimum(at.astype(int), len(body) - 2)
        share = (at - low)[:, None]
        for edge in edges:
            body[:, edge] = (1 - share) * body[low, edge] + share * body[low + 1, edge]


def _sized(arms: np.ndarray, manner: Manner, arousal: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Return arms ``(frames, 4, 3)`` that move more or less about where they are."""
    slow, waiting = smooth(arms, _SLOW), smooth(arms, _WAITING)
    perch = slow + _PERCH * (waiting - slow)
    if manner.lead:
        other = slice(0, 2) if manner.lead > 0 else slice(2, 4)
        perch[:, other] += _ASIDE_OTHER * manner.alone * (waiting[:, other] - perch[:, other])
    drift = np.exp(_wander(len(arms), _WAVES, random) * _SIZE_SPREAD)
    size = np.minimum(manner.size * 2 ** (_SIZE_AROUSAL * arousal) * drift, _LARGEST)[:, None, None] * _OF_EDGES
    own = np.array([1.0, 1.0])
    own[int(manner.lead < 0)] -= _ASIDE_OTHER * manner.alone * abs(manner.lead)
    shares = np.repeat(own, 2)
    return perch + size * shares[:, None] * (arms - slow)


def _steady(body: np.ndarray, quick: np.ndarray, random: np.random.Generator) -> None:
    """Halve slow leans and turns of trunk and head, and let both go along with the arms, in place."""
    slow = smooth(body[:, _TRUNK], _SLOW_TRUNK)
    middle = slow.mean(axis=0)
    own = np.array([_OWN_LEAN, _OWN_HEAD, _OWN_HEAD, _OWN_LEAN, _OWN_LEAN])[:, None]
    gain = np.array([_FOLLOW["trunk"], _FOLLOW["head"], _FOLLOW["head"], _FOLLOW["trunk"], _FOLLOW["trunk"]])[:, None]
    drift = np.exp(_GAIN_SPREAD * _wander(len(body), _WAVES, random))[:, None, None]
    # Where a captured person happened to look and lean is not part of another's talk.
    upright = skeleton.MEAN_UNIT[_TRUNK]
    body[:, _TRUNK] = upright + own * (slow - middle) + (body[:, _TRUNK] - slow) + drift * gain * quick


def _place(body: np.ndarray, manner: Manner, affect: np.ndarray, random: np.random.Generator) -> None:
    """Raise or lower, open or close raised arms by manner and affect, in place; height and width wander by 3 or 4 degrees."""
    arousal, valence, dominance = affect.T
    height = manner.height + 13 * arousal + 4 * valence + 3 * dominance + 4 * _wander(len(body), 6.0, random)
    wide = manner.wide + 3 * _wander(len(body), 5.0, random)
    elbows, forearms = (np.where(valence > 0, more, less) * valence for more, less in zip(_OPEN, _CLOSE, strict=True))
    for (upper, fore), out in _SIDES:
        bent = np.clip(1 - (body[:, upper] * body[:, fore]).sum(-1), 0, 0.6) / 0.6
        slow = smooth(body[:, fore, 0], _PLACED)
        body[:, fore, 0] += (1 - _OWN_ASIDE) * bent * (out * _ASIDE_OF_HANDS - slow)
        elbow = wide + 9 * dominance + elbows + arousal
        turn(body, (upper,), pitch=-0.45 * height * bent, roll=out * elbow)
        apart = wide + forearms + 4 * dominance
        turn(body, (fore,), pitch=-height * bent, roll=out * 0.6 * elbow, yaw=-out * apart * bent)


def _home_weight(
    gesturing: np.ndarray, manner: Manner, scene: Scene, arousal: np.ndarray, time: np.ndarray, random: np.random.Generator
) -> np.ndarray:
    """Return how far each hand is home ``(frames, 2)``: outside gestured phrases wholly, in pauses in part, more when calm."""
    away = 1 - smooth(gesturing, _PHRASES)
    weight = np.zeros((len(time), 2))
    for begin, end in scene.pauses:
        if end - begin >= _PAUSE:
            mood = float(np.interp(begin, time, arousal))
            long = np.clip((end - begin - _PAUSE) / (_SILENCE - _PAUSE), 0, 1)
            depth = np.clip(random.uniform(*_DEPTHS) * (manner.home - _DEPTH_AROUSAL * mood), 0, 1)
            leave, back = begin - _SOONER, end - _EARLIER
            second = int(random.integers(2))
            for hand in (0, 1):
                later, share = (random.uniform(0, _LATER), random.uniform(_LESS, 1)) if hand == second else (0.0, 1.0)
                down = ramp(time, leave + later, leave + later + _SINK)
                if end < scene.speech.duration:
                    down *= 1 - ramp(time, back + later, back + later + _SINK)
                deep = share * depth
                weight[:, hand] = np.maximum(weight[:, hand], (deep + (_WHOLLY - deep) * long**2) * down)
    sunk = np.clip(-_SUNK * smooth(arousal, 1.0), 0, _MOST_SUNK)
    return 1 - ((1 - away) * (1 - sunk))[:, None] * (1 - weight)


def _go_home(body: np.ndarray, manner: Manner, home: np.ndarray) -> None:
    """Move the arms towards home by the weight of each hand ``(frames, 2)``, in place."""
    place = _FRONT if manner.front else rest.REST[_ARMS].astype(float)
    target = np.broadcast_to(place, body[:, _ARMS].shape)
    body[:, _ARMS] = rest.slerp(body[:, _ARMS], target, np.repeat(home, 2, axis=1))


def _posture(body: np.ndarray, performer: Performer, affect: np.ndarray) -> None:
    """Lean, shoulders and chin of the performer and of affect, in place."""
    arousal, valence, dominance = affect.T
    slump = np.maximum(-arousal, 0)
    lean = performer.lean + 3.5 * np.maximum(arousal, 0) + 7 * slump - 5 * dominance - 2 * valence
    lift = performer.shoulders + 3 * np.maximum(arousal, 0) - 4 * slump - 3 * dominance
    chin = performer.chin - 9 * slump + 6 * dominance + 6 * valence + 2 * np.maximum(arousal, 0)
    turn(body, (3,), roll=-lift)
    turn(body, (6,), roll=lift)
    turn(body, tuple(range(9)), pitch=0.5 * lean)
    turn(body, tuple(_TRUNK), pitch=0.5 * lean)
    turn(body, (1, 2), pitch=-chin)


def _rein_in(body: np.ndarray) -> None:
    """Keep elbows from behind the shoulders and from standing out like wings, softly, in place."""
    for (upper, _), out in _SIDES:
        depth, aside = body[:, upper, 2], out * body[:, upper, 0]
        body[:, upper, 2] = np.where(depth < _BEHIND, _BEHIND + _REST_BEHIND * (depth - _BEHIND), depth)
        body[:, upper, 0] = out * np.where(aside > _ASIDE, _ASIDE + _REST_ASIDE * (aside - _ASIDE), aside)
    body[:] = skeleton.normalize(body)


def _wander(frames: int, seconds: float, random: np.random.Generator) -> np.ndarray:
    """Return a slow random curve ``(frames,)`` of mean 0 and deviation about 1."""
    knots = random.normal(size=int(frames / (seconds * skeleton.FPS)) + 3)
    at = np.arange(frames) / (seconds * skeleton.FPS) + random.uniform()
    low = at.astype(int)
    share = 0.5 - 0.5 * np.cos(np.pi * (at - low))
    return (1 - share) * knots[low] + share * knots[low + 1]
