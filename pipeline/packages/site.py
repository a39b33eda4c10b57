#!/usr/bin/env python3
"""site.py OUT: all pages of the project as a site in OUT, by pandoc (Debian's package). Each keeps its place, with README.md as
index.html, and the files that a page links go with it. Exits 1 if a link leads nowhere.
"""
import html
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
TEMPLATE = pathlib.Path(__file__).with_name("site.html")
IGNORED = re.compile(r"^(\..*|build.*|out|node_modules|shared)$")  # not part of the repository
LINK = re.compile(r'(?<= )(href|src)="([^"]*)"')


def pages():
    for folder, folders, files in os.walk(ROOT):
        folders[:] = sorted(name for name in folders if not IGNORED.match(name))
        yield from (pathlib.Path(folder, name) for name in sorted(files) if name.endswith(".md"))


def place_of(path):
    """The file in the site, relative to it, of a file of the project."""
    path = path.relative_to(ROOT)
    if path.suffix == ".md":
        path = path.with_name("index.html") if path.name == "README.md" else path.with_suffix(".html")
    return path


class Site:
    def __init__(self, out):
        self.out, self.ids, self.links, self.broken = out, {}, [], []

    def add(self, page):
        place = place_of(page)
        with open(page, encoding="utf-8") as lines:
            title = lines.readline().lstrip("# ").strip()
        up = "../" * (len(place.parts) - 1)
        text = subprocess.run(
            ["pandoc", "--from=gfm", "--to=html5", "--standalone", f"--template={TEMPLATE}", f"--variable=up={up}",
             f"--metadata=pagetitle={title}", page], check=True, capture_output=True, text=True).stdout
        self.ids[place] = set(re.findall(r' id="([^"]*)"', text))
        text = LINK.sub(lambda link: f'{link[1]}="{self.target(page, link[2])}"', text)
        (self.out / place).parent.mkdir(parents=True, exist_ok=True)
        (self.out / place).write_text(text, encoding="utf-8")

    def target(self, page, link):
        """The link as the site has it. A file that is no page is copied."""
        path, hash_, fragment = html.unescape(link).partition("#")
        if re.match(r"[a-z]+:", path):
            return link
        source = pathlib.Path(os.path.normpath(page.parent / path)) if path else page
        if source.is_dir():
            source = source / "README.md"
        if not source.is_relative_to(ROOT) or not source.exists():
            self.broken.append(f"{page.relative_to(ROOT)}: {link} leads nowhere")
            return link
        place = place_of(source)
        if place.suffix != ".html":
            (self.out / place).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, self.out / place)
        elif fragment:
            self.links.append((page, link, place, fragment))
        return html.escape(os.path.relpath(place, place_of(page).parent) + hash_ + fragment)

    def check(self):
        for page, link, place, fragment in self.links:
            if fragment not in self.ids[place]:
                self.broken.append(f"{page.relative_to(ROOT)}: {link} names no heading")
        return self.broken


if __name__ == "__main__":
    site = Site(pathlib.Path(sys.argv[1]))
    for source_page in pages():
        site.add(source_page)
    faults = site.check()
    print(*faults, f"{len(site.ids)} pages in {sys.argv[1]}", sep="\n")
    sys.exit(1 if faults else 0)
