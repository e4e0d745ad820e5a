"""What a running session's world does: the carried body and the force five times a second, and a picture of every step.

    python3 examples/python/watch.py [--address ADDRESS] [--seconds 5] [--out plot.png]

Start `palpate world run` and `palpate physics` first, or `palpate play`.
"""
import argparse

import numpy as np

import palpate

CARRIED = 1  # the body that the stylus carries


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--address", default="", help="of the physics server; without it this user's own")
    parser.add_argument("--seconds", type=float, default=5.0, help="how long to watch")
    parser.add_argument("--out", help="write the picture to this file")
    options = parser.parse_args()

    blocks: list[palpate.StateBlock] = []
    with palpate.Client(options.address, role="observer", name="watch.py") as client:
        print(f"{client.application}: {', '.join(body.name or 'a body' for body in client.bodies)}")
        for block in client.states(every=0.2):
            blocks.append(block)
            x, y, z = block.positions[-1, CARRIED]
            strongest = np.linalg.norm(block.force, axis=1).max()
            gap = f", {block.missed} missed" if block.missed else ""
            passed = block.time[-1] - blocks[0].time[0]
            print(f"{passed:6.2f} s  at ({x:+.3f} {y:+.3f} {z:+.3f}) m  up to {strongest:5.2f} N  {len(block)} steps{gap}")
            if passed >= options.seconds:
                break
    if options.out:
        draw(blocks, options.out)


def draw(blocks: list[palpate.StateBlock], out: str) -> None:
    try:
        import matplotlib.pyplot as plt  # type: ignore[import]
    except ImportError:
        print("no picture: matplotlib is not installed (python3-matplotlib)")
        return
    time = np.concatenate([block.time for block in blocks]) - blocks[0].time[0]
    places = np.concatenate([block.positions[:, CARRIED] for block in blocks])
    forces = np.linalg.norm(np.concatenate([block.force for block in blocks]), axis=1)
    figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(9, 6), constrained_layout=True)
    for axis, name in enumerate("xyz"):
        above.plot(time, places[:, axis] - places[0, axis], label=name)
    above.set(ylabel="carried body, m from its first place")
    above.legend()
    below.plot(time, forces, color="tab:red")
    below.set(xlabel="s", ylabel="force on the hand, N")
    figure.savefig(out, dpi=120)


if __name__ == "__main__":
    main()
