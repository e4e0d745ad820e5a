"""Whether a figure grows while a system runs: pure functions on samples, for soak.py and its tests.

A series is cut into blocks of equal length in time, of which the medians count: what happens now and then does not.
It grows where both hold: the median of its last third lies above that of its first by more than the figure's margin, and
a straight line through the blocks rises with more certainty than chance gives. One step up, with nothing before or after
it, is no growth: neighbouring blocks then err from the line together, which takes certainty away."""
import math
from statistics import median

BLOCKS = 12
CERTAIN = 4.0  # standard errors by which the line has to rise


class Verdict:
    """first, last: medians of the first and last third; rise: of the line over the whole time; certainty: in standard errors."""

    def __init__(self, first, last, rise, certainty, grew):
        self.first, self.last, self.rise, self.certainty, self.grew = first, last, rise, certainty, grew


def blocks(times, values):
    """The middles in time and the medians of the blocks that hold samples."""
    begin, end = times[0], times[-1]
    length = (end - begin) / BLOCKS
    held = [[] for _ in range(BLOCKS)]
    for time, value in zip(times, values):
        held[min(BLOCKS - 1, int((time - begin) / length))].append(value)
    return ([begin + (i + 0.5) * length for i, some in enumerate(held) if some], [median(some) for some in held if some])


def line(times, values):
    """Slope of the least-squares line and its standard error, that of errors which follow their neighbours."""
    n = len(times)
    middle_t, middle_v = sum(times) / n, sum(values) / n
    spread = sum((t - middle_t) ** 2 for t in times)
    slope = sum((t - middle_t) * (v - middle_v) for t, v in zip(times, values)) / spread
    errors = [v - middle_v - slope * (t - middle_t) for t, v in zip(times, values)]
    squares = sum(e * e for e in errors)
    together = sum(a * b for a, b in zip(errors, errors[1:])) / squares if squares > 0 else 0.0
    together = min(max(together, 0.0), 0.9)
    return slope, math.sqrt(squares / (n - 2) / spread * (1 + together) / (1 - together))


def judge(times, values, margin):
    """None where there is too little to judge: fewer than three samples a block."""
    if len(times) < 3 * BLOCKS or times[-1] <= times[0]:
        return None
    middles, medians = blocks(times, values)
    third = (times[-1] - times[0]) / 3
    first = median(v for t, v in zip(times, values) if t <= times[0] + third)
    last = median(v for t, v in zip(times, values) if t >= times[-1] - third)
    slope, error = line(middles, medians)
    rise = slope * (times[-1] - times[0])
    certainty = slope / error if error > 1e-12 * abs(slope) else math.copysign(math.inf, slope) if slope else 0.0
    return Verdict(first, last, rise, certainty, last - first > margin and rise > margin and certainty > CERTAIN)
