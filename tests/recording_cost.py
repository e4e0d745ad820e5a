#!/usr/bin/env python3
"""scripts/recording-cost: haptic lateness (p99.9) of a physics server that records beside one that does not, in pairs."""
import csv
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "program"))
from laboratory import calibrate  # noqa: E402

QUANTILE = 0.999


def quantile(rows, share):
    """Of a histogram in half octaves, between whose bounds it is drawn by logarithms."""
    left = share * sum(int(row["ticks"]) for row in rows)
    for row in rows:
        ticks = int(row["ticks"])
        if left <= ticks:
            low, high = max(float(row["late_from_us"]), 0.1), float(row["late_to_us"])
            return math.exp(math.log(low) + (math.log(high) - math.log(low)) * left / ticks)
        left -= ticks
    raise AssertionError("a histogram without ticks")


class Machine:
    def __init__(self, program, folder, seconds):
        self.program, self.folder, self.seconds = program, folder, seconds
        meeting = os.path.join(folder, "run")
        os.mkdir(meeting, 0o700)
        self.environment = {**os.environ, "XDG_RUNTIME_DIR": meeting}

    def runs(self, *arguments, **more):
        subprocess.run([self.program, *map(str, arguments)], cwd=self.folder, env=self.environment, check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL, **more)

    def lateness(self, number, recording):
        out = f"out{number}"
        options = ("--record", f"{out}.mcap") if recording else ()
        self.runs("physics", "--rig", "rig.toml", "--app", "touch", "--seconds", self.seconds, "--out", out, "--json", f"{out}.json", *options)
        with open(os.path.join(self.folder, out, "realtime_jitter.csv"), encoding="utf-8") as file:
            rows = [row for row in csv.DictReader(file) if row["loop"] == "haptic"]
        with open(os.path.join(self.folder, f"{out}.json"), encoding="utf-8") as file:
            figures = json.load(file)
        if recording:
            lost = figures["recording"]["missed"] + sum(figures["recording"]["dropped"].values())
            assert lost == 0, figures["recording"]
            os.remove(os.path.join(self.folder, f"{out}.mcap"))
        return quantile(rows, QUANTILE)


def main():
    program, pairs, seconds = os.path.abspath(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
    with tempfile.TemporaryDirectory() as folder:
        machine = Machine(program, folder, seconds)
        calibrate(machine.runs)
        world = subprocess.Popen([program, "world", "run", "--arm-only"], cwd=folder, env=machine.environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                 text=True)
        try:
            world.stderr.readline()  # its devices are open
            with_it, without, again = [], [], []
            for pair in range(pairs):
                # The order changes, so that what changes on the machine by and by favours nobody.
                order = [(without, False), (with_it, True), (again, False)]
                for k, (found, recording) in enumerate(order if pair % 2 == 0 else reversed(order)):
                    found.append(machine.lateness(3 * pair + k, recording))
                print(f"pair {pair + 1:3}: without {without[-1]:7.1f}  with {with_it[-1]:7.1f}  without {again[-1]:7.1f} us", flush=True)
        finally:
            world.terminate()
            world.wait()
    plain = [a / b for a, b in zip(again, without)]
    cost = [a / math.sqrt(b * c) for a, b, c in zip(with_it, without, again)]
    for name, ratios in (("with / without", cost), ("without / without", plain)):
        low, _, high = statistics.quantiles(ratios, n=4)
        print(f"{name:18} median {statistics.median(ratios):.2f}, quartiles {low:.2f} to {high:.2f}, {min(ratios):.2f} to {max(ratios):.2f} in all")


if __name__ == "__main__":
    main()
