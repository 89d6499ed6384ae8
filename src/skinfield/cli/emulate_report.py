"""What `skinfield emulate` says of itself, on stderr."""

from typing import TYPE_CHECKING, Any

from rich.console import Console

if TYPE_CHECKING:
    from skinfield.virtual import VirtualSkin

MISHAPS = ("skipped", "lost", "duplicated", "swapped", "refused", "withheld")


def introduce(skin: "VirtualSkin", shown: Console) -> None:
    """What it is and where."""
    settings = skin.settings
    patches = ", ".join(f"{patch.name} ({len(patch)} taxels)" for patch in skin.skin)
    shown.print(f"{settings.hardware} skin: {patches}", highlight=False, soft_wrap=True)
    where = ", ".join(skin.hardware.addresses)
    shown.print(f"{settings.bus} at {where}; scene {skin.world.scene.name}", highlight=False)
    if skin.control_address:
        shown.print(f"presses and faults: JSON by UDP to {skin.control_address}", highlight=False)
    for note in skin.notes:
        shown.print(f"note: {note}", style="yellow", highlight=False, markup=False)


def line_of(skin: "VirtualSkin") -> str:
    """What is going on, in a line."""
    if not skin.stream_ns:
        return "waiting for a host"
    counts = skin.counts()
    rate = counts["readings"] / max(counts["streamed_seconds"], 1e-9)
    parts = [f"{counts['streamed_seconds']:.0f} s", f"{counts['messages']:,} messages"]
    parts.append(f"{rate:,.0f} readings/s")
    parts += [f"{counts[name]:,} {name}" for name in MISHAPS if counts[name]]
    presses = skin.pressing
    parts.append(
        ", ".join(f"{t.force:.2f} N at {t.x * 1e3:.1f} {t.y * 1e3:.1f} mm" for t in presses[:3])
        or "nothing presses"
    )
    return " | ".join(parts)


def sum_up(counts: dict[str, Any], shown: Console) -> None:
    """What was sent in all, and what became of it."""
    said = [f"{counts['messages']:,} messages of {counts['readings']:,} readings sent"]
    said += [f"{counts[name]:,} {name}" for name in MISHAPS]
    shown.print(", ".join(said), highlight=False, soft_wrap=True)
    if counts["faults"]:
        began = ", ".join(f"{kind} {count}" for kind, count in counts["faults"].items())
        shown.print(f"faults that began: {began}", highlight=False, soft_wrap=True)
    if counts["skipped"]:
        shown.print(
            f"{counts['skipped']:,} readings came too late and were skipped: this machine was "
            "too busy for the rate",
            style="yellow",
            highlight=False,
            soft_wrap=True,
        )
    if counts["refused"] and not counts["messages"]:
        shown.print(
            f"nothing went out: no host has spoken to {', '.join(counts['channels'])}",
            style="yellow",
            highlight=False,
        )
    for note in counts["notes"]:
        shown.print(f"note: {note}", style="yellow", highlight=False, markup=False)
