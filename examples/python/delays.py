"""How old is a state when a program has it? Three ways to get one from a running session, side by side.

    python3 examples/python/delays.py [--address ADDRESS] [--count 300] [--bound-ms 5] [--out plot.png]

Start `palpate world run` and `palpate physics` first, or `palpate play`.
"""
import argparse
import time
from typing import Callable

import numpy as np
import numpy.typing as npt

import palpate


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--address", default="", help="of the physics server; without it this user's own")
    parser.add_argument("--count", type=int, default=300, help="states of each way")
    parser.add_argument("--bound-ms", type=float, default=5.0, help="the age that is to be kept")
    parser.add_argument("--out", help="write the picture to this file")
    options = parser.parse_args()

    with palpate.Client(options.address, role="observer", name="delays.py") as client:
        # The clocks are known better once some exchanges have been made.
        while not client.clock().settled:
            time.sleep(0.1)
        uncertainty = client.clock().uncertainty
        ages = {"state(), the newest asked for": measured(client, lambda: client.state().time, options.count)}
        watch = client.watch(200)
        ages["watch(200), as the server sends them"] = measured(client, lambda: next(watch).time, options.count)
        states = client.states(every=0.01)
        ages["states(every=0.01), a block's newest"] = measured(client, lambda: float(next(states).time[-1]), options.count)
        print(f"{client.application} at {client.address}; the server's clock is known to +- {1e3 * uncertainty:.3f} ms")
    for name, age in ages.items():
        print(f"  {name:<38} median {1e3 * np.median(age):6.2f} ms, 99 % within {1e3 * np.quantile(age, 0.99):6.2f} ms; "
              f"{100 * np.mean(age <= 1e-3 * options.bound_ms):.0f} % within {options.bound_ms:g} ms")
    if options.out:
        draw(ages, options.bound_ms, options.out)


def measured(client: palpate.Client, newest: Callable[[], float], count: int) -> npt.NDArray[np.float64]:
    ages = []
    for _ in range(count):
        state_time = newest()
        ages.append(client.clock().server_time(time.monotonic()) - state_time)
    return np.array(ages)


def draw(ages: dict[str, npt.NDArray[np.float64]], bound_ms: float, out: str) -> None:
    try:
        import matplotlib.pyplot as plt  # type: ignore[import]
    except ImportError:
        print("  no picture: matplotlib is not installed (python3-matplotlib)")
        return
    figure, axis = plt.subplots(figsize=(8, 5), constrained_layout=True)
    for name, age in ages.items():
        axis.step(1e3 * np.sort(age), np.arange(1, len(age) + 1) / len(age), label=name)
    axis.axvline(bound_ms, color="gray", linestyle=":")
    axis.set(xlabel="age of the state, ms", ylabel="share of the states", ylim=(0, 1))
    axis.legend()
    figure.savefig(out, dpi=120)


if __name__ == "__main__":
    main()
