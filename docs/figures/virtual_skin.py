"""Make the picture of virtual-skin.md: half a minute.

python docs/figures/virtual_skin.py
"""

import time
from pathlib import Path

import numpy as np

from skinfield.emulator import VirtualSettings
from skinfield.emulator.process import start
from skinfield.plot import BLUE, FAINT, INK, ORANGE, QUIET, add_title, new_figure, save, style
from skinfield.wire.can import BusSettings, open_bus
from skinfield.wire.can.messages import CanMessages

SECONDS, RATE = 12.0, 100.0
FAULTS = ("unplug 2@5s+1.5s", "reboot 0@8s+1s")
SETUP = ("4D 02 0A F0", "50 00 0F 02 01 00 22", "07 00")


def stream() -> tuple[np.ndarray, np.ndarray, list[dict]]:
    """Stamps (N,) s and rows (N, 4) of identifier, head or tail and ... of what arrives; truth."""
    settings = VirtualSettings(
        bus="udp", rate=RATE, scene="slide", lead_in=0.5, fault=FAULTS, seed=1
    )
    into = CanMessages(1 << 16)
    stamps, rows = [], []
    with start(settings) as skin:
        bus = open_bus(BusSettings("udp", port=0, peer=skin.channels[0]))
        end = time.monotonic() + SECONDS
        told = 0.0
        while time.monotonic() < end:
            if time.monotonic() - told > 1.0 and (not rows or silent(stamps)):
                told = time.monotonic()
                for words in SETUP:
                    bus.send(0x201, bytes.fromhex(words))
            for row in range(bus.receive(into)):
                stamps.append(into.stamp_ns[row] * 1e-9)
                rows.append((int(into.ids[row]), *into.data[row].tolist()))
            time.sleep(0.005)
        truth = skin.truth()
        bus.close()
    return np.array(stamps), np.array(rows), truth


def silent(stamps: list[float]) -> bool:
    """Whether nothing came for half a second."""
    return time.time() - stamps[-1] > 0.5


def of_taxel(stamps: np.ndarray, rows: np.ndarray, taxel: int) -> tuple[np.ndarray, np.ndarray]:
    """Times and bytes of one taxel."""
    triangle, place = divmod(taxel, 12)
    mine = (rows[:, 0] & 15 == triangle) & (rows[:, 1] == (0x40 if place < 7 else 0xC0))
    return stamps[mine], rows[mine, 2 + place if place < 7 else place - 5]


def main() -> None:
    """Draw the bytes of the taxels that the finger passes, and the force that it really has."""
    stamps, rows, truth = stream()
    start_s = stamps[0]
    figure = new_figure(9.0, 4.6)
    bytes_, force = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    lowest = {t: of_taxel(stamps, rows, t)[1].min() for t in range(72) if t // 12 != 2}
    chosen = sorted(lowest, key=lambda t: lowest[t])[:3]
    for taxel, colour in zip([*chosen, 26], (BLUE, ORANGE, INK, QUIET), strict=True):
        times, values = of_taxel(stamps, rows, taxel)
        bytes_.plot(times - start_s, values, ".", ms=2.0, color=colour, label=f"taxel {taxel}")
    for first, last, what in ((5.0, 6.5, "triangle 2 unplugged"), (8.0, 9.0, "board reboots")):
        bytes_.axvspan(first, last, color=FAINT, alpha=0.4, lw=0, zorder=0)
        bytes_.text((first + last) / 2, 100, what, ha="center", fontsize=8, color=INK)
    bytes_.set_ylabel("byte sent")
    bytes_.legend(loc="center left", fontsize=8, frameon=False, markerscale=3)
    times = [line["stamp_ns"] * 1e-9 - start_s for line in truth]
    total = [sum(press["force"] for press in line["presses"]) for line in truth]
    force.step(times, total, where="post", color=INK)
    force.set_xlim(0, stamps[-1] - start_s)
    force.set_ylabel("truth, N")
    force.set_xlabel("s since the first reading")
    note = "bytes as they arrive over UDP, a hundred readings a second, and the force that is true"
    add_title(bytes_, "", "A finger slides over the virtual skin", note)
    figure.subplots_adjust(left=0.08, right=0.97, bottom=0.12, top=0.88, hspace=0.1)
    save(figure, str(Path(__file__).parents[1] / "images" / "virtual-skin.png"))


if __name__ == "__main__":
    with style():
        main()
