"""The commands that README and docs tell a person to type: lines of their code blocks, and code in their text."""
import dataclasses
import os
import re
import shlex

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
FENCED = re.compile(r"^```(\w*)\n(.*?)^```$", re.M | re.S)
INDENTED = re.compile(r"(?:^    .*\n?)+", re.M)
# A line that is typed; other lines of a block are a file's or a program's.
TYPED = re.compile(r"(?:[A-Z_]+=\S+ +)*(?:palpate|scripts/\S+|cmake|ctest|alias)\b.*")


@dataclasses.dataclass(frozen=True)
class Command:
    file: str  # of this tree
    line: int
    text: str

    def __str__(self):
        return f"{self.file}:{self.line}: {self.text}"

    def words(self):
        """What the program gets: without the comment, what stands before `palpate`, and what the shell does with the output."""
        words = shlex.split(self.text, comments=True)
        words = words[words.index("palpate") + 1:]
        ends = [i for i, word in enumerate(words) if word in ("|", "&&", "&", ";") or word.startswith((">", "..."))]
        return words[:ends[0]] if ends else words


def read(file):
    with open(os.path.join(ROOT, file), encoding="utf-8") as opened:
        return opened.read()


def blocks(file):
    """Blocks that hold commands, each a list of them; a command that goes on in the next line is one."""
    text = read(file)
    found = [(match.start(2), match[2]) for match in FENCED.finditer(text) if match[1] in ("", "sh", "bash")]
    without = FENCED.sub(lambda match: re.sub(r"[^\n]", ".", match[0]), text)
    found += [(match.start(), re.sub(r"^    ", "", match[0], flags=re.M)) for match in INDENTED.finditer(without)]
    result = []
    for start, block in sorted(found):
        commands, line = [], text.count("\n", 0, start) + 1
        for typed in re.findall(r"(?:.*\\\n)*.*\n?", block):
            if TYPED.match(typed):
                commands.append(Command(file, line, typed.rstrip("\n")))
            line += typed.count("\n")
        if commands:
            result.append(commands)
    return result


def in_text(file):
    """`palpate ...` between backticks."""
    text = FENCED.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), read(file))
    text = INDENTED.sub(lambda match: re.sub(r"[^\n]", " ", match[0]), text)
    return [Command(file, text.count("\n", 0, match.start()) + 1, match[1].replace("\n", " "))
            for match in re.finditer(r"`(palpate [^`]+)`", text)]
