#!/usr/bin/env python3
"""Does anything grow while the system runs? A day of play in lock-step without pictures, or half an hour of world, physics
and two graphics servers in real time, recorded, with a headset on the runtime for tests; watched from outside: memory,
descriptors, threads, clock, latency, pictures, overruns, what is recorded. A table with a verdict for each, exit 1 where
something grew; samples as CSV in --out, to be plotted.
    tests/soak.py lockstep SOAK-PROGRAM [--seconds 86400]
    tests/soak.py realtime PALPATE [--seconds 1800] [--headset-runtime openxr_test.json]"""
import argparse
import contextlib
import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from soak_judge import judge

HERE = os.path.dirname(os.path.abspath(__file__))
TICK = os.sysconf("SC_CLK_TCK")
# Figures of one kind grow where they grow by more than this.
MARGINS = {"memory": 1.0, "descriptors": 0.5, "threads": 0.5, "clock": 30.0, "latency": 30.0, "overruns": 30.0, "cpu": 5.0,
           "pictures": 5.0, "disk": 50.0}
UNITS = {"memory": "MiB", "descriptors": "", "threads": "", "clock": "us", "latency": "us", "overruns": "/min", "cpu": "ms/s",
         "pictures": "ms", "disk": "kB/s"}
SECONDS = {"lockstep": 86400.0, "realtime": 1800.0}
DISK_LEFT = 2**30  # bytes that recordings leave to others


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
        user, nice, system, _idle, _wait, irq, softirq, stolen = map(int, file.readline().split()[1:9])
    return (user + nice + system + irq + softirq + stolen) / TICK


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
    step = min(15.0, max(0.25, options.seconds / 240))
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
    """World, physics, two graphics servers, an observer and a second link, each with a log of its own. Physics and the first
    graphics server record; that one has the scripted player and, given a runtime, a headset."""
    RECORDING = ("physics", "graphics")

    def __init__(self, options, root, stack):
        self.program, self.root, self.out, self.headset = options.program, root, options.out, bool(options.headset_runtime)
        self.environment = {**os.environ, "XDG_RUNTIME_DIR": os.path.join(root, "run"), "XDG_CONFIG_HOME": os.path.join(root, "config")}
        if self.headset:
            self.environment["XR_RUNTIME_JSON"] = options.headset_runtime
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

    def start_server(self, name, words, ready, *options):
        recorded = ("--record", name + ".mcap", "--json", name + ".json") if name in self.RECORDING else ()
        self.start(name, [self.program, *words, "--rig", "rig.toml", *recorded, *options], ready)

    def start_all(self):
        sys.path.insert(0, os.path.join(HERE, "program"))
        os.environ.setdefault("PALPATE", self.program)
        from laboratory import READY, calibrate  # reads PALPATE
        calibrate(self.run)
        self.start("world", [self.program, "world", "run"], READY["world"])
        self.start_server("physics", ["physics"], READY["physics"])
        self.start_server("graphics", ["graphics"], READY["graphics"], "--player", "--disguise-offset-s", "12.5", "--disguise-drift-ppm", "40",
                          "--out", self.out, *(("--headset",) if self.headset else ()))
        self.start_server("second graphics", ["graphics"], READY["graphics"], "--disguise-offset-s", "-3", "--disguise-drift-ppm", "-25",
                          "--out", os.path.join(self.out, "second"))
        self.start("a second link", [self.program, "status", "--interval-s", "0.5"])
        self.start("an observer", ["/usr/bin/python3", os.path.join(HERE, "..", "examples", "watch.py"),
                                   f"ipc://{self.environment['XDG_RUNTIME_DIR']}/palpate/physics.sock", "1000000000"])

    def all_run(self):
        for name, process in self.running.items():
            if process.poll() is not None:
                raise Failed(f"{name} has ended with exit {process.returncode}: {self.log(name).strip()[-400:]}")

    def recorded_bytes(self, name):
        return os.path.getsize(os.path.join(self.root, name + ".mcap"))

    def stop(self):
        """The figures of those that record."""
        for name in ("graphics", "second graphics", "a second link", "physics", "world"):  # the observer would wait for states to the end
            self.running[name].send_signal(signal.SIGTERM)
            if (code := self.running[name].wait(60)) != 0:
                raise Failed(f"{name} ended with exit {code}: {self.log(name).strip()[-400:]}")
        figures = {}
        for name in self.RECORDING:
            with open(os.path.join(self.root, name + ".json"), encoding="utf-8") as file:
                figures[name] = json.load(file)
        return figures


