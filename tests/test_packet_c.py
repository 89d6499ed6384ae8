"""The C header and the Arduino sketch, compiled and run; Python reads what they send."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from packet_reference import decode, packets_of

import skinfield
from skinfield.signal import Blocks, Channels, Count, counters
from skinfield.wire.packet import (
    Hello,
    PacketDecoder,
    PacketDevice,
    PacketEncoder,
    PacketKind,
    encode_command,
)

HEADER = Path(skinfield.__file__).parent / "wire" / "packet" / "skinfield_packet.h"
SKETCH = Path(__file__).resolve().parents[1] / "examples" / "arduino" / "skinfield_sketch"
WARNINGS = ["-Wall", "-Wextra", "-Wconversion", "-Wno-unused-function", "-Werror", "-pedantic"]
PROGRAM = r"""
#include <stdio.h>
#include "skinfield_packet.h"

int main(void) {
  static uint8_t packet[SKINFIELD_ROOM(SKINFIELD_LONGEST_PAYLOAD)];
  static uint16_t shorts[300];
  const uint8_t bytes[3] = {1, 2, 255};
  const int16_t signeds[2] = {-5, 5};
  const float floats[2] = {0.5f, -2.0f};
  skinfield_sender sender = {7, 0, 0, 0, 0};
  size_t n;
  int i;
  for (i = 0; i < 300; i++) shorts[i] = (uint16_t)(i * 200);
#define PUT fwrite(packet, 1, n, stdout)
  n = skinfield_pack_hello(&sender, packet, 300, SKINFIELD_SHORTS, 0, 1000, "palm"), PUT;
  skinfield_begin_reading(&sender, 1000);
  n = skinfield_pack(&sender, packet, SKINFIELD_SHORTS, 0, 200, shorts, 0), PUT;
  n = skinfield_pack(&sender, packet, SKINFIELD_SHORTS, 200, 100, shorts + 200, 1), PUT;
  skinfield_begin_reading(&sender, 2000);
  sender.status = SKINFIELD_NO_ACK;
  n = skinfield_pack(&sender, packet, SKINFIELD_BYTES, 0, 3, bytes, 1), PUT;
  n = skinfield_pack(&sender, packet, SKINFIELD_SIGNED, 3, 2, signeds, 1), PUT;
  n = skinfield_pack(&sender, packet, SKINFIELD_FLOATS, 5, 2, floats, 1), PUT;
  n = skinfield_pack(&sender, packet, SKINFIELD_FLOATS, 0, 1017, floats, 1);
  return n == 0 ? 0 : 1;
}
"""
LISTENER = r"""
#include <stdio.h>
#include "skinfield_packet.h"

int main(void) {
  skinfield_sender sender = {7, 0, 0, 0, 0};
  skinfield_ear ear;
  skinfield_header head;
  uint32_t argument;
  int c;
  memset(&ear, 0, sizeof ear);
  while ((c = getchar()) != EOF) {
    int kind = skinfield_hear(&ear, &sender, (uint8_t)c, &head, &argument);
    if (kind) printf("%d %u %u\n", kind, (unsigned)argument, (unsigned)head.sequence);
  }
  return 0;
}
"""
CHECKER = r"""
#include <stdio.h>
#include <stdlib.h>
#include "skinfield_packet.h"

int main(void) { /* what Python sent, found again with the C reader; garbage is dropped */
  static uint8_t data[1 << 20];
  size_t size = fread(data, 1, sizeof data, stdin), at = 0;
  while (at < size) {
    skinfield_header head;
    long found = skinfield_find(data + at, size - at, &head);
    if (found > 0) printf("%u %u %u %u\n", head.kind, head.device, (unsigned)head.sequence, head.count);
    if (found == 0) break;
    at += found > 0 ? (size_t)found : 1;
  }
  return 0;
}
"""  # noqa: E501
ARDUINO = r"""
#pragma once
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
extern uint32_t now_us;
inline uint32_t micros() { return now_us; }
struct Port {
  std::string heard;
  void begin(long) {}
  size_t available() { return heard.size(); }
  int read() { int c = (uint8_t)heard[0]; heard.erase(0, 1); return c; }
  size_t write(const uint8_t *data, size_t size) { return fwrite(data, 1, size, stdout); }
};
extern Port Serial;
"""
WIRE = r"""
#pragma once
struct Bus {  // four boards whose electrode e reads 100 * board + e
  int board = 0, at = 0;
  void begin() {}
  void setClock(long) {}
  void beginTransmission(int address) { board = address - 0x5A; }
  void write(uint8_t) {}
  void endTransmission(bool = true) {}
  void requestFrom(int address, int) { board = address - 0x5A; at = 0; }
  int read() { int v = 100 * board + at / 2; return at++ % 2 ? v >> 8 : v & 255; }
};
extern Bus Wire;
"""
RUNNER = r"""
#include "Arduino.h"
#include "Wire.h"
uint32_t now_us = 4294900000u;  // wraps around on the way
Port Serial;
Bus Wire;
#include "sketch.cpp"
int main() {
  setup();
  for (int i = 0; i < 100; i++, now_us += 1000) {
    if (i == 50) for (int c; (c = getchar()) != EOF;) Serial.heard.push_back((char)c);
    loop();
  }
}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("packets")


