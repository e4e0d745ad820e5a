"""Hook of mkdocs.yml: what the site shows beside docs/, and where links into the source tree lead.

README.md is the first page; change log, contributing and the examples' READMEs are pages. A link to a public header leads
to its page of the C++ reference, one to another text file to a page that shows it, one to a folder of docs/ to a page that
lists it, to the Python package to its reference. Words that link to what the site has not stay as words.
"""
import json
import pathlib
import posixpath
import re
import subprocess
import sys
import xml.etree.ElementTree

from mkdocs.structure.files import File

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import python_reference  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
WORK = ROOT / "build" / "site-work"  # scripts/docs has put the C++ reference there
MADE = WORK / "pages"
PAGES = {"README.md": "index.md", "CHANGELOG.md": "changelog.md", "CONTRIBUTING.md": "contributing.md", "fuzz/README.md": "fuzz.md"}
FOLDERS = {"docs/guides": "Guides", "docs/theory": "Theory", "docs/decisions": "Decisions"}  # listed on a page
LANGUAGES = {".h": "cpp", ".cpp": "cpp", ".py": "python", ".cmake": "cmake", ".proto": "protobuf", ".toml": "toml", ".js": "javascript"}
CODE_OR_LINK = re.compile(r"^```.*?^```|^    [^\n]*|`[^`\n]*`|(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)", re.M | re.S)


def tracked():
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return set(listed.split("\0"))


def reference_pages(*kinds):
    """Header or class -> its page, as Doxygen's tag file tells."""
    found = xml.etree.ElementTree.parse(WORK / "cpp.tag").iterfind("compound")
    return {(entry.findtext("path") or "").removeprefix(f"{ROOT}/") + entry.findtext("name"): "cpp/" + entry.findtext("filename")
            for entry in found if entry.get("kind") in kinds}


class Site:
    """Which file of the tree is which file of the site."""

    def __init__(self):
        self.tree = tracked()
        self.pages = {name: page for name, page in PAGES.items() if name in self.tree}
        for name in self.tree:
            if name.startswith("docs/") and not name.startswith("docs/site/"):
                self.pages[name] = name.removeprefix("docs/")
            elif re.fullmatch(r"examples/\w+/README\.md", name):
                self.pages[name] = posixpath.dirname(name) + ".md"
        self.pages.update(reference_pages("file"))
        self.made = {"python-reference.md": python_reference.page()}  # site's file -> Markdown

    def sources(self):
        """Pages of the tree that are Markdown, with their places in the site."""
        return {name: page for name, page in self.pages.items() if name.endswith(".md")}

    def place(self, name):
        """Where the site has this file or folder of the tree; None: nowhere."""
        if name in FOLDERS:
            return name.removeprefix("docs/") + "/index.md"
        if name == "palpate":
            return "cpp/index.html"
        if name == "python/palpate":
            return "python-reference.md"
        if name + "/README.md" in self.pages:
            return self.pages[name + "/README.md"]
        if name not in self.pages and name in self.tree:
            self.show(name)
        return self.pages.get(name)

    def show(self, name):
        text = (ROOT / name).read_text(encoding="utf-8")
        fence = "`" * max([4, *(len(ticks) + 1 for ticks in re.findall("`+", text))])
        language = LANGUAGES.get(pathlib.PurePath(name).suffix, "")
        self.pages[name] = f"files/{name}.md"
        self.made[self.pages[name]] = f"# {name}\n\n{fence}{language}\n{text}\n{fence}\n"

    def list_folder(self, folder, title):
        lines = [f"# {title}", ""]
        for name, page in sorted(self.sources().items()):
            if posixpath.dirname(name) == folder:
                heading = (ROOT / name).read_text(encoding="utf-8").split("\n", 1)[0].lstrip("# ")
                lines.append(f"- [{re.sub(r'^[0-9]+[.] ', '', heading)}]({posixpath.basename(page)})")
        self.made[self.place(folder)] = "\n".join(lines) + "\n"

    def with_links(self, text, name):
        """This file's Markdown with links as the site needs them."""
        here = posixpath.dirname(self.pages[name])

        def link(found):
            picture, words, target = found.groups()
            if target is None or target.startswith("#") or re.match(r"[a-z]+:", target):
                return found[0]
            path, hash_, anchor = target.partition("#")
            words = CODE_OR_LINK.sub(link, words)
            there = self.place(posixpath.normpath(posixpath.join(posixpath.dirname(name), path)))
            return f"{picture}[{words}]({posixpath.relpath(there, here or '.')}{hash_}{anchor})" if there else words

        return CODE_OR_LINK.sub(link, text)


SITE = None


def on_files(files, config):
    global SITE
    SITE = Site()
    for file in list(files):
        if file.src_uri.startswith("site/") and not file.src_uri.endswith((".css", ".js")):
            files.remove(file)
    for folder, title in FOLDERS.items():
        SITE.list_folder(folder, title)
    texts = {page: SITE.with_links((ROOT / name).read_text(encoding="utf-8"), name) for name, page in SITE.sources().items()}
    for page, text in {**texts, **SITE.made}.items():
        path = MADE / page
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        if page in files:
            files.remove(files.get_file_from_path(page))
        files.append(File(page, str(MADE), config.site_dir, config.use_directory_urls))
    for path in (WORK / "cpp").rglob("*"):
        if path.is_file():
            files.append(File(str(path.relative_to(WORK)), str(WORK), config.site_dir, config.use_directory_urls))
    return files


def on_post_build(config):
    """The search finds pages, headers and classes, but no program text. It needs no web server: a browser reads no JSON from a file."""
    (pathlib.Path(config.site_dir) / "404.html").unlink()  # its links lead to the root of a server
    folder = pathlib.Path(config.site_dir) / "search"
    index = json.loads((folder / "search_index.json").read_text(encoding="utf-8"))
    index["docs"] = [entry for entry in index["docs"] if not entry["location"].startswith("files/")]
    # A word of a guide's title is rarely meant as a class: pages come first.
    index["docs"] += [{"location": page, "title": name, "text": "", "boost": 0.2} for name, page in reference_pages("file", "class", "struct").items()]
    text = json.dumps(index, ensure_ascii=False, separators=(",", ":"))
    (folder / "search_index.json").write_text(text, encoding="utf-8")
    (folder / "search_index.js").write_text(f"window.__search = {{index: Promise.resolve({text})}};", encoding="utf-8")