class Looks:
    """What is seen of a running laboratory: of each process at every look, of loops, recordings and the machine at every fifth."""

    def __init__(self, laboratory):
        self.laboratory = laboratory
        self.watched = [Watched(name, process.pid) for name, process in laboratory.running.items()]
        self.overruns = {name: Series("overruns", f"overruns of {name} loop") for name in ("haptic", "physics")}
        self.recorded = {name: Series("disk", f"recorded by {name}") for name in laboratory.RECORDING}
        self.others = Series("cpu", "cores used by others")
        self.counted, self.before = None, None

    def series(self):
        return [series for one in self.watched for series in one.series] + [*self.overruns.values(), *self.recorded.values()]

    def look(self, at):
        self.laboratory.all_run()
        for one in self.watched:
            one.look(at)

    def look_further(self, at):
        if shutil.disk_usage(self.laboratory.root).free < DISK_LEFT:
            raise Failed(f"the disk is full but for {DISK_LEFT >> 20} MiB after {at:.0f} s")
        now = (time.monotonic(), machine_cpu_s(), sum(one.cpu_s() for one in self.watched),
               {name: self.laboratory.recorded_bytes(name) for name in self.recorded})
        self.look_at_loops(at)
        if self.before is not None:
            passed = now[0] - self.before[0]
            self.others.add(at, max(0.0, ((now[1] - self.before[1]) - (now[2] - self.before[2])) / passed))
            for name, series in self.recorded.items():
                series.add(at, 1e-3 * (now[3][name] - self.before[3][name]) / passed)
        self.before = now

    def look_at_loops(self, at):
        """Each time one more client that comes and goes."""
        status = json.loads(self.laboratory.run("status", "--json", "-"))
        uptime, counts = status["uptime_s"], {loop["name"]: loop["overruns"] for loop in status["loops"]}
        if self.counted is not None and uptime > self.counted[0]:
            for name, count in counts.items():
                self.overruns[name].add(at, 60 * (count - self.counted[1][name]) / (uptime - self.counted[0]))
        if self.counted is None or uptime != self.counted[0]:
            self.counted = (uptime, counts)


def column(path, name, series, value=float):
    with open(path, encoding="ascii") as file:
        for row in csv.DictReader(file):
            if row[name]:
                series.add(float(row["time_s"]), value(row[name]))


def drawn(folder, of=""):
    """What a graphics server wrote of its pictures: round trips, clock, and the time between pictures."""
    trips, pictures = Series("latency", "round trip" + of), Series("pictures", "between pictures" + of)
    errors, stated = Series("clock", "clock error" + of), Series("clock", "clock uncertainty" + of)
    frames, sync = (os.path.join(folder, f"realtime_{name}.csv") for name in ("frames", "sync"))
    column(frames, "round_trip_us", trips)
    times = Series("pictures", "")
    column(frames, "time_s", times)
    for before, at in zip(times.times, times.times[1:]):
        pictures.add(at, 1e3 * (at - before))
    column(sync, "offset_error_us", errors, lambda text: abs(float(text)))
    column(sync, "uncertainty_us", stated)
    if not trips.times:
        raise Failed(f"no frame was drawn with a reply{of}")
    return [trips, pictures, errors, stated]


def tell_recordings(figures):
    """How many messages were lost."""
    lost = 0
    for name, told in figures.items():
        recording = told["recording"]
        missing = sum(recording["dropped"].values()) + recording.get("missed", 0)
        print(f"{name} recorded {recording['bytes'] / 2**20:.0f} MiB, {recording['messages']} messages, {missing} lost")
        lost += missing
    return lost


def tell_headset(headset, seconds):
    """How many times the runtime was lost; once as well where no picture was shown."""
    print(f"headset: {headset['frames'] / seconds:.1f} frames/s at a display of {headset['rate_hz']:.1f} Hz, {headset['pictures_shown'] / seconds:.1f} new pictures/s, "
          f"{headset['age_ms']['median']:.0f} ms old (p99 {headset['age_ms']['p99']:.0f}); the runtime was lost {headset['losses']} times")
    return headset["losses"] or int(headset["pictures_shown"] == 0)


def realtime(options):
    pause = min(1.0, max(0.1, options.seconds / 600))
    with contextlib.ExitStack() as stack:
        # Short, because a socket's path has at most 107 bytes.
        laboratory = Laboratory(options, stack.enter_context(tempfile.TemporaryDirectory(prefix="soak-", dir="/tmp")), stack)
        laboratory.start_all()
        looks = Looks(laboratory)
        begun = time.monotonic()
        count = 0
        while (at := time.monotonic() - begun) < options.seconds:
            looks.look(at)
            if count % 5 == 0:
                looks.look_further(at)
            count += 1
            time.sleep(max(0.0, count * pause - (time.monotonic() - begun)))
        figures = laboratory.stop()
    sampled = looks.series()
    write_samples(os.path.join(options.out, "realtime.csv"), sampled + [looks.others])
    first, second = drawn(options.out), drawn(os.path.join(options.out, "second"), ", second")
    print(f"{options.seconds:.0f} s in real time, {len(first[0].times)} frames with replies, {len(second[0].times)} of the second")
    bad = tell_recordings(figures)
    if laboratory.headset:
        bad += tell_headset(figures["graphics"]["headset"], options.seconds)
    return bad + table(sampled + first + second, min(120.0, options.seconds / 4), looks.others)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n    ")[0])
    parser.add_argument("part", choices=("lockstep", "realtime"))
    parser.add_argument("program")
    parser.add_argument("--seconds", type=float, help=f"default: {SECONDS['lockstep']:.0f} and {SECONDS['realtime']:.0f}")
    parser.add_argument("--headset-runtime", help="manifest of the OpenXR runtime for tests; without, nobody wears a headset")
    parser.add_argument("--out", default="soak", help="folder for the samples (default: %(default)s)")
    options = parser.parse_args()
    options.seconds = options.seconds or SECONDS[options.part]
    options.program, options.out = os.path.abspath(options.program), os.path.abspath(options.out)
    options.headset_runtime = options.headset_runtime and os.path.abspath(options.headset_runtime)
    os.makedirs(options.out, exist_ok=True)
    try:
        return 1 if {"lockstep": lockstep, "realtime": realtime}[options.part](options) else 0
    except Failed as failure:
        print(f"soak: {failure}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
