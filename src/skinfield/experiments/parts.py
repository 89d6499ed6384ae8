"""Parts of experiments as tasks of a campaign: kept, and void once the program is another."""

import hashlib
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

from skinfield.campaign import Task
from skinfield.experiments.report import plain
from skinfield.experiments.section import Part


def tasks_of(parts: Sequence[Part], prefix: str) -> list[Task]:
    """One task each, named after the experiment and the part."""
    return [Task(f"{prefix}.{part.name}", make_part, (part,), version=program()) for part in parts]


def make_part(folder: Path, part: Part) -> Any:
    """Run one part; what is not a number is None, as in JSON."""
    return plain(part.function(*part.arguments))


@lru_cache(maxsize=1)
def program() -> str:
    """Digest of skinfield's own sources."""
    root = Path(__file__).parents[1]
    digest = hashlib.sha256()
    for file in sorted([*root.rglob("*.py"), *root.rglob("*.html")]):
        digest.update(str(file.relative_to(root)).encode() + file.read_bytes())
    return digest.hexdigest()
