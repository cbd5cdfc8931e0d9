"""The queue from which threads take the cases of a batch: the number of the next one, and whether all are to stop."""

from typing import Any

from llvmlite import ir
from numba import extending, types
from numba.np.arrayobj import make_array

intrinsic: Any = extending.intrinsic


@intrinsic
def take(typing, queue):
    """The number of the next case, which is one more afterwards, whoever else takes one at the same time."""

    def generate(context, builder, signature, arguments):
        place = make_array(signature.args[0])(context, builder, arguments[0]).data
        return builder.atomic_rmw("add", place, ir.Constant(ir.IntType(64), 1), "monotonic")

    return types.int64(queue), generate
