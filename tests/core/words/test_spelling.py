import pytest
from s2ag.core.words.spelling import cardinal, normalise, spoken_words


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("Hello,", "hello"),
        ("፩", "፩"),
        ("Don’t", "don't"),
        ("‘twas’", "twas"),
        ("well-known", "well known"),
        ("wait—what", "wait what"),
        ("and/or", "and or"),
        ("2", "two"),
        ("0", "zero"),
        ("-5", "minus five"),
        ("3.14", "three point one four"),
        ("1,250", "one thousand two hundred fifty"),
        ("1984", "nineteen eighty four"),
        ("1900", "nineteen hundred"),
        ("1905", "nineteen oh five"),
        ("2001", "two thousand one"),
        ("90s", "nineties"),
        ("1960s", "nineteen sixties"),
        ("21st", "twenty first"),
        ("12th", "twelfth"),
        ("30th", "thirtieth"),
        ("$1", "one dollar"),
        ("$3.50", "three point five zero dollars"),
        ("£20", "twenty pounds"),
        ("50%", "fifty percent"),
        ("&", "and"),
        ("B2B", "b two b"),
        ("U.S.", "u s"),
        ("café", "café"),
        ("—", ""),
        ("...", ""),
        ("", ""),
    ],
)
def test_spoken(written, said):
    assert spoken_words(written) == said.split()


def test_cardinals():
    assert " ".join(cardinal(999_999_999_999_999)).startswith("nine hundred ninety nine trillion")
    assert cardinal(10**15) == ["one"] + ["zero"] * 15
    assert cardinal(1_000_001) == ["one", "million", "one"]
    assert cardinal(100) == ["one", "hundred"]


@pytest.mark.parametrize(("word", "plain"), [("“Isn’t”", "isn't"), ("ＡＢＣ", "abc"), ("'em", "em"), ("--", ""), ("x_", "x")])
def test_normalise(word, plain):
    assert normalise(word) == plain
