#!/usr/bin/env python3
"""What of a Python package becomes its reference (docs/site/python_reference.py)."""
import os
import pathlib
import re
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "docs", "site"))
import python_reference  # noqa: E402

INIT = """\
from ._things import Thing, weigh
"""
THINGS = '''\
"""Things to weigh: stars * and <tags> are plain words.

More of them.
"""
import typing
from typing import Optional

class _Common:
    @property
    def shared(self) -> float:
        """What all have | and more."""

class Thing(_Common):
    """A thing.

        Thing("pear").weigh()

    There are more.
    """

    kind: str  # what it is

    def __init__(self, kind: str, *, grams: Optional[float] = None) -> None:
        """Makes one.

        kind: any word. grams: its weight, g;
            None: as usual.

        Raises ValueError for none.
        """
        self.count: int = 0  # of its parts
        self._hidden = 1  # nobody sees this

    def weigh(self) -> float:
        """g."""

    def _inner(self) -> None:
        """Of no concern."""

def weigh(things: "typing.Sequence[Thing]", on: dict[str, Optional[Thing]], unit: str = "grams", another_long_name: int = 1) -> float:
    """The sum of things: all of them.

    unit: "grams" or "pounds".
    """
'''


class Reference(unittest.TestCase):
    def page(self, things=THINGS):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in (("__init__.py", INIT), ("_things.py", things)):
                pathlib.Path(folder, name).write_text(text, encoding="ascii")
            return python_reference.page(pathlib.Path(folder))

    def test_words_signatures_and_attributes(self):
        page = self.page()
        for expected in ("## Things to weigh\n", "Stars \\* and \\<tags\\> are plain words.", "More of them.", "### Thing\n", "### weigh\n",
                         '```python\nThing("pear").weigh()\n```', "Thing(kind: str, *, grams: Optional[float] = None)\n",
                         "- `kind`: any word.\n- `grams`: its weight, g; None: as usual.\n", "Raises ValueError for none.",
                         "| `kind` | `str` | what it is |", "| `count` | `int` | of its parts |", "| `shared` | `float` | What all have \\| and more. |",
                         "#### Thing.weigh\n", "weigh() -> float", "    on: dict[str, Optional[Thing]],\n    unit: str = 'grams',",
                         "The sum of things: all of them."):
            self.assertIn(expected, page)
        for hidden in ("hidden", "_inner", "Of no concern", "_Common", "self"):
            self.assertNotIn(hidden, page)

    def test_what_has_no_words_is_told(self):
        with self.assertRaisesRegex(LookupError, "_things.py: weigh"):
            self.page(re.sub(r'    """The sum.*"""\n', "    return 0.0\n", THINGS, flags=re.DOTALL))

    def test_the_package_is_whole(self):
        page = python_reference.page()
        import_lines = (python_reference.PACKAGE / "__init__.py").read_text(encoding="utf-8")
        for name in re.findall(r'"(\w+)"', import_lines.split("__all__", 1)[1]):
            self.assertIn(f"\n### {name}\n", page)


if __name__ == "__main__":
    unittest.main()
