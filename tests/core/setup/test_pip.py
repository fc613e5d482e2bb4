"""What pip says, told to people."""

import pytest
from s2ag.core.setup import pip


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("ERROR: Could not install packages due to an OSError: [Errno 28] No space left on device", "disk is full"),
        ("ERROR: Could not install packages due to an OSError: [Errno 13] Permission denied: '/opt/x'", "written"),
        ("WARNING: Retrying after connection broken by 'NewConnectionError(Temporary failure in name resolution)'", "reached"),
        ("Could not fetch URL: SSLError(SSLCertVerificationError(1, '[SSL: CERTIFICATE_VERIFY_FAILED]'))", "certificate"),
        ("ERROR: No matching distribution found for torch<2.14,>=2.4", "no torch<2.14,>=2.4"),
        ("ERROR: No matching distribution found for torch==2.13.0+cpu", "without CUDA cannot be had"),
        ("ERROR: Wheel 'av' located at /x/av-99.0-py3-none-any.whl is invalid.", "damaged"),
        ("ERROR: ResolutionImpossible: for help visit the documentation", "fit together"),
        ("ERROR: something nobody thought of", "something nobody thought of"),
    ],
)
def test_what_pip_says_becomes_one_sentence_and_a_remedy(line, message):
    told, remedy = pip.explain(["Collecting torch", line], "the package registry")
    assert message in told and remedy.endswith(".")


_LOST = "WARNING: Retrying (Retry(total=1)) after connection broken by 'NewConnectionError(Name or service not known)': {}"


@pytest.mark.parametrize(
    ("places", "message"),
    [
        (["/whl/cpu/torch/", "/whl/cpu/numpy/"], "PyTorch's own package index cannot be reached"),
        (["/simple/numpy/", "/whl/cpu/torch/"], "The package registry cannot be reached"),
    ],
)
def test_the_index_that_cannot_be_reached_is_named(places, message):
    told, remedy = pip.explain([*map(_LOST.format, places), "ERROR: No matching distribution found for torch"], "the registry")
    assert message in told and ("its own index" in remedy) == ("own" in message)


def test_stages_follow_pip():
    heard = pip.Listener()
    heard.hear("Collecting torch<2.14,>=2.4")
    heard.hear("  Downloading torch-2.13.0-cp311-cp311-manylinux_2_28_x86_64.whl (196.0 MB)")
    assert (heard.stage.format(**heard.names), heard.size) == ("Fetch torch 2.13.0", 196e6)
    heard.hear("  Downloading numpy-2.4.6-cp311-cp311-manylinux.whl.metadata (60 kB)")
    assert heard.names == {"package": "torch 2.13.0"}
    heard.hear("Installing collected packages: mpmath, torch")
    assert heard.stage == "Install packages" and heard.packages == ["mpmath", "torch"]
