"""What a refused command leaves: one sentence, and no file."""


def one_sentence(err, out=""):
    lines = [line for line in err.splitlines() if not line.startswith("s2ag: note: ")]
    assert len(lines) == 1, err
    assert lines[0].startswith("s2ag: ")
    assert lines[0].endswith((".", "--help"))
    assert not out
    return lines[0]


def files(folder):
    return sorted(path.name for path in folder.iterdir())
