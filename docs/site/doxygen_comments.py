#!/usr/bin/python3 -SE
"""Prints a header as Doxygen wants it: our plain // comments become documentation. INPUT_FILTER of the Doxyfile.

The comment on top documents the file. A block of comment lines documents the declaration below it, a comment at the end
of a line the declaration that begins on that line. What stands in function bodies, or before an empty line, stays a plain
comment. Lines keep their numbers, but for a moment after a list or before a formula.
"""
import re
import sys

# Strings and characters are passed over; a comment, a brace or a semicolon may be inside them.
TOKEN = re.compile(r'"(?:\\.|[^"\\])*"|\'(?:\\[^\']+|[^\'\\])\'|//.*|[{};]')
# What holds declarations: a comment inside is documentation.
SCOPE = re.compile(r'(?:template\s*<.*>\s*)?(?:\[\[.*?\]\]\s*)?(?:inline\s+)?(?:namespace|class|struct|union|enum|extern "C")\b', re.S)
NO_DECLARATION = re.compile(r'\s*(?:$|#(?!define)|static_assert|friend|public:|protected:|private:|\})')
COMMENT_LINE = re.compile(r'(\s*)//(?!/)(.*)')


def prose(words):
    """Plain text: no character of it is a command, a tag or a reference, but for code between `backticks`."""
    parts = words.split("`")
    for i in range(0, len(parts), 2 if len(parts) % 2 else 1):
        parts[i] = re.sub(r"--+", lambda dashes: "\\" + dashes[0], re.sub(r"([\\@<>#%&$])", r"\\\1", parts[i]))
    return "`".join(parts)


def written(block):
    """Comment lines as documentation. A formula, further in than the text, is shown as it is; text after a list is no part of it."""
    lines, formula, item, before = [], False, False, ""
    for line in block:
        indent, words = COMMENT_LINE.fullmatch(line).groups()
        was_item, was_formula = item, formula
        item = bool(re.match(r" +(- |[0-9]+\. )", words)) or (item and words.startswith("  "))
        formula = words.startswith("   ") and not item
        if before.strip() and ((was_item and not item) or (formula and not was_formula)):
            lines.append(f"{indent}///")
        lines.append(f"{indent}///    {words}" if formula else f"{indent}///{prose(words)}")
        before = words
    return lines


class Scopes:
    """Which braces are open, and the declaration that is being read."""

    def __init__(self):
        self.holds_declarations, self.declaration = [], ""

    def all_hold_declarations(self):
        return all(self.holds_declarations)

    def read(self, code):
        last = 0
        for token in TOKEN.finditer(code):
            if token[0] not in "{};":
                continue
            self.declaration += code[last:token.start()]
            last = token.end()
            if token[0] == "{":
                self.holds_declarations.append(bool(SCOPE.match(self.declaration.strip())))
            elif token[0] == "}" and self.holds_declarations:
                self.holds_declarations.pop()
            self.declaration = ""
        self.declaration += code[last:] + "\n"
        if code.lstrip().startswith("#") or re.fullmatch(r"\s*(public|protected|private):\s*", code):
            self.declaration = ""


def filtered(text):
    lines, block, scopes, column = [], [], Scopes(), None
    moved = 0  # lines that were added
    for line in text.split("\n"):
        if moved and not line and not block:
            moved -= 1
            continue
        if found := COMMENT_LINE.fullmatch(line):
            if len(found[1]) == column:  # goes on below the end of a line
                lines.append(f"{found[1]}///< {prose(found[2].strip())}")
            else:
                block.append(line)
            continue
        if block and not lines and line == "#pragma once":
            lines += written(block) + ["/// \\file"]
            moved, block = len(lines) - len(block) - 1, []
            continue
        documents = scopes.all_hold_declarations() and not NO_DECLARATION.match(line)
        comments = written(block) if documents else block
        lines += comments
        moved, block = moved + len(comments) - len(block), []
        begins_here = documents and not scopes.declaration.strip()
        comment = next((token for token in TOKEN.finditer(line) if token[0].startswith("//")), None)
        code = line[:comment.start()].rstrip() if comment else line
        scopes.read(code)
        column = comment.start() if comment and documents else None
        if column is not None:
            words = prose(comment[0].lstrip("/").strip())
            line = f"/** {words} */ {code}" if begins_here else f"{code}  ///< {words}"
        # Names are told as they are used; Doxygen 1.9.4 does not know the short form of an inline namespace.
        lines.append(re.sub(r"^namespace palpate::inline \w+", "namespace palpate", line))
    return "\n".join(lines + block)


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as file:
        print(filtered(file.read()), end="")
