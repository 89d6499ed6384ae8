"""Picture of tutorials/own-array.md: that of `skinfield new` on the page's own data.

python docs/figures/own_array.py    docs/images/own-array.png
"""

import os
import re
import shlex
import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

from skinfield.cli import main

DOCS = Path(__file__).resolve().parents[1]
PAGE = DOCS / "tutorials" / "own-array.md"


def draw() -> None:
    """Follow the page as far as its first command, and keep the picture."""
    text = PAGE.read_text(encoding="utf-8")
    code = re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)[0]
    command = re.findall(r"^```sh\n(.*?)\n```$", text, re.MULTILINE | re.DOTALL)[0]
    with TemporaryDirectory() as folder:
        os.chdir(folder)
        exec(compile(code, str(PAGE), "exec"), {})
        try:
            main(shlex.split(command)[1:])
        except SystemExit as ended:
            if ended.code:
                raise
        shutil.copy("my_skin.png", DOCS / "images" / "own-array.png")
        os.chdir(DOCS)


if __name__ == "__main__":
    draw()
