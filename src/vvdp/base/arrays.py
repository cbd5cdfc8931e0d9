"""Names of the arrays that values come in."""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Mask: TypeAlias = NDArray[np.bool_]
Rows: TypeAlias = np.ndarray[Any, np.dtype[np.intp]]
"""Places in an array."""
