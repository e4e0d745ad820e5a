#!/usr/bin/env python3
"""Each value of a world file in turn replaced by what is none: refused in one line that names it, or taken. With WORLD_VALUES=run all of them, and the
laboratory runs for a moment with what is taken (scripts/long worlds); without, some of most."""
import os
import resource
import subprocess
import sys
import tomllib
import unittest
from concurrent.futures import ThreadPoolExecutor

from odd_files_test import CONTROLS
from program import PROGRAM, ProgramTest

ODD = ("0", "-1", "1", "1e308", "-1e308", "1e-308", "nan", "inf", "-inf", "1000000000000000000", "9223372036854775807", "-9223372036854775808", "1e9", "-1e9", "0.5",
       '"nan"', '""', "[]", "{}", "true", "1979-05-27", "[[]]", "[" + "0," * 1000000 + "]")
NO_NUMBERS = ("nan", "inf", "-inf")  # never taken
LONGEST_S = 120.0  # what takes two seconds, under sanitizers and on a busy machine
MEMORY_KB = 3_000_000
# What uses a world, beside the laboratory itself: of these sections a kind of sample, with so many of it.
SAMPLES = {"camera": ("camera", "2"), "arm": ("arm", "3"), "hand": ("arm", "3")}


def leaves(table, path=()):
    """Each value with the path to it; of lists the whole, the first part and the last."""
    for key, value in table.items() if isinstance(table, dict) else sorted({0: table[0], len(table) - 1: table[-1]}.items()):
        yield (*path, key), value
        if isinstance(value, (dict, list)):
            yield from leaves(value, (*path, key))


def text_of(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f'"{key}" = {text_of(part)}' for key, part in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(text_of, value)) + "]"
    if isinstance(value, str):
        return value[1:] if value.startswith("\0") else '"' + value + '"'  # as it is to stand in the file
    return str(value).lower() if isinstance(value, bool) else repr(value)


def replaced(world, path, value):
    """The world's text with this text in place of one value."""
    if not path:
        return "\0" + value
    if isinstance(world, dict):
        return {key: replaced(part, path[1:], value) if key == path[0] else part for key, part in world.items()}
    return [replaced(part, path[1:], value) if key == path[0] else part for key, part in enumerate(world)]


def as_file(world):
    return "".join(f"[{section}]\n" + "".join(f"{key} = {text_of(value)}\n" for key, value in table.items()) for section, table in world.items())


class WorldValues(ProgramTest):
    def answer(self, folder, *command):
        return subprocess.run([PROGRAM, *command], stdin=subprocess.DEVNULL, capture_output=True, timeout=LONGEST_S, check=False,
                              cwd=folder, env={**self.environment, "XDG_RUNTIME_DIR": folder})

    def attempt(self, number, world, path, value, runs):
        """What is wrong with how the program takes it; None: nothing."""
        folder = self.path(str(number % 8))
        os.makedirs(folder, 0o700, exist_ok=True)
        file = os.path.join(folder, f"{number}.toml")
        name = ".".join(str(key) for key in path if isinstance(key, str))
        what = f"{name} {path[len(name.split('.')):]} = {value[:30]}"
        with open(file, "w", encoding="utf-8") as out:
            out.write(as_file(replaced(world, path, value)))
        try:
            commands = [["world", "show", file]]
            if runs:
                commands.append(["world", "run", "--seconds", "0.2", "--name", f"n{number}", "--world", file])
            if runs and path[0] in SAMPLES:
                kind, count = SAMPLES[path[0]]
                commands.append(["world", "sample", kind, "--points", count, "--world", file, "--out", os.path.join(folder, f"out{number}")])
            for command in commands:
                try:
                    done = self.answer(folder, *command)
                except subprocess.TimeoutExpired:
                    return f"{what}: {command} takes more than {LONGEST_S} s"
                error = done.stderr.decode()
                if done.returncode not in (0, 1, 2) or "ERROR: AddressSanitizer" in error or "runtime error" in error:
                    return f"{what}: {command} ends with {done.returncode}: {error[-1500:]}"
                if command[1] == "show" and done.returncode:
                    lines = error.splitlines()
                    last = next((key for key in reversed(path) if isinstance(key, str)))
                    if len(lines) != 1 or last not in lines[0] and path[0] not in lines[0] or len(lines[0]) > 1000 or CONTROLS & set(map(ord, lines[0])):
                        return f"{what}: refused with {lines}"
                    return None
                if command[1] == "show" and value in NO_NUMBERS:
                    return f"{what}: taken"
                if done.returncode and len([line for line in error.splitlines() if "are open" not in line]) != 1:
                    return f"{what}: {command} ends with {done.returncode}: {error[:500]}"
        finally:
            os.unlink(file)
        return None

    def test_each_value_in_turn(self):
        world = tomllib.loads(self.runs("world", "show").out)
        runs = os.environ.get("WORLD_VALUES") == "run"
        cases = [(path, value) for path, _ in leaves(world) if len(path) > 1 for value in ODD]
        if not runs:
            cases = cases[::41]  # some of most values, all of ODD in turn
        if "WORLD_VALUES_ONLY" in os.environ:
            cases = [case for case in cases if os.environ["WORLD_VALUES_ONLY"] in ".".join(map(str, case[0]))]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            wrong = [trouble for trouble in pool.map(lambda case: self.attempt(case[0], world, *case[1], runs), enumerate(cases)) if trouble]
        most_kb = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
        print(f"{len(cases)} values, {len(wrong)} taken wrongly, at most {most_kb // 1024} MiB", file=sys.stderr)
        self.assertEqual(wrong, [], "\n".join(wrong))
        self.assertLess(most_kb, MEMORY_KB)


if __name__ == "__main__":
    unittest.main()
