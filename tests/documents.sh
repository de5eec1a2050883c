#!/usr/bin/env bash
# Checks README.md, CHANGELOG.md and every page of data: links, numbers of words, sentences, words that do not
# belong there. documents.sh SOURCE
set -euo pipefail
cd "$1"
exec python3 - <<'PYTHON'
import pathlib
import re
import sys

MOST_WORDS, MOST_WORDS_OF_README, MOST_WORDS_OF_SENTENCE, SHOWN = 26000, 1000, 25, 20
UNWANTED = ["../shared", "throwaway", "this tree", "today's"]
ABBREVIATIONS = ("Fig.", "Figs.", "Eq.", "e.g.", "i.e.", "al.", "vs.", "cf.", "No.", "p.", "pp.")

pages = [pathlib.Path("README.md"), pathlib.Path("CHANGELOG.md"), *sorted(pathlib.Path("data").rglob("*.md"))]
pages = [page for page in pages if page.exists()]
text_of = {page: page.read_text(encoding="utf-8") for page in pages}


def without_code(text):
    """The same number of lines; those of fenced blocks are empty."""
    lines, fence = [], ""
    for line in text.split("\n"):
        mark = re.match(r"\s*(`{3,}|~{3,})", line)
        if mark and (not fence or line.strip() == fence):
            fence = "" if fence else mark[1]
            line = ""
        lines.append("" if fence else line)
    return lines


def anchors(text):
    """Names of the headings as GitHub makes them."""
    names = set()
    for line in without_code(text):
        heading = re.match(r"#+\s+(.*)", line)
        if heading:
            title = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading[1]).strip().lower()
            name = re.sub(r"[^\w\- ]", "", title.replace("`", "")).replace(" ", "-")
            k, first = 0, name
            while name in names:
                k += 1
                name = f"{first}-{k}"
            names.add(name)
    names.update(re.findall(r'<a (?:id|name)="([^"]+)"', text))
    return names


def broken_links(page):
    for number, line in enumerate(without_code(text_of[page]), 1):
        for target in re.findall(r"\]\(<?([^)\s>]+)", re.sub(r"`[^`]*`", "", line)):
            if re.match(r"[a-z]+:", target):
                continue
            path, _, anchor = target.partition("#")
            place = page.parent / path if path else page
            if not place.exists():
                yield f"{page}:{number}: link to nothing: {target}"
            elif anchor and place.suffix == ".md" and anchor not in anchors(place.read_text(encoding="utf-8")):
                yield f"{page}:{number}: no such heading: {target}"


def paragraphs(text):
    """(line, text) of running text: no code, tables or headings. An item of a list is one of its own."""
    start, parts, quiet = 0, [], True  # quiet: the line before was empty or indented code
    for number, line in enumerate(without_code(text) + [""], 1):
        code = re.match(r" {4}|\t", line) and quiet
        left_out = not line.strip() or code or re.match(r"\s*(#|\||!\[[^\]]*\]\([^)]*\)\s*$|<|-{3,}$)", line)
        item = re.match(r"\s*([*+-]|\d+[.)])\s+", line)
        if parts and (left_out or item):
            yield start, " ".join(parts)
            parts = []
        if not left_out:
            start = start if parts else number
            parts.append(line[item.end():] if item else line.strip())
        quiet = bool(not line.strip() or code)


def sentences(paragraph):
    paragraph = re.sub(r"`[^`]*`", "code", paragraph)
    paragraph = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", paragraph).replace("**", "")
    begin = 0
    for end in re.finditer(r"[.!?][\"'”)\]*_]*(?=\s|$)", paragraph):
        sentence = paragraph[begin:end.end()].strip()
        if sentence.split()[-1].lstrip("(") in ABBREVIATIONS:
            continue
        yield sentence
        begin = end.end()
    if paragraph[begin:].strip():
        yield paragraph[begin:].strip()


def length(sentence):
    """Words: signs without a letter or digit are none."""
    return sum(any(c.isalnum() for c in word) for word in sentence.split())


faults = []
for page in pages:
    faults += broken_links(page)
    lines = text_of[page].lower().replace("’", "'").split("\n")
    for word in UNWANTED:
        places = [str(number) for number, line in enumerate(lines, 1) if word in line]
        if places:
            faults.append(f"{page}: “{word}” in line {', '.join(places)}")
    # Shown as code by every reader of Markdown, not only by some.
    lines = without_code(text_of[page])
    faults += [f"{page}:{number}: code inside a list begins with 8 spaces"
               for number, pair in enumerate(zip(lines, lines[1:]), 2) if re.match(r"\s*\n {5,7}\S", "\n".join(pair))]
words = {page: len(text.split()) for page, text in text_of.items()}
total = sum(words.values())
if total > MOST_WORDS:
    longest = sorted(words, key=words.get, reverse=True)[:SHOWN]
    faults.append(f"all documents: {total} words, more than {MOST_WORDS}; the longest:\n" +
                  "\n".join(f"    {words[page]:6} {page}" for page in longest))
if words[pathlib.Path("README.md")] > MOST_WORDS_OF_README:
    faults.append(f"README.md: {words[pathlib.Path('README.md')]} words, more than {MOST_WORDS_OF_README}")
long = [(length(sentence), page, number, sentence) for page in pages
        for number, paragraph in paragraphs(text_of[page]) for sentence in sentences(paragraph)]
count = len(long)
long = sorted((entry for entry in long if entry[0] > MOST_WORDS_OF_SENTENCE), key=lambda e: (-e[0], e[1], e[2]))
if long:
    of_page = {}
    for entry in long:
        of_page[entry[1]] = of_page.get(entry[1], 0) + 1
    faults.append(f"{len(long)} of {count} sentences have more than {MOST_WORDS_OF_SENTENCE} words:\n" +
                  "\n".join(f"    {number:4} in {page}" for page, number in of_page.items()) + "\n" +
                  "\n".join(f"    {n} words, {page}:{line}: {sentence}" for n, page, line, sentence in long[:SHOWN]))
print("\n".join(faults))
print(f"{len(pages)} documents, {total} words, {count} sentences, {len(faults)} faults")
sys.exit(bool(faults))
PYTHON
