"""Arguments looked at before they reach the library: shape, type and unit, refused in words that name the argument.

Everything is SI and radians. Nothing here changes what it is given: what comes back is a copy, float64 in C order.
"""
from __future__ import annotations

from typing import Any, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

# Nothing that is calibrated lies further away, or has turned further: a mistaken unit.
FARTHEST = 100.0  # m
MOST_TURNS = 4.0 * np.pi  # rad
LATEST = 1e11  # s


def numbers(value: Any, name: str, expected: str) -> Floats:
    """Any array of finite numbers; `expected` says its shape and unit in words."""
    if value is None:
        raise TypeError(f"{name} is None; {expected} is expected")
    for attribute in ("unit", "units"):
        if type(value) not in (np.ndarray, list, tuple) and hasattr(value, attribute):
            raise TypeError(f"{name} has a unit of its own ({getattr(value, attribute)}); {expected}, as plain numbers, is expected")
    try:
        array = np.asarray(value)
    except ValueError:
        raise ValueError(f"{name} is no array, its rows are of unlike length; {expected} is expected") from None
    if array.dtype == object:
        raise ValueError(f"{name} holds things that are no numbers; {expected} is expected")
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name} is of the type {array.dtype}; {expected} is expected")
    array = np.array(array, dtype=np.float64, order="C")
    if not np.all(np.isfinite(array)):
        place = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise ValueError(f"{name}{list(place)} is {array[place]}; finite numbers are expected, leave such rows out")
    return array


def shaped(value: Any, name: str, shape: Sequence[Union[int, str]], unit: str) -> Floats:
    """An array of that shape, in which a letter stands for any number above 0."""
    text = "(" + ", ".join(str(part) for part in shape) + ("," if len(shape) == 1 else "") + ")"
    expected = f"an array of the shape {text}, {unit},"
    array = numbers(value, name, expected)
    fits = array.ndim == len(shape) and all(
        given > 0 if isinstance(wanted, str) else given == wanted for given, wanted in zip(array.shape, shape))
    if not fits:
        raise ValueError(f"{name} has the shape {array.shape}; {expected} is expected")
    return array


def points(value: Any, name: str) -> Floats:
    array = shaped(value, name, ("N", 3), "metres")
    near(array, name)
    return array


def point(value: Any, name: str) -> Optional[Floats]:
    if value is None:
        return None
    array = shaped(value, name, (3,), "metres")
    near(array, name)
    return array


def near(array: Floats, name: str) -> None:
    """Metres that are millimetres."""
    largest = float(np.max(np.abs(array)))
    if largest > FARTHEST:
        raise ValueError(f"{name} goes up to {largest:.6g}; metres are expected, at most {FARTHEST:g}: are these millimetres?")


def angles(value: Any, name: str, columns: Union[int, str]) -> Floats:
    array = shaped(value, name, ("N", columns), "radians")
    largest = float(np.max(np.abs(array)))
    if largest > MOST_TURNS:
        raise ValueError(f"{name} goes up to {largest:.6g}; radians are expected, at most two turns: are these degrees?")
    return array


def times(value: Any, name: str, count: int, of: str) -> Floats:
    """`of` names the argument whose rows the times belong to."""
    if hasattr(value, "dtype") and getattr(value.dtype, "kind", "") in "mM":
        raise TypeError(f"{name} is of the type {value.dtype}; seconds as plain numbers are expected")
    array = shaped(value, name, ("N",), "seconds")
    same_length(array, name, count, of)
    largest = float(np.max(np.abs(array)))
    if largest > LATEST:
        raise ValueError(f"{name} goes up to {largest:.6g}; seconds are expected: are these milli- or nanoseconds?")
    return array


def same_length(array: npt.NDArray[Any], name: str, count: int, of: str) -> None:
    if len(array) != count:
        raise ValueError(f"{name} has {len(array)} entries, {of} has {count}; as many are expected")


def whole(value: Any, name: str, count: int, of: str, low: int, high: int) -> Integers:
    array = np.asarray(value)
    if array.dtype.kind not in "iu":
        raise TypeError(f"{name} is of the type {array.dtype}; whole numbers from {low} to {high} are expected")
    if array.ndim != 1:
        raise ValueError(f"{name} has the shape {array.shape}; a list of whole numbers is expected")
    same_length(array, name, count, of)
    for i, entry in enumerate(array):
        if not low <= entry <= high:
            raise ValueError(f"{name}[{i}] is {entry}; {low} to {high} is expected")
    return np.array(array, dtype=np.int64)


def number(value: Any, name: str, unit: str, above: Optional[float] = None) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise TypeError(f"{name} is {value!r}; a number, {unit}, is expected")
    result = float(value)
    if not np.isfinite(result) or (above is not None and not result > above):
        raise ValueError(f"{name} is {result:g}; a finite number, {unit}{f', above {above:g}' if above is not None else ''}, is expected")
    return result


def one_of(value: Any, name: str, words: Sequence[str]) -> str:
    if not isinstance(value, str) or value not in words:
        raise ValueError(f"{name} is {value!r}; one of {', '.join(words)} is expected")
    return value


def labels(value: Any, name: str, count: int, of: str) -> list[str]:
    if isinstance(value, (str, bytes)):
        raise TypeError(f"{name} is one text, {value!r}; a list with a label for each row of {of} is expected")
    texts = [str(entry) for entry in value]
    if len(texts) != count:
        raise ValueError(f"{name} has {len(texts)} entries, {of} has {count}; as many are expected")
    return texts


def path_text(value: Any, name: str = "path") -> str:
    import os
    if not isinstance(value, (str, os.PathLike)):
        raise TypeError(f"{name} is {value!r}; the name of a file is expected")
    text = os.fspath(value)
    if not isinstance(text, str):
        raise TypeError(f"{name} is {value!r}; a text is expected")
    return text


def read_only(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    array.flags.writeable = False
    return array


def seed_number(value: Any, name: str = "seed") -> int:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 0 <= int(value) < 10**19:
        raise ValueError(f"{name} is {value!r}; a whole number from 0 on, of at most 19 digits, is expected")
    return int(value)


def whole_number(value: Any, name: str, low: int, high: int) -> int:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise TypeError(f"{name} is {value!r}; a whole number from {low} to {high} is expected")
    if not low <= int(value) <= high:
        raise ValueError(f"{name} is {value}; {low} to {high} is expected")
    return int(value)


def above_zero(value: Any, name: str) -> Floats:
    """A list of numbers above 0, in any unit: stimuli, quantities that are compared."""
    array = shaped(value, name, ("N",), "above 0")
    if np.min(array) <= 0.0:
        raise ValueError(f"{name} goes down to {np.min(array):g}; numbers above 0 are expected")
    return array
