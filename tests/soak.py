#!/usr/bin/env python3
"""Does anything grow while the system runs? An hour of lock-step without pictures, or ten minutes of world, physics and
graphics in real time, watched from outside: memory, descriptors, threads, clock, latency, overruns. A table with a verdict
for each, exit 1 where something grew; samples as CSV in --out, to be plotted.
    tests/soak.py lockstep SOAK-PROGRAM [--seconds 3600]      tests/soak.py realtime PALPATE [--seconds 600]"""
import argparse
import contextlib
import csv
import json
import os
import signal
import subprocess
import sys
import tempfile
import time

from soak_judge import judge

HERE = os.path.dirname(os.path.abspath(__file__))
TICK = os.sysconf("SC_CLK_TCK")
# Figures of one kind grow where they grow by more than this.
MARGINS = {"memory": 1.0, "descriptors": 0.5, "threads": 0.5, "clock": 30.0, "latency": 30.0, "overruns": 30.0, "cpu": 5.0}
UNITS = {"memory": "MiB", "descriptors": "", "threads": "", "clock": "us", "latency": "us", "overruns": "/min", "cpu": "ms/s"}


class Failed(Exception):
    """The run itself went wrong: nothing to judge."""


class Series:
    """One figure over time; its kind says by how much it may grow."""

    def __init__(self, kind, name):
        self.kind, self.name, self.times, self.values = kind, name, [], []

    def add(self, at, value):
        self.times.append(at)
        self.values.append(value)

    def after(self, warm_up):
        kept = [(t, v) for t, v in zip(self.times, self.values) if t >= warm_up]
        return [t for t, _ in kept], [v for _, v in kept]


class Watched:
    """Memory, descriptors and threads of one process."""

    def __init__(self, name, pid):
        self.name, self.pid = name, pid
        self.series = [Series(kind, f"{kind} of {name}") for kind in ("memory", "descriptors", "threads")]

    def look(self, at):
        with open(f"/proc/{self.pid}/statm", encoding="ascii") as file:
            pages = int(file.read().split()[1])
        found = (pages * os.sysconf("SC_PAGE_SIZE") / 2**20, len(os.listdir(f"/proc/{self.pid}/fd")), len(os.listdir(f"/proc/{self.pid}/task")))
        for series, value in zip(self.series, found):
            series.add(at, value)

    def cpu_s(self):
        used = 0
        for thread in os.listdir(f"/proc/{self.pid}/task"):
            with contextlib.suppress(OSError), open(f"/proc/{self.pid}/task/{thread}/schedstat", encoding="ascii") as file:
                used += int(file.read().split()[0])
        return used * 1e-9


def machine_cpu_s():
    with open("/proc/stat", encoding="ascii") as file:
        user, nice, system, _idle, _wait, irq, softirq = map(int, file.readline().split()[1:8])
    return (user + nice + system + irq + softirq) / TICK


def table(every, warm_up, others=None):
    """Prints the verdicts; how many figures grew or could not be judged."""
    print(f"{'':34}{'first third':>12}{'last third':>12}{'may grow':>10}   verdict")
    bad = 0
    for series in every:
        verdict = judge(*series.after(warm_up), MARGINS[series.kind])
        if verdict is None:
            print(f"{series.name:34}{'':34}   not judged: {len(series.after(warm_up)[0])} samples")
            bad += 1
            continue
        higher = verdict.last - verdict.first > MARGINS[series.kind]
        word = f"GREW by {verdict.rise:.1f}" if verdict.grew else "up and down" if higher else "steady"
        bad += verdict.grew
        print(f"{series.name + (', ' if UNITS[series.kind] else '') + UNITS[series.kind]:34}{verdict.first:12.1f}{verdict.last:12.1f}{MARGINS[series.kind]:10.1f}   {word}")
    if others is not None and (load := judge(*others.after(warm_up), 0.25)) is not None:
        print(f"other programs used {load.first:.1f} cores in the first third, {load.last:.1f} in the last"
              + ("; times that grew may be theirs: run again on a quiet machine" if load.last - load.first > 0.25 else ""))
    print("something grew, or was not judged" if bad else f"nothing grew: {len(every)} figures, {every[0].times[-1] - warm_up:.0f} s after {warm_up:.0f} s of warm-up")
    return bad


