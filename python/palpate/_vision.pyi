# The extension module over what needs OpenCV (python/bindings/vision.cpp).
from typing import Any, Sequence

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
View = tuple[str, Floats, Floats]

def camera(views: Sequence[View], width: int, height: int, reject_outlier_views: bool, not_found: Sequence[str],
           warnings: Sequence[str], lens: str) -> dict[str, Any]: ...
def read_corners(file: str, columns: int, rows: int, square: float) -> tuple[list[View], int, int, list[str], str]: ...
def find_corners(pattern: str, columns: int, rows: int, square: float,
                 half_window: int | None) -> tuple[list[View], int, int, list[str], str]: ...
