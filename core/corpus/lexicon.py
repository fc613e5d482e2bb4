"""Words that ask for a gesture of their own, as data: meaning -> words, two-word phrases joined by a space."""

WORDS = {
    "me": "i me my mine myself i'm i've i'd i'll",
    "you": "you your yours yourself you're you've you'd you'll",
    "we": "we us our ours ourselves together we're we've we'd we'll let's community family friends share",
    "not": "not no don't doesn't didn't can't cannot couldn't won't wouldn't isn't aren't wasn't weren't haven't hasn't "
    "hadn't shouldn't without neither nor refuse wrong deny reject",
    "none": "never nothing nobody none nowhere gone empty over finished lost",
    "however": "but however although though instead except rather unless otherwise yet despite besides",
    "example": "example instance when while during meanwhile such",
    "all": "all every everyone everybody everything everywhere whole entire always world total complete completely "
    "around across throughout everybody's",
    "big": "big huge great large enormous vast giant massive bigger biggest larger greater more most many much grow "
    "growing increase rise wide",
    "thing": "thing things something kind sort idea small little tiny bit part piece few less form story plan system",
    "here": "here now this today these right",
    "there": "there that those then far away outside back beyond next left down other others another",
    "stop": "stop wait enough hold end ends stopped prevent against keep",
    "maybe": "maybe perhaps probably possibly guess somehow whatever unknown",
    "think": "think thought believe know knew wonder remember understand imagine learn feel felt mind seems seemed",
    "please": "please help need hope wish sorry beg want love dear thank thanks forgive",
    "offer": "give gave offer would could might suggest show take here's bring send provide",
    "receive": "get got receive came come comes accept welcome join",
    "question": "what why how who where which whose",
    "list": "first second third one two three four five six seven eight nine ten hundred thousand finally must "
    "exactly every day",
}
"""Order matters: the first meaning that lists a word has it."""

_EMPHATIC = "very really so too only even just never always must every all no not nothing great big huge best worst"
EMPHATIC = frozenset(_EMPHATIC.split())
"""Words that carry an accent more often than their stress says."""

_FUNCTION = (
    "a an the of to in on at by for from with and or as is are was were be been being it its he him his she her they "
    "them their i you we us our your my me that this these those there which who whom whose than then if so but not "
    "has have had do does did will would can could shall should may might into onto upon about"
)
FUNCTION = frozenset(_FUNCTION.split())
"""Words that rarely carry an accent."""

MEANING = {}
for _meaning, _words in WORDS.items():
    for _word in _words.split():
        MEANING.setdefault(_word, _meaning)


def meaning(word: str) -> str | None:
    """The meaning of a word in lower case, or None."""
    return MEANING.get(word)
