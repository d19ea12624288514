"""Seals: what was published binds what is opened."""

import copy
import hashlib
import json

import pytest
from made_truths import made_truth

from sstl_cli.blind import seal
from sstl_cli.blind.truth import CaseTruth
from sstl_cli.core.errors import SstlError

TRUTHS = {"case-0001": made_truth(effects=("viscous",)), "case-0002": made_truth()}


def sealed():
    return seal.seal(TRUTHS, "blind", [100, 101], False)


def test_hash_is_the_salted_sha256_of_the_truth():
    published, closed = sealed()
    plain = json.dumps(TRUTHS["case-0001"].document(), sort_keys=True, separators=(",", ":"))
    salt = closed["salts"]["case-0001"]
    assert published["cases"]["case-0001"] == hashlib.sha256(f"{salt}|{plain}".encode()).hexdigest()
    assert seal.verify(published, closed, "here").truths == TRUTHS


def test_published_document_holds_no_truth():
    published, _ = sealed()
    text = json.dumps(published)
    assert "viscous" not in text and "100" not in json.dumps(published["purpose"]) and "seeds" not in text


@pytest.mark.parametrize(
    "change",
    [
        lambda c: c["truths"]["case-0001"]["effects"].clear(),
        lambda c: c["truths"].pop("case-0002"),
        lambda c: c.update(seeds=[200, 201]),
        lambda c: c.update(purpose="calibration"),
        lambda c: c["salts"].update({"case-0001": "00"}),
    ],
)
def test_a_changed_truth_is_refused(change):
    published, closed = sealed()
    closed = copy.deepcopy(closed)
    change(closed)
    with pytest.raises(SstlError, match="E952"):
        seal.verify(published, closed, "here")


def test_sets_keep_to_their_purpose():
    opened = seal.Truth("blind", (1, 2), True, {})
    seal.require_purpose(opened, "blind", "here")
    with pytest.raises(SstlError, match="E953"):
        seal.require_purpose(opened, "calibration", "here")


@pytest.mark.parametrize(("ours", "theirs", "apart"), [([0, 9], [10, 19], True), ([0, 10], [10, 19], False)])
def test_overlapping_seeds_are_refused(ours, theirs, apart):
    if apart:
        seal.require_apart(ours, theirs, "here")
    else:
        with pytest.raises(SstlError, match="E954"):
            seal.require_apart(ours, theirs, "here")


def test_a_truth_without_what_every_set_says_is_refused():
    told = made_truth().document()
    old = {k: v for k, v in told.items() if k not in ("also", "attempt", "quick", "recording", "simulator")}
    assert CaseTruth.of(old) == made_truth() and "scale" not in told
    with pytest.raises(SstlError, match="no noise_n"):
        CaseTruth.of({k: v for k, v in told.items() if k != "noise_n"})
