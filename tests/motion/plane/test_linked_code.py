"""Functions that only compiled code calls have no machine code of their own."""

import numba

from shakedown.ground.code_cache import LinkedLibrary
from shakedown.ground.named_state import inner


@inner
def doubled(x):
    return 2.0 * x


@numba.njit
def one_more(x):
    return doubled(x) + 1.0


def test_inner_code_is_compiled_into_its_callers_alone():
    assert one_more(3.0) == 7.0
    (form,) = doubled.overloads.values()
    assert isinstance(form.library, LinkedLibrary)
    assert form.library.get_pointer_to_function(form.fndesc.llvm_func_name) == 0
    (whole,) = one_more.overloads.values()
    assert whole.library.get_pointer_to_function(whole.fndesc.llvm_func_name) != 0
