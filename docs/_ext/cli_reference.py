"""Reference of the command line: a page for each command, of what its help holds.

Written into docs/reference/cli when the site is built, from the app itself: whatever a command
takes stands there, under the same headings, with the same words and defaults.
"""

import re
import shutil
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

from skinfield.cli.main import COMMANDS, LAB, app_for

UNLISTED = {
    "info": "Recordings",
    "recover": "Recordings",
    "warmup": "Machine",
}  # under a heading here
RUNNING = "A running skin"  # the other commands that help lists under no heading
RESEARCH = "Research"


class Collected:
    """A formatter of help that keeps what it is given, in place of printing it."""

    def __init__(self) -> None:
        self.usage = self.description = ""
        self.panels: list[Any] = []

    def render_usage(self, console: Any, options: Any, usage: Any) -> None:
        """Keep the line of usage."""
        self.usage = _plain(usage)

    def render_description(self, console: Any, options: Any, description: Any) -> None:
        """Keep the text above the options."""
        self.description = _plain(description)

    def __call__(self, console: Any, options: Any, panel: Any) -> None:
        """Keep a panel: its heading and entries."""
        self.panels.append(panel)


def _plain(text: Any) -> str:
    """Text without the markup of a terminal."""
    text = getattr(text, "primary_renderable", text)
    return str(getattr(text, "plain", text or "")).strip("\n")


def _prose(text: str) -> str:
    """Text of help as reStructuredText: code in backquotes, flags as code, pages as links."""
    parts = re.split(r"`([^`]+)`|(?<![\w-])(--?[a-z][\w-]*)|docs/(\S+)\.md", text)
    for start in range(1, len(parts), 4):
        code, flag, page = parts[start : start + 3]
        parts[start : start + 3] = [f":doc:`/{page}`" if page else f"``{code or flag}``", "", ""]
    parts[::4] = [re.sub(r"([\\*`|_])", r"\\\1", part) for part in parts[::4]]
    return "".join(parts)


def _paragraphs(text: str) -> str:
    """Paragraphs, and examples, which are indented in help, as blocks to copy."""
    made = []
    for block in text.split("\n\n"):
        lines = block.splitlines()
        if lines and all(line.startswith("  ") for line in lines):
            language = "sh" if lines[0].startswith("  skinfield ") else "text"
            made.append(f".. code-block:: {language}\n\n{block}")
        else:
            made.append(_prose(" ".join(line.strip() for line in lines)))
    return "\n\n".join(made)


def _option(entry: Any) -> str:
    """One option or argument as Sphinx's directive, which makes it a target of links."""
    names = [*entry.names, *entry.shorts]
    value = f" {entry.metavar}" if entry.metavar else ""
    heading = ", ".join(f"{name}{value}" for name in names) or f"{entry.positional_label}"
    said = [_prose(" ".join(_plain(entry.description).split()))]
    if entry.choices:
        said.append("One of " + ", ".join(f"``{each}``" for each in entry.choices) + ".")
    if entry.required:
        said.append("Required.")
    if entry.default not in (None, ""):
        said.append(f"Default ``{entry.default}``.")
    return f".. option:: {heading}\n\n   {' '.join(part for part in said if part)}"


def _heading(text: str, mark: str) -> str:
    return f"{text}\n{mark * len(text)}"


def _section(words: tuple[str, ...], mark: str, also: str = "-") -> str:
    """What help says of one command: description, usage, its arguments and options by headings."""
    app = app_for(words)
    found = Collected()
    for depth in range(len(words) + 1):
        part = app
        for word in words[:depth]:
            part = part[word]
        part.help_formatter = found
    app.help_print(words)
    name = " ".join(("skinfield", *words))
    parts = [_heading(name, mark), f".. program:: {name}", _paragraphs(found.description)]
    usage = found.usage.replace("Usage: ", "").strip()
    parts.append(f".. code-block:: text\n\n   {usage}")
    inner = ""
    for panel in found.panels:
        if panel.format == "command":
            inner = "\n\n".join(_section((*words, *_names(entry)), also) for entry in panel.entries)
        elif panel.entries:
            parts.append(f".. rubric:: {_plain(panel.title)}")
            parts += map(_option, panel.entries)
    return "\n\n".join([*parts, inner])


def _names(entry: Any) -> tuple[str, ...]:
    return tuple(entry.names[:1])


def write(app: Sphinx) -> None:
    """Write the pages, and an index of them by headings."""
    folder = Path(app.srcdir) / "reference" / "cli"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    groups: dict[str, list[tuple[str, str]]] = {}
    for name, lazy in COMMANDS.items():
        lab = name in LAB
        group = RESEARCH if lab else lazy.group or UNLISTED.get(name, RUNNING)
        groups.setdefault(group, []).append((name, lazy.help))
        words = ("lab", name) if lab else (name,)
        (folder / f"{name}.rst").write_text(_section(words, "=") + "\n", encoding="utf-8")
    parts = [
        _heading("Command line", "="),
        "Every command of ``skinfield``, with all that it takes. ``--help`` says the same in the "
        "terminal. ``skinfield run FILE`` takes any of its settings "
        ":doc:`from a file </reference/settings>`.",
    ]
    for group, commands in groups.items():
        rows = [f":doc:`{name}`\n   {_prose(text)}" for name, text in commands]
        tree = ".. toctree::\n   :hidden:\n\n" + "\n".join(f"   {name}" for name, _ in commands)
        parts += [_heading(group, "-"), *rows, tree]
    (folder / "index.rst").write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the pages before Sphinx looks for them."""
    app.connect("builder-inited", write)
    return {"parallel_read_safe": True}
