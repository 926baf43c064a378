"""States that lie in Python's memory: what compiled code writes Python sees, and the other way round."""

import gc

import numpy as np
import pytest

from shakedown.ground.named_state import Flags, Hash, NamedState, Reals, entered


class Part(NamedState):
    """A state within another."""

    size: int
    values: Reals


class Whole(NamedState):
    """Every kind of field."""

    known: bool
    share: float
    code: Hash
    seen: Flags
    part: Part


@entered
def work(whole):
    part = whole.part
    for k in range(part.size):
        part.values[k] = 2.0 * part.values[k] + whole.share
        whole.seen[k] = 1
    whole.share, whole.known, whole.code = 7, not whole.known, whole.code - np.uint64(1)
    part.size += 1


def test_both_sides_read_and_write_the_same():
    values = np.arange(3.0)
    whole = Whole({"seen": 3}, part=Part({}, values=values))
    whole.part.set(size=2)
    whole.set(share=0.5, code=2**64 - 1)
    work(whole)
    assert (whole.share, whole.known, whole.code, whole.part.size) == (7.0, True, 2**64 - 2, 3)
    assert values.tolist() == [0.5, 2.5, 2.0]
    assert whole.seen.tolist() == [1, 1, 0]


def test_a_state_with_other_parts_keeps_the_rest():
    whole = Whole({"seen": 1}, part=Part({"values": 1}))
    other = whole.with_parts(part=Part({"values": 2}))
    del whole
    gc.collect(0)
    other.part.set(size=1)
    work(other)
    assert other.seen.tolist() == [1]
    with pytest.raises(AssertionError):
        other.hold(seen=np.zeros(2))
