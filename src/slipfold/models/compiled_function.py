"""Functions compiled from expressions: soon there, for they are called seldom."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import heyoka as hy

from slipfold.models.output import Expression


def compiled_function(expressions: Iterable[Expression], symbols: Sequence[Expression]) -> Any:
    """Compile functions of symbols, for one place or, shape (n, m), for many at once.

    Little is optimised: that takes longer than what it would save in most programs, only
    integrators run long enough. One place at a time, so that what is found at it does not depend
    on how many others there are.
    """
    # heyoka's own disk cache is unchecked and shared by all programs: keep out of it.
    hy.llvm_state.set_diskcache_enabled(False)
    # At level 0, and without compact mode, sums and powers are rounded in another order.
    return hy.cfunc(
        list(expressions), vars=list(symbols), compact_mode=True, opt_level=1, batch_size=1
    )
