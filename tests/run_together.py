"""run_together.py PROGRAM EXPRESSION: its tests of GoogleTest in one process, but those whose name holds the expression."""
import os
import re
import signal
import subprocess
import sys

program, left_out = sys.argv[1:]
names, suite = [], ""
for line in subprocess.run([program, "--gtest_list_tests"], check=True, capture_output=True, text=True).stdout.splitlines():
    line = line.split("  #")[0]  # a parameter's value
    if line.startswith("  "):
        names.append(suite + line.strip())
    elif line.endswith("."):
        suite = line
kept = [name for name in names if not re.search(left_out, name)]
if not names:
    sys.exit(f"{program} has no tests")
if kept:
    for ignored in (signal.SIGPIPE, signal.SIGXFSZ):  # by Python, and by what it becomes
        signal.signal(ignored, signal.SIG_DFL)
    os.execv(program, [program, "--gtest_filter=" + ":".join(kept)])
