#!/usr/bin/python3
"""The Python reference of the site: what `import palpate` gives, from the sources' signatures, docstrings and comments.

A docstring's "name: words" of an argument become a list; code is what stands four columns further in. A comment at the end
of an attribute's line says what it is. Nothing is imported, so nothing need be built.
"""
import ast
import pathlib
import re
import sys
import textwrap

PACKAGE = pathlib.Path(__file__).resolve().parents[2] / "python" / "palpate"
CODE = re.compile(r"(`[^`]*`)")


def prose(words):
    """No character of it is Markdown, but for code between `backticks`."""
    parts = CODE.split(words)
    return "".join(part if part.startswith("`") else re.sub(r"([\\*\[\]<>#])", r"\\\1", part) for part in parts)


def arguments_of(function):
    arguments = function.args
    return [argument.arg for argument in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs) if argument.arg != "self"]


def paragraph(words, arguments):
    """A list where it says what arguments are, else itself."""
    names = "|".join(map(re.escape, arguments)) or "(?!)"
    begins = [found.start(1) for found in re.finditer(rf"(?:^|(?<=[.;)] ))({names}(?:, (?:{names}))*): ", words)]
    if not begins:
        return prose(words)
    lead = [prose(words[:begins[0]].strip())] if words[:begins[0]].strip() else []
    items = []
    for begin, end in zip(begins, [*begins[1:], len(words)]):
        name, _, rest = words[begin:end].strip().partition(": ")
        items.append(f"- {', '.join(f'`{one}`' for one in name.split(', '))}: {prose(rest.rstrip(';'))}")
    return "\n\n".join([*lead, "\n".join(items)])


def documentation(text, arguments=()):
    blocks = []
    for block in re.split(r"\n\s*\n", textwrap.dedent(text or "").strip()):
        if block.startswith("    "):
            blocks.append(f"```python\n{textwrap.dedent(block)}\n```")
        else:
            blocks.append(paragraph(" ".join(block.split()), arguments))
    return "\n\n".join(blocks)


def type_text(annotation):
    """Without the package's own modules."""
    return re.sub(r"\b_\w+\.", "", ast.unparse(annotation)).replace("npt.", "")


def signature(name, function, of_class=False):
    """`of_class`: a method, or the constructor; without its first argument."""
    arguments = function.args
    if of_class:
        arguments = ast.arguments(**{**vars(arguments), "args": arguments.args[1:]})
    parts = [re.sub(r"^(\w+: .*)=(?=[^=]*$)", r"\1 = ", part) for part in split_at_commas(type_text(arguments))]
    returns = f" -> {type_text(function.returns)}" if function.name != "__init__" and function.returns else ""
    line = f"{name}({', '.join(parts)}){returns}"
    if len(line) > 90:
        line = f"{name}(\n    " + ",\n    ".join(parts) + f"\n){returns}"
    return f"```python\n{line}\n```"


def split_at_commas(text):
    """At those that are in no bracket."""
    parts, depth = [""], 0
    for character in text:
        depth += (character in "([{") - (character in ")]}")
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return [part.strip() for part in parts]


def table_row(name, kind, words):
    cells = (f"`{name}`", f"`{kind}`" if kind else "", words)
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def decorators(node):
    return {ast.unparse(decorator) for decorator in node.decorator_list}