def run(folder: Path, name: str, text: str, heard: bytes = b"", *, language: str = "c") -> bytes:
    """Compile and run a small program; skips where there is no compiler."""
    compiler = shutil.which("cc" if language == "c" else "c++")
    if compiler is None:
        pytest.skip(f"no {language} compiler here: install one to test the C header")
    source, program = folder / f"{name}.{language}", folder / name
    source.write_text(text)
    flags = ["-std=c99", *WARNINGS] if language == "c" else ["-std=c++11", "-Wall"]
    command = [compiler, *flags, f"-I{HEADER.parent}", f"-I{folder}", str(source)]
    subprocess.run([*command, "-o", str(program)], check=True, timeout=120)
    done = subprocess.run([str(program)], input=heard, capture_output=True, check=True, timeout=60)
    return done.stdout


def test_packets_of_c_are_read(folder: Path) -> None:
    data = run(folder, "sender", PROGRAM)
    found = list(packets_of(data))
    assert [p.kind for p in found] == [16, 2, 2, 1, 5, 3]
    assert [p.sequence for p in found] == list(range(6))
    assert [p.reading for p in found] == [0, 1, 1, 2, 2, 2]
    assert [p.flags for p in found] == [1, 0, 1, 1, 1, 1]
    assert {p.device for p in found} == {7}
    hello = Hello(channels=300, kind=2, period_us=1000, name="palm")
    assert found[0].payload == hello.payload
    decoder, blocks, seen = PacketDecoder([PacketDevice(7, 300)]), Blocks(1 << 14), counters()
    assert decode(decoder, data, blocks, seen) == 6
    state = Channels(300)
    state.apply(blocks)
    expected = np.arange(300.0) * 200
    expected[:7] = [1, 2, 255, -5, 5, 0.5, -2]
    np.testing.assert_array_equal(state.counts, expected)
    assert state.status[:8].tolist() == [1] * 7 + [0]
    assert seen[Count.MALFORMED] == 0


def test_commands_are_heard_in_c(folder: Path) -> None:
    heard = b"SFSS" + encode_command(PacketKind.START, sequence=3)
    heard += encode_command(PacketKind.PERIOD, device=7, sequence=4, period_us=2500)
    heard += encode_command(PacketKind.STOP, device=8) + b"SF\x01" + bytes(40)
    heard += encode_command(PacketKind.ASK, device=7, sequence=9)
    assert run(folder, "listener", LISTENER, heard).split() == b"32 0 3 34 2500 4 36 0 9".split()


def test_packets_of_python_are_found_in_c(folder: Path) -> None:
    encoder = PacketEncoder(1000, device=3)
    data = b"noise" + b"".join(encoder.encode(np.arange(1000), 5)) + b"SF\x01\x02"
    lines = run(folder, "checker", CHECKER, data).decode().splitlines()
    assert lines == ["2 3 0 723", "2 3 1 277"]


def test_sketch_compiles_and_speaks(folder: Path) -> None:
    sketch = SKETCH / "skinfield_sketch.ino"
    assert len(sketch.read_text().splitlines()) <= 40
    for name, text in (("Arduino.h", ARDUINO), ("Wire.h", WIRE), ("sketch.cpp", "")):
        (folder / name).write_text(text or sketch.read_text())
    heard = encode_command(PacketKind.ASK) + encode_command(PacketKind.PERIOD, period_us=5000)
    found = list(packets_of(run(folder, "sketch_runs", RUNNER, heard, language="cpp")))
    assert [p.kind for p in found] == [16] + [2] * 5 + [16] + [2] * 10
    assert [p.sequence for p in found] == list(range(17))
    assert found[1].values == tuple(100 * b + e for b in range(4) for e in range(12))
    assert [p.time_us for p in found[1:4]] == [4294900000, 4294910000, 4294920000]
    steps = np.diff([p.time_us for p in found[7:]]) % 2**32
    assert steps.tolist() == [5000] * 9
    assert found[6].payload.endswith(b"\x06mpr121")
