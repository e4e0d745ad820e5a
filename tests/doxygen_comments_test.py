#!/usr/bin/env python3
"""Which comments of a header become its documentation (docs/site/doxygen_comments.py)."""
import os
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "docs", "site"))
from doxygen_comments import filtered  # noqa: E402

HEADER = """\
// What the file is: x < 1 and #none.
//   F = m a    in N
// Methods:
//  - one;
//  - two.
// After the list.
#pragma once

namespace palpate::inline math {

// --- a part of the file

// The sum's words.
struct Sum {
  double value = 0.0;  // m
  const char* text = "// none";
  int parts = 0;  // of the sum,
                  // and of what it holds
  // In braces.
  int get() const {
    // Nobody's but the reader's.
    return parts;  // nor this
  }
};

enum class Kind {
  first,   // of them
  second,  // of them
};

// Checked here.
static_assert(sizeof(Sum) > 0);

}  // namespace palpate::inline math
"""


class DoxygenComments(unittest.TestCase):
    def setUp(self):
        self.lines = filtered(HEADER).split("\n")

    def test_the_comment_on_top_is_the_files_as_plain_text(self):
        self.assertEqual(self.lines[:9], [r"/// What the file is: x \< 1 and \#none.", "///", "///       F = m a    in N", "/// Methods:", "///  - one;",
                                          "///  - two.", "///", "/// After the list.", r"/// \file"])

    def test_comments_document_the_declaration_below_or_on_their_line(self):
        for line in ("/// The sum's words.", "/** m */   double value = 0.0;", "  /// In braces.", "/** of the sum, */   int parts = 0;",
                     "                  ///< and of what it holds", "/** of them */   first,", "  second,  ///< of them"):
            self.assertIn(line, self.lines)

    def test_the_rest_stays_as_it_is(self):
        for line in ("// --- a part of the file", '  const char* text = "// none";', "    // Nobody's but the reader's.", "    return parts;  // nor this",
                     "// Checked here."):
            self.assertIn(line, self.lines)

    def test_lines_keep_their_numbers_and_names_are_as_they_are_used(self):
        self.assertEqual(len(self.lines), len(HEADER.split("\n")))
        self.assertEqual(self.lines.index("struct Sum {"), HEADER.split("\n").index("struct Sum {"))
        self.assertIn("namespace palpate {", self.lines)


if __name__ == "__main__":
    unittest.main()
