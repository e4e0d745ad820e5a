#!/usr/bin/python3
"""check_site.py FOLDER: each link of its pages leads to a file that is there, and no page loads from a host.

A link into a page of Markdown leads to a heading that is there, too; where Doxygen leads within its pages is its own."""
import functools
import html.parser
import pathlib
import sys
import urllib.parse

LOADED = {("script", "src"), ("img", "src"), ("link", "href"), ("iframe", "src"), ("source", "src"), ("object", "data")}


class Page(html.parser.HTMLParser):
    def __init__(self, path):
        super().__init__()
        self.links, self.loads, self.anchors = [], [], set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("id", "name"):
                self.anchors.add(value)
            elif (tag, name) in LOADED and dict(attributes).get("rel") != "canonical":
                self.loads.append(value)
            elif (tag, name) == ("a", "href"):
                self.links.append(value)


@functools.cache
def page_at(path):
    return Page(path)


def trouble_with(target, page, loaded):
    """In words; empty: none."""
    parts = urllib.parse.urlsplit(target)
    if parts.scheme or parts.netloc:
        return "is loaded from a host" if loaded and parts.scheme not in ("data", "javascript") else ""
    path = page.parent / urllib.parse.unquote(parts.path) if parts.path else page
    if not path.is_file():
        return "leads nowhere"
    if parts.fragment and path.suffix == ".html" and path.parent.name != "cpp" and urllib.parse.unquote(parts.fragment) not in page_at(path.resolve()).anchors:
        return "leads to no such place"
    return ""


found = []
folder = pathlib.Path(sys.argv[1]).resolve()
pages = sorted(folder.rglob("*.html"))
for path in pages:
    page = page_at(path)
    for targets, loaded in ((page.links, False), (page.loads, True)):
        found += [f"{path.relative_to(folder)}: {target} {trouble}" for target in targets if (trouble := trouble_with(target, path, loaded))]
if not pages:
    found.append(f"{folder}: no pages")
print("\n".join(found[:50]), end="\n" if found else "", file=sys.stderr)
sys.exit(bool(found))
