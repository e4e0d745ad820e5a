#!/usr/bin/env python3
"""Each value of a world file in turn replaced by what is none: refused in one line that names it, or the laboratory runs with it for a moment. Without
WORLD_VALUES=run only what is loaded is tried, of each value a part."""
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
LONGEST_S = 20.0
MEMORY_KB = 3_000_000
MODES = {
    "run": (["world", "run", "--seconds", "0.2"], ["world", "sample", "camera", "--points", "2"], ["world", "sample", "arm", "--points", "3"],
            ["world", "sample", "pivot", "--points", "5"], ["world", "sample", "hand-eye", "--points", "5"], ["world", "sample", "surface"],
            ["world", "sample", "pointer", "--points", "5"], ["world", "sample", "landmarks"]),
    "load": (),
}


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

    def attempt(self, number, world, path, value, modes):
        """What is wrong with how the program takes it; None: nothing."""
        folder = self.path(str(number % 8))
        os.makedirs(folder, 0o700, exist_ok=True)
        file = os.path.join(folder, f"{number}.toml")
        name = ".".join(str(key) for key in path if isinstance(key, str))
        what = f"{name} {path[len(name.split('.')):]} = {value[:30]}"
        with open(file, "w", encoding="utf-8") as out:
            out.write(as_file(replaced(world, path, value)))
        try:
            for command in (["world", "show"], *modes):
                where = [file] if command[-1] == "show" else ["--world", file]
                more = ["--out", os.path.join(folder, f"out{number}")] if command[1] == "sample" else []
                try:
                    done = self.answer(folder, *command, *where, *more)
                except subprocess.TimeoutExpired:
                    return f"{what}: {command} takes more than {LONGEST_S} s"
                error = done.stderr.decode()
                if done.returncode not in (0, 1, 2) or "ERROR: AddressSanitizer" in error or "runtime error" in error:
                    return f"{what}: {command} ends with {done.returncode}: {error[-1500:]}"
                if command[-1] == "show" and done.returncode:
                    lines = error.splitlines()
                    last = next((key for key in reversed(path) if isinstance(key, str)))
                    if len(lines) != 1 or last not in lines[0] and path[0] not in lines[0] or len(lines[0]) > 1000 or CONTROLS & set(map(ord, lines[0])):
                        return f"{what}: refused with {lines}"
                    return None
                if done.returncode and len([line for line in error.splitlines() if "are open" not in line]) != 1:
                    return f"{what}: {command} ends with {done.returncode}: {error[:500]}"
        finally:
            os.unlink(file)
        return None

    def test_each_value_in_turn(self):
        world = tomllib.loads(self.runs("world", "show").out)
        mode = os.environ.get("WORLD_VALUES", "load")
        cases = [(path, value) for path, _ in leaves(world) if len(path) > 1 for value in ODD]
        if mode == "load":
            cases = cases[::41]  # some of most values, all of ODD in turn
        if "WORLD_VALUES_ONLY" in os.environ:
            cases = [case for case in cases if os.environ["WORLD_VALUES_ONLY"] in ".".join(map(str, case[0]))]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            wrong = [trouble for trouble in pool.map(lambda case: self.attempt(case[0], world, *case[1], MODES[mode]), enumerate(cases)) if trouble]
        most_kb = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
        print(f"{len(cases)} values, {len(wrong)} taken wrongly, at most {most_kb // 1024} MiB", file=sys.stderr)
        self.assertEqual(wrong, [], "\n".join(wrong))
        self.assertLess(most_kb, MEMORY_KB)


if __name__ == "__main__":
    unittest.main()
