#!/usr/bin/env python3
"""links.py ROOT: checks every Markdown file below ROOT, and exits 1 where one of these is broken:
- each relative link and image leads to a file or folder, and its #fragment to a heading of that page;
- each path in backquotes that begins with one of ROOT's folders, such as `mesher/som/philox_step.h`, exists, and each other
  source file named there exists beside the page or has its name somewhere in ROOT;
- every folder with a CMakeLists.txt has a README.md;
- a README.md links the README.md of each folder directly inside its own; ARCHITECTURE.md does so for the root and for pipeline;
- each page begins with its title;
- no line is longer than 132 columns, no folder's README than 60 lines, the root's than 150."""
import glob
import os
import re
import sys

WIDTH = 132
ROOT_LINES = 150
README_LINES = 60
IGNORED = re.compile(r"^(\..*|build.*|out|node_modules|shared)$")  # not part of the repository
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
CODE = re.compile(r"`([^`\s]+)`")
SOURCE = re.compile(r"^[\w/]+\.(h|cpp|cu|cuh|py|sh|cmake)$")
BUILT = re.compile(r"^(build|out)[-/]")


def files_below(root):
    for folder, folders, files in os.walk(root):
        folders[:] = sorted(f for f in folders if not IGNORED.match(f))
        yield from (os.path.join(folder, name) for name in sorted(files))


def anchors(path):
    """The fragments that GitHub gives a page's headings."""
    with open(path, encoding="utf-8") as page:
        headings = [m.group(1) for m in re.finditer(r"^#+ +(.*)$", page.read(), re.M)]
    return {re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in headings}


def link_is_sound(page, target):
    if re.match(r"^[a-z]+:", target):
        return True  # the web, which a test does not ask
    path, _, fragment = target.partition("#")
    path = os.path.join(os.path.dirname(page), path) if path else page
    if not os.path.exists(path):
        return False
    return not fragment or fragment in anchors(path)


def path_is_sound(page, root, rooms, names, text):
    """A path may name several files (`room/x.{h,cpp}`, `room/*.h`) or a file by its name without ending."""
    path = re.sub(r":\d+$", "", text).rstrip("/")
    if BUILT.match(path) or re.search(r"[<>=$()…]|[A-Z]{4,}(?!S?\.md)", path):
        return True  # made by a build, or no path
    choice = re.search(r"\{([^{}]*)\}", path)
    if choice:
        return all(path_is_sound(page, root, rooms, names, path[:choice.start()] + part.strip() + path[choice.end():])
                   for part in choice.group(1).split(","))
    if "/" in path and path.split("/")[0] in rooms:
        start = os.path.join(glob.escape(root), path)
        return bool(glob.glob(start) or glob.glob(start + ".*"))
    if SOURCE.search(path):
        return os.path.exists(os.path.join(os.path.dirname(page), path)) or os.path.basename(path) in names
    return True


def missing_rooms(root, page, folders):
    """The folders with a README.md directly inside of these that the page does not link."""
    if not os.path.exists(page):
        return []
    with open(page, encoding="utf-8") as text:
        linked = {os.path.normpath(os.path.join(os.path.dirname(page), target)) for target in LINK.findall(text.read())}
    rooms = [os.path.join(folder, entry) for folder in folders if os.path.isdir(folder)
             for entry in sorted(os.listdir(folder)) if not IGNORED.match(entry)]
    return [os.path.relpath(room, root) for room in rooms if os.path.exists(os.path.join(room, "README.md")) and
            os.path.join(room, "README.md") not in linked and room not in linked]


def main():
    root = os.path.abspath(sys.argv[1])
    rooms = {entry for entry in os.listdir(root) if os.path.isdir(os.path.join(root, entry)) and not IGNORED.match(entry)}
    files = list(files_below(root))
    names = {os.path.basename(file) for file in files}
    bare = [file for file in files if os.path.basename(file) == "CMakeLists.txt" and
            not os.path.exists(os.path.join(os.path.dirname(file), "README.md"))]
    for file in bare:
        print("%s: there is no README.md beside it" % os.path.relpath(file, root))
    found = len(bare)
    lists = {file: [os.path.dirname(file)] for file in files if os.path.basename(file) == "README.md"}
    lists.pop(os.path.join(root, "README.md"), None)
    lists[os.path.join(root, "ARCHITECTURE.md")] = [root, os.path.join(root, "pipeline")]
    for page, folders in lists.items():
        for room in missing_rooms(root, page, folders):
            print("%s: the room %s is not listed" % (os.path.relpath(page, root), room))
            found += 1
    for page in (file for file in files if file.endswith(".md")):
        name = os.path.relpath(page, root)
        with open(page, encoding="utf-8") as lines:
            for number, line in enumerate(lines, 1):
                line = line.rstrip("\n")
                faults = ["the link %s leads nowhere" % t for t in LINK.findall(line) if not link_is_sound(page, t)]
                if name != "CHANGELOG.md":
                    faults += ["there is no %s" % t for t in CODE.findall(line) if not path_is_sound(page, root, rooms, names, t)]
                if number == 1 and not line.startswith("# "):
                    faults.append("no title")
                if len(line) > WIDTH:
                    faults.append("%d columns" % len(line))
                if os.path.basename(name) == "README.md" and number > (ROOT_LINES if name == "README.md" else README_LINES):
                    faults.append("the page is too long")
                for fault in faults:
                    print("%s:%d: %s" % (name, number, fault))
                found += len(faults)
    if found:
        sys.exit(1)


if __name__ == "__main__":
    main()