def write_samples(path, every):
    """One table: what was sampled together stands in one row."""
    rows = {}
    for i, series in enumerate(every):
        for at, value in zip(series.times, series.values):
            rows.setdefault(at, [""] * len(every))[i] = f"{value:.6g}"
    with open(path, "w", encoding="ascii", newline="") as file:
        out = csv.writer(file)
        out.writerow(["time_s"] + [series.name.replace(" ", "_") for series in every])
        out.writerows([f"{at:.3f}"] + row for at, row in sorted(rows.items()))


def lockstep(options):
    step = max(0.25, options.seconds / 240)
    figures = [Series("clock", "clock error"), Series("clock", "clock uncertainty"), Series("latency", "round trip"), Series("cpu", "work per virtual second")]
    begun = time.monotonic()
    with subprocess.Popen([options.program, str(options.seconds), str(step)], stdout=subprocess.PIPE, text=True) as process:
        watched = Watched("the play", process.pid)
        rows = csv.DictReader(process.stdout)
        before = (0.0, watched.cpu_s())
        serves = 0
        for row in rows:
            at = float(row["time_s"])
            with contextlib.suppress(OSError):  # the last line may come from a process that has ended
                cpu = watched.cpu_s()
                watched.look(at)
                figures[3].add(at, 1e3 * (cpu - before[1]) / (at - before[0]))
                before = (at, cpu)
            for series, column in zip(figures, ("clock_error_us", "clock_uncertainty_us", "round_trip_us")):
                series.add(at, float(row[column]))
            serves = int(row["serves"])
    took = time.monotonic() - begun
    if process.returncode != 0 or not figures[0].times:
        raise Failed(f"{options.program} ended with exit {process.returncode} after {len(figures[0].times)} samples")
    every = watched.series + figures
    write_samples(os.path.join(options.out, "lockstep.csv"), every)
    print(f"{figures[0].times[-1]:.0f} s of play, {serves} serves, in {took:.0f} s: {figures[0].times[-1] / took:.1f} times as fast as real time")
    return table(every, min(60.0, options.seconds / 4))


class Laboratory:
    """World, physics, graphics with the scripted player, an observer and a second link, each with a log of its own."""

    def __init__(self, program, root, out, stack):
        self.program, self.root, self.out = program, root, out
        self.environment = {**os.environ, "XDG_RUNTIME_DIR": os.path.join(root, "run"), "XDG_CONFIG_HOME": os.path.join(root, "config")}
        os.mkdir(self.environment["XDG_RUNTIME_DIR"], 0o700)
        self.running = {}
        stack.callback(self.kill)

    def kill(self):
        for process in self.running.values():
            if process.poll() is None:
                process.kill()
            process.wait()

    def run(self, *arguments):
        done = subprocess.run([self.program, *arguments], cwd=self.root, env=self.environment, stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, timeout=240, check=False)
        if done.returncode != 0:
            self.all_run()  # whoever has ended is the better answer
            raise Failed(f"palpate {' '.join(arguments)}: {done.stderr.strip()}")
        return done.stdout

    def log(self, name):
        with open(os.path.join(self.root, name + ".log"), encoding="utf-8") as file:
            return file.read()

    def start(self, name, command, ready=None):
        with open(os.path.join(self.root, name + ".log"), "wb") as log:
            process = subprocess.Popen(command, cwd=self.root, env=self.environment, stdin=subprocess.DEVNULL,
                                       stdout=subprocess.DEVNULL, stderr=log)
        self.running[name] = process
        until = time.monotonic() + 60
        while ready and ready not in self.log(name):
            if process.poll() is not None or time.monotonic() > until:
                raise Failed(f"{name} does not say '{ready}': {self.log(name).strip()}")
            time.sleep(0.02)

    def start_all(self):
        sys.path.insert(0, os.path.join(HERE, "program"))
        os.environ.setdefault("PALPATE", self.program)
        from laboratory import READY, calibrate  # reads PALPATE
        calibrate(self.run)
        self.start("world", [self.program, "world", "run"], READY["world"])
        self.start("physics", [self.program, "physics", "--rig", "rig.toml"], READY["physics"])
        self.start("graphics", [self.program, "graphics", "--rig", "rig.toml", "--player", "--disguise-offset-s", "12.5",
                                "--disguise-drift-ppm", "40", "--out", self.out], READY["graphics"])
        self.start("a second link", [self.program, "status", "--interval-s", "0.5"])
        self.start("an observer", ["/usr/bin/python3", os.path.join(HERE, "..", "examples", "watch.py"),
                                   f"ipc://{self.environment['XDG_RUNTIME_DIR']}/palpate/physics.sock", "1000000000"])

    def all_run(self):
        for name, process in self.running.items():
            if process.poll() is not None:
                raise Failed(f"{name} has ended with exit {process.returncode}: {self.log(name).strip()[-400:]}")

    def stop(self):
        for name in ("graphics", "a second link", "physics", "world"):  # the observer would wait for states to the end
            self.running[name].send_signal(signal.SIGTERM)
            if (code := self.running[name].wait(60)) != 0:
                raise Failed(f"{name} ended with exit {code}: {self.log(name).strip()[-400:]}")


