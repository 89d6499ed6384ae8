import numpy as np
import pytest
from bus_peers import wait_for
from icub_triangle import triangle_payloads
from virtual_host import SECOND, START, Host, Stepped, byte_of, bytes_by_channel

from skinfield.elastic import Layer
from skinfield.emulator import Fault, VirtualSettings, VirtualSkin, Wires
from skinfield.emulator.transports import Request
from skinfield.errors import InputError
from skinfield.files.layouts.load import save_layout
from skinfield.simulate import Sphere, press
from skinfield.skin import Skin
from skinfield.skin.generators import by_name

REST = [bytes.fromhex("40 f0f0f0f0f0f0f0"), bytes.fromhex("c0 f0f0f0f0f0 0000")]
COUNTS_PER_CHANGE = 0.16689e-12 / (16e-12 / 65536)  # pad of 4 mm, converter of 16 pF in 16 bits


@pytest.fixture
def stepped():
    with Stepped(at_once=True) as made:
        yield made


def test_a_skin_at_rest_sends_the_golden_bytes(stepped):
    messages = stepped.step()
    assert [identifier for identifier, _ in messages] == [0x410 + i // 2 for i in range(12)]
    assert [data for _, data in messages] == REST * 6


def test_boards_are_silent_until_they_are_configured_and_started():
    with Stepped() as stepped:
        assert stepped.step() == []
        for message in ("4D 02 01 F5", "50 00 02 02 01 00 22"):
            stepped.tell(message)
            assert stepped.step() == []
        stepped.tell("07 00")
        messages = stepped.step()
        assert {identifier for identifier, _ in messages} == {0x410, 0x411, 0x412}
        assert all(set(data[1:6]) == {0xF5} for _, data in messages)  # the rest that was told
        stepped.tell("07 01")
        assert stepped.step() == []


def test_the_host_sets_the_period_unless_a_rate_is_given():
    for rate, readings in ((None, 4), (1000.0, 20)):  # 20 ms at 5 ms, or at 1 ms
        with Stepped(rate=rate) as stepped:
            stepped.tell("4D 02 05 F0", *START[1:])
            heads = [m for _ in range(20) for m in stepped.step(0.001) if m[0] == 0x410]
            assert len(heads) == 2 * readings


def test_a_press_reads_as_the_forward_model_says(stepped):
    stepped.step()
    patch = stepped.skin.skin.patches[0]
    place = (patch.plane[40] + [1.3e-3, -0.7e-3]).tolist()
    stepped.skin.world.press(Request(x=place[0], y=place[1], force=5.0))
    found = bytes_by_channel(stepped.step())[patch.channel]
    made = press(Layer(), [Sphere(radius=10e-3, force=5.0)], cell=0.25e-3, extent=30e-3)
    exact = made.capacitance(patch.plane - place, patch.pad_diameter)
    expected = [byte_of(round(COUNTS_PER_CHANGE * each)) for each in exact]
    assert np.abs(found - expected).max() <= 1  # a step, where rounding tips over
    assert min(expected) < 200
    assert np.mean(found != expected) < 0.2


def test_presses_that_are_apart_add_up(stepped):
    world = stepped.skin.world

    def change():
        world.update(-1.0, stepped.skin.hardware.converters.change)
        return stepped.skin.hardware.converters.change.copy()

    world.press(Request(taxel=3, id="one"))
    one = change()
    world.press(Request(taxel=60, force=0.5, id="two"))
    both = change()
    world.release(Request(id="one"))
    np.testing.assert_allclose(both, one + change(), atol=1e-12)
    world.release(Request())
    assert not change().any()


def test_an_unplugged_triangle_says_so():
    with Stepped(skin="ten_pad_triangle", at_once=True, fault=("unplug 0@0.1s",)) as one:
        assert one.step()[1][1][7] & 2 == 0
        for _ in range(12):
            messages = one.step()
        base = one.skin.hardware._base[0]
        expected = triangle_payloads(np.full(12, 0xFFFF), base)
        assert tuple(data for _, data in messages) == expected
        assert messages[1][1][7] & 2


def test_a_board_that_boots_is_silent_and_wants_to_be_configured_again():
    with Stepped(fault=("reboot 0@0.2s+0.1s",)) as stepped:
        stepped.tell(*START)
        sent = [len(stepped.step()) for _ in range(20)]
        assert sent[:19] == [12] * 19
        stepped.step()
        commands = stepped.skin.counts()["commands"]
        stepped.host.tell(*START)  # it hears nothing while it boots
        for _ in range(50):
            stepped.skin.hardware.listen(stepped.now_ns, 0.0)
        assert stepped.skin.counts()["commands"] == commands
        assert [len(stepped.step()) for _ in range(20)] == [0] * 20
        assert stepped.skin.counts()["reboots"] == 1
        stepped.tell(*START)
        assert len(stepped.step()) == 12


def test_a_bus_that_is_gone_counts_what_it_withholds():
    with Stepped(at_once=True, fault=("bus-off 0@0.095s+0.1s",)) as stepped:
        sent = [len(stepped.step()) for _ in range(30)]
        counts = stepped.skin.counts()
        assert sum(sent) == counts["messages"]
        assert counts["withheld"] == 12 * 30 - counts["messages"] == 12 * sent.count(0)
        assert sent.count(0) == 10
        assert sent[-1] == 12


@pytest.mark.parametrize(
    ("kind", "byte"), [("dead", 240), ("saturated", 0), ("no-ack", 255), ("stuck", None)]
)
def test_a_taxel_with_a_fault_does_not_feel(stepped, kind, byte):
    stepped.step()
    stepped.skin.world.press(Request(taxel=7, force=0.4))
    pressed = bytes_by_channel(stepped.step())
    stepped.skin.faults.add(Fault(kind, "7", 0.03, 0.05))
    for _ in range(4):
        stepped.step()
    stepped.skin.world.press(Request(taxel=7, force=2.0, id="press-1"))
    stepped.skin.faults.add(Fault("dead", "*", 1e6))  # far away: changes nothing
    messages = stepped.step()
    found = bytes_by_channel(messages)
    assert found[7] == (pressed[7] if byte is None else byte)
    tail = next(data for identifier, data in messages if identifier == 0x410 and data[0] == 0xC0)
    assert (tail[7] & 1) == (kind == "no-ack")
    for _ in range(5):
        found = bytes_by_channel(stepped.step())
    assert found[7] < pressed[7] - 10  # it feels again


def converted(stepped):
    """Counts (2000, taxels) of one scan after the other."""
    rows, converters = [], stepped.skin.hardware.converters
    for _ in range(2000):
        converters.convert(0.0)
        rows.append(converters.counts.copy())
    return np.array(rows)


def test_noise_has_the_spread_that_is_asked_for():
    with Stepped(at_once=True, noise_scale=1.0, seed=5) as stepped:
        measured, asked = np.std(converted(stepped), axis=0), stepped.skin.hardware.converters.white
        np.testing.assert_allclose(measured, np.hypot(asked, 12**-0.5), rtol=0.12)
        assert np.median(asked) == pytest.approx(4 * 3.1, rel=0.3)
    with Stepped(at_once=True, common_noise=2.0) as stepped:  # shared by a triangle
        together = np.corrcoef(converted(stepped)[:, :24].T)
        assert together[0, 11] > 0.95
        assert abs(together[0, 12]) < 0.1


def test_thermal_pads_take_the_drift_off() -> None:
    with Stepped(skin="ten_pad_triangle", at_once=True, temperature="25..35@0.001s") as one:
        one.step()
        found = bytes_by_channel(one.step(1.0))[one.skin.skin.patches[0].channel]
        assert np.abs(found - 240).max() <= 1
        drift = one.skin.hardware.converters.drift[: len(found)]
        assert np.abs(10.0 * drift).max() > 1 << 3  # which is more than a byte without them


def test_the_base_that_a_board_takes_has_the_press_in_it(stepped):
    stepped.step()
    stepped.skin.world.press(Request(taxel=7, force=1.0))
    stepped.step()
    stepped.tell("50 00 0F 02 01 00 22", "07 00")
    assert set(bytes_by_channel(stepped.step())[:72]) == {240}
    stepped.skin.world.release(Request())
    assert bytes_by_channel(stepped.step())[7] == 255


def test_what_a_host_said_while_the_process_was_held_up_is_passed_over(stepped):
    """It took the boards for silent: configured anew, they would take the press for their base."""
    skin, pressed = stepped.skin, []
    stepped.step()
    skin.world.press(Request(taxel=7, force=1.0))
    for _ in range(2):
        pressed.append(bytes_by_channel(stepped.step())[7])
        skin._wait(set())
        stepped.now_ns += 3 * SECOND
        stepped.host.tell(*START)
        skin._wait(set())
    assert skin.hardware.commands == 0
    assert pressed[0] == pressed[1] != 240
    stepped.now_ns += SECOND // 100
    stepped.host.tell(*START)  # of now
    wait_for(lambda: (skin._wait(set()), skin.hardware.commands == 3)[1])
    assert set(bytes_by_channel(stepped.step())[:72]) == {240}


def test_boards_that_do_not_send_yet_hear_whatever_came():
    with Stepped() as stepped:
        stepped.skin._wait(set())
        stepped.now_ns += 3 * SECOND
        stepped.host.tell(*START)
        hardware = stepped.skin.hardware
        wait_for(lambda: (stepped.skin._wait(set()), hardware.commands == 3)[1])


def test_every_fault_of_the_wire_is_counted_exactly():
    wires = Wires(lose=0.05, duplicate=0.04, swap=0.03)
    with Stepped(at_once=True, wires=wires, seed=3) as stepped:
        received = [m for _ in range(300) for m in stepped.step()]
        counts = stepped.skin.counts()
        assert counts["readings"] == 300
        assert len(received) == counts["messages"]
        made = 300 * 12
        kept_back = len(stepped.skin.hardware.wires[0].waiting)
        assert made == len(received) + counts["lost"] - counts["duplicated"] + kept_back
        for name, chance in (("lost", 0.05), ("duplicated", 0.04), ("swapped", 0.03)):
            assert counts[name] == pytest.approx(made * chance, rel=0.3)


def test_readings_that_are_too_late_are_skipped_and_counted():
    with Stepped(at_once=True) as stepped:
        assert len(stepped.step()) == 12
        assert len(stepped.step(0.155)) == 12  # one burst, not fifteen
        counts = stepped.skin.counts()
        assert (counts["readings"], counts["skipped"]) == (2, 13)


def test_a_whole_robot_needs_several_buses():
    skin = "rectangular:rows=40,columns=60"  # 2400 channels: 13 boards
    with pytest.raises(InputError, match="expected 1: one for each bus"):
        VirtualSkin(VirtualSettings(skin=skin, bus="udp", channels=("a", "b"), control=""))
    with Stepped(skin="rectangular:rows=60,columns=60", at_once=True) as stepped:  # 19 boards
        assert len(stepped.skin.hardware.addresses) == 2
        other = Host(stepped.skin.hardware.addresses[1])
        stepped.meet(1)
        first = {m[0] >> 4 & 15 for m in stepped.step()}
        due = stepped.skin.hardware.wires[1].counts["messages"]
        second = {m[0] >> 4 & 15 for m in other.wait_for(due)}
        other.close()
    assert first == set(range(1, 15))
    assert second == set(range(1, 6))


def test_boards_that_are_spread_send_one_after_the_other():
    with Stepped(skin="rectangular:rows=20,columns=40", at_once=True, spread=True) as stepped:
        stepped.step(0.001)  # all that has been due since the boards were made
        bursts = [{m[0] >> 4 & 15 for m in stepped.step(0.001)} for _ in range(40)]
    assert max(len(burst) for burst in bursts) == 1
    assert set().union(*bursts) == {1, 2, 3, 4, 5}


def test_patches_are_on_boards_of_their_own(tmp_path):
    one, other = by_name("hexagon72"), by_name("ten_pad_triangle")
    path = tmp_path / "two.toml"
    save_layout(Skin((one, other), name="two"), path)
    with Stepped(skin=str(path), at_once=True, fault=("dead ten_pad_triangle/0",)) as stepped:
        assert {m[0] >> 4 & 15 for m in stepped.step()} == {1, 2}
        for taxel in (0, 3):
            stepped.skin.world.press(Request(patch="ten_pad_triangle", taxel=taxel, force=3.0))
        messages = stepped.step()
        assert set(bytes_by_channel(messages, board=1)[:72]) == {240}
        second = bytes_by_channel(messages, board=2)[other.channel]
        assert second[0] == 240  # dead
        assert second[3] < 200
        stepped.skin.hardware.places("unplug", "1.0")
        with pytest.raises(InputError, match="triangle is '1', expected a number from 0 to 0"):
            stepped.skin.hardware.places("unplug", "1.1")
