"""What docs/raw-files.md tells of a demo's raw files, and whether it, and the report, tell all of them."""
import csv
import json
import os
import re

PAGE = os.path.join(os.path.dirname(__file__), "..", "..", "docs", "raw-files.md")


def pattern(name):
    """`trip_N.csv`, `NAME_mm`: capitals stand for a number or a name."""
    return re.compile(re.sub("NAME", "[a-z][a-z0-9_]*?", re.sub(r"(?<![A-Z])N(?![A-Z])", r"\\d+", re.escape(name))))


def described():
    """(name of a file as it stands there, its columns as they stand there), in the order of the page."""
    with open(PAGE, encoding="utf-8") as page:
        sections = page.read().split("\n### ")[1:]
    found = []
    for section in sections:
        names, text = section.split("\n", 1)
        cells = [line.split("|")[1] for line in text.splitlines() if line.startswith("| `")]
        columns = [column for cell in cells for column in re.findall("`([^`]+)`", cell)]
        found += [(name, columns) for name in names.split(", ")]
    return found


def check(test, folder):
    """Each file of folder/raw stands in docs/raw-files.md and with words in the report; so does each of its columns."""
    pages, seen = described(), {}
    with open(os.path.join(folder, "report.json"), encoding="utf-8") as report:
        told = {file["file"]: file["holds"] for file in json.load(report)["files"]}
    with open(os.path.join(folder, "report.html"), encoding="utf-8") as report:
        html = report.read()
    for file in sorted(os.listdir(os.path.join(folder, "raw"))):
        test.assertTrue(told.get(file), f"{file}: the report does not say what it holds")
        test.assertIn(f"<code>raw/{file}</code>", html)
        columns = next((columns for name, columns in pages if pattern(name).fullmatch(file)), None)
        test.assertIsNotNone(columns, f"{file}: not in docs/raw-files.md")
        if not file.endswith(".csv"):
            continue
        with open(os.path.join(folder, "raw", file), encoding="utf-8") as table:
            header = next(csv.reader(line for line in table if not line.startswith("#")))
        for column in header:
            meant = [name for name in columns if pattern(name).fullmatch(column)]
            test.assertTrue(meant, f"{file}: its column '{column}' is not in docs/raw-files.md")
            seen.setdefault(tuple(columns), set()).update(meant)
    for columns, there in seen.items():  # of one section, which may stand for several files
        test.assertEqual(set(columns) - there, set(), "columns that no file has")