def column(path, name, series, value=float):
    with open(path, encoding="ascii") as file:
        for row in csv.DictReader(file):
            if row[name]:
                series.add(float(row["time_s"]), value(row[name]))


def realtime(options):
    pause = min(1.0, max(0.1, options.seconds / 600))
    with contextlib.ExitStack() as stack:
        # Short, because a socket's path has at most 107 bytes.
        laboratory = Laboratory(options.program, stack.enter_context(tempfile.TemporaryDirectory(prefix="soak-", dir="/tmp")), options.out, stack)
        laboratory.start_all()
        watched = [Watched(name, process.pid) for name, process in laboratory.running.items()]
        overruns = {name: Series("overruns", f"overruns of {name} loop") for name in ("haptic", "physics")}
        others = Series("cpu", "cores used by others")
        counted, counted_at, cpu_before = {}, None, None
        begun = time.monotonic()
        look = 0
        while (at := time.monotonic() - begun) < options.seconds:
            laboratory.all_run()
            for one in watched:
                one.look(at)
            if look % 5 == 0:  # each time one more client that comes and goes
                cpu = (time.monotonic() - begun, machine_cpu_s(), sum(one.cpu_s() for one in watched))
                status = json.loads(laboratory.run("status", "--json", "-"))
                if counted_at is not None and status["uptime_s"] > counted_at:
                    for loop in status["loops"]:
                        overruns[loop["name"]].add(at, 60 * (loop["overruns"] - counted[loop["name"]]) / (status["uptime_s"] - counted_at))
                if counted_at != status["uptime_s"]:
                    counted, counted_at = {loop["name"]: loop["overruns"] for loop in status["loops"]}, status["uptime_s"]
                if cpu_before is not None:
                    others.add(at, max(0.0, ((cpu[1] - cpu_before[1]) - (cpu[2] - cpu_before[2])) / (cpu[0] - cpu_before[0])))
                cpu_before = cpu
            look += 1
            time.sleep(max(0.0, look * pause - (time.monotonic() - begun)))
        laboratory.stop()
    trips, errors, stated = Series("latency", "round trip"), Series("clock", "clock error"), Series("clock", "clock uncertainty")
    frames, sync = (os.path.join(options.out, f"realtime_{name}.csv") for name in ("frames", "sync"))
    column(frames, "round_trip_us", trips)
    column(sync, "offset_error_us", errors, lambda text: abs(float(text)))
    column(sync, "uncertainty_us", stated)
    sampled = [series for one in watched for series in one.series] + list(overruns.values())
    write_samples(os.path.join(options.out, "realtime.csv"), sampled + [others])
    if not trips.times:
        raise Failed("no frame was drawn with a reply")
    print(f"{options.seconds:.0f} s in real time, {len(trips.times)} frames with replies, {len(errors.times) / options.seconds:.1f} Hz")
    return table(sampled + [trips, errors, stated], min(60.0, options.seconds / 4), others)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n    ")[0])
    parser.add_argument("part", choices=("lockstep", "realtime"))
    parser.add_argument("program")
    parser.add_argument("--seconds", type=float, help="default: 3600 and 600")
    parser.add_argument("--out", default="soak", help="folder for the samples (default: %(default)s)")
    options = parser.parse_args()
    options.seconds = options.seconds or {"lockstep": 3600.0, "realtime": 600.0}[options.part]
    options.program, options.out = os.path.abspath(options.program), os.path.abspath(options.out)
    os.makedirs(options.out, exist_ok=True)
    try:
        return 1 if {"lockstep": lockstep, "realtime": realtime}[options.part](options) else 0
    except Failed as failure:
        print(f"soak: {failure}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
