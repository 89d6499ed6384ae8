"""What the page tells of an engine."""

from pathlib import PurePath
from typing import Any


def without_paths(status: dict[str, Any]) -> dict[str, Any]:
    """The status of an engine; where on its machine it records is nobody else's business."""
    beside = status.get("beside") or {}
    recorder = beside.get("recorder")
    if not isinstance(recorder, dict) or "path" not in recorder:
        return status
    recorder = {**recorder, "path": PurePath(recorder["path"]).name}
    return {**status, "beside": {**beside, "recorder": recorder}}
