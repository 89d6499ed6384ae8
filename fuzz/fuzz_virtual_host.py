"""What hosts say to virtual boards: any messages are obeyed or passed over, and they go on."""

from skinfield.emulator import VirtualSettings, VirtualSkin

SEEDS = [
    bytes.fromhex("0102044d0005f0 01020750000f02010022 0102020700"),
    b"\x01\x05\x05\x37\x01\x01\x00\x00" + b"\x01\x05\x04\x3b\x01\x00\x00",
    b"SF\x01\x20\x01\x00\x00\x00" + bytes(18),
]
NOW = 10**18  # ns; it stands still, so that a schedule that was made stays in time
PLAIN = {"bus": "udp", "scene": "idle", "control": "", "skin": "icub_triangle"}
SKINS = [VirtualSkin(VirtualSettings(hardware=name, **PLAIN)) for name in ("icub", "cyskin")]
DEVICE = VirtualSkin(VirtualSettings(**{**PLAIN, "hardware": "packet", "channels": ("listen",)}))


def one_input(data: bytes) -> None:
    """Three bytes of identifier and length and then data, again and again; and as one stream."""
    now_ns = NOW
    for skin in SKINS:
        at = 0
        while at + 3 <= len(data):
            length = min(data[at + 2], 8)
            identifier = data[at] | (data[at + 1] & 7) << 8
            skin.hardware._obey(0, identifier, data[at + 3 : at + 3 + length], 0.0)  # type: ignore[attr-defined]
            at += 3 + length
        skin.hardware.reschedule(now_ns)
        assert skin.hardware.schedule.next_ns > now_ns - 10**9
    hear(data, now_ns)


def hear(data: bytes, now_ns: int) -> None:
    """The bytes as what a host sends to a device."""
    devices = DEVICE.hardware
    link = devices._wire  # type: ignore[attr-defined]
    link.receive = lambda: data
    devices.listen(now_ns, 0.0)
    del link.receive