class Module:
    def __init__(self, path):
        self.source = path.read_text(encoding="utf-8")
        self.lines = self.source.split("\n")
        self.tree = ast.parse(self.source)
        self.named = {node.name: node for node in self.tree.body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}

    def comment(self, node):
        """At the end of its line."""
        found = re.search(r"(?<=\S)  # (.*)$", self.lines[node.end_lineno - 1])
        return prose(found[1]) if found else ""

    def attributes(self, cls):
        """Name, type and words of those that are no properties."""
        inits = [node for node in cls.body if isinstance(node, ast.FunctionDef) and node.name == "__init__"]
        places = [*cls.body, *(inner for init in inits for inner in ast.walk(init))]
        found = {}
        for node in places:
            target = node.target if isinstance(node, ast.AnnAssign) else None
            if isinstance(node, ast.Assign) and self.comment(node):
                target = node.targets[0]
            name = target.id if isinstance(target, ast.Name) else target.attr if isinstance(target, ast.Attribute) else None
            if name and not name.startswith("_") and name not in found:
                found[name] = (type_text(node.annotation) if isinstance(node, ast.AnnAssign) else "", self.comment(node))
        return found

    def bases(self, cls):
        """Classes of the same file whose attributes are its own, too; the hidden ones."""
        names = [base.id for base in cls.bases if isinstance(base, ast.Name) and base.id.startswith("_")]
        return [self.named[name] for name in names if name in self.named]

    def class_text(self, cls):
        init = next((node for node in cls.body if isinstance(node, ast.FunctionDef) and node.name == "__init__"), None)
        shown = [ast.unparse(base) for base in cls.bases if not ast.unparse(base).startswith("_")]
        parts = [f"### {cls.name}", " ".join(["*class*", *(f"`{base}`" for base in shown)]),
                 documentation(ast.get_docstring(cls), self.attributes(cls))]
        if init is not None and ast.get_docstring(init):
            parts += [signature(cls.name, init, of_class=True), documentation(ast.get_docstring(init), arguments_of(init))]
        rows = [(name, kind, words) for name, (kind, words) in self.attributes(cls).items()]
        methods = []
        for node in (node for one in (*self.bases(cls), cls) for node in one.body if isinstance(node, ast.FunctionDef)):
            words = ast.get_docstring(node)
            if not words or node.name.startswith("_") and node.name not in ("__call__", "__next__", "__getitem__"):
                continue
            if "property" in decorators(node):
                rows.append((node.name, type_text(node.returns), prose(" ".join(words.split()))))
            else:
                methods += [f"#### {cls.name}.{node.name}".replace("__", r"\_\_"),
                            signature(node.name, node, of_class="staticmethod" not in decorators(node)), documentation(words, arguments_of(node))]
        if rows:
            parts.append("\n".join(["| | | |", "|---|---|---|", *(table_row(*row) for row in rows)]))
        return "\n\n".join(part for part in (*parts, *methods) if part)

    def function_text(self, function):
        return "\n\n".join((f"### {function.name}", signature(function.name, function),
                            documentation(ast.get_docstring(function), arguments_of(function))))


def exported(package):
    """Module -> names, in the order of the package's imports."""
    found = {}
    for node in ast.parse((package / "__init__.py").read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ImportFrom) and node.level == 1 and node.module:
            found.setdefault(node.module, []).extend(alias.asname or alias.name for alias in node.names)
    return found


def page(package=PACKAGE):
    """Markdown. Raises LookupError for a name without words: the reference is to say what each is."""
    parts = ["# Python reference",
             "All names of `import palpate`. How they go together: [Palpate from Python](guides/python.md). Everything is in metres, "
             "seconds, radians and newtons. Arrays that come back are read-only; `Floats` are arrays of float64."]
    for name, names in exported(package).items():
        module = Module(package / f"{name}.py")
        first, *others = (ast.get_docstring(module.tree) or name).split("\n\n")
        title, _, rest = " ".join(first.split()).partition(": ")
        parts += [f"## {title.rstrip('.')}", prose(rest[:1].upper() + rest[1:]), documentation("\n\n".join(others))]
        for one in names:
            node = module.named.get(one)
            if node is None:
                continue  # another name of one that is here
            if not ast.get_docstring(node):
                raise LookupError(f"{name}.py: {one} has no docstring")
            parts.append(module.class_text(node) if isinstance(node, ast.ClassDef) else module.function_text(node))
    return "\n\n".join(part for part in parts if part) + "\n"


if __name__ == "__main__":
    sys.stdout.write(page(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else PACKAGE))
