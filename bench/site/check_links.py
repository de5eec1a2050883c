"""Every link of a folder of HTML pages leads to a file and an anchor; nothing is loaded from elsewhere;
no fence of a code block is left as text.

check_links.py FOLDER
"""

import html.parser
import pathlib
import sys
import urllib.parse

LOADED = {("script", "src"), ("img", "src"), ("iframe", "src"), ("link", "href")}


class Page(html.parser.HTMLParser):
    """Links of a page, and the names that links may lead to."""

    def __init__(self, path):
        super().__init__()
        self.links, self.names, self.has_fence = [], set(), False
        self.feed(path.read_text(encoding="utf-8", errors="replace"))

    def handle_starttag(self, tag, attributes):
        for key, value in attributes:
            if key in ("id", "name") and value:
                self.names.add(value)
            if key in ("href", "src") and value:
                self.links.append((tag, key, value))

    def handle_data(self, data):
        self.has_fence |= "```" in data


def main(folder):
    pages = {path.resolve(): Page(path) for path in sorted(folder.rglob("*.html"))}
    faults, count = [f"{path}: shows ```" for path, page in pages.items() if page.has_fence], 0
    for path, page in pages.items():
        for tag, key, link in page.links:
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc:
                if (tag, key) in LOADED and parts.scheme not in ("data", "javascript"):
                    faults.append(f"{path}: loads {link}")
                continue
            count += 1
            target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            if target.is_dir():
                target = target / "index.html"
            if not target.exists():
                faults.append(f"{path}: no such file: {link}")
            elif parts.fragment and target in pages and not target.is_relative_to(folder.resolve() / "cpp"):
                if urllib.parse.unquote(parts.fragment) not in pages[target].names:
                    faults.append(f"{path}: no such place: {link}")
    print("\n".join(faults))
    print(f"{len(pages)} pages, {count} links, {len(faults)} faults")
    return bool(faults) or not count


sys.exit(main(pathlib.Path(sys.argv[1])))
