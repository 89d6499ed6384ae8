"""The file of robotology/robots-configuration that says which channels go to which port.

In a ``*-skin_wrapper.xml`` each ``elem`` of ``ports`` holds four numbers: first and last channel of
the devices, then first and last channel of the port.
"""

from dataclasses import dataclass

from skinfield.errors import FileError
from skinfield.protocols.icub.xml_tree import Node
from skinfield.protocols.icub.xml_values import many, spoilt, whole, words

HIGHEST_CHANNEL = 1 << 20


@dataclass(frozen=True)
class PortRun:
    """Run of a device's channels that goes to a port.

    Parameters
    ----------
    port : str
    first, count : int
        Of the device's channels; with several devices, of all of them one after the other.
    port_first : int
        Channel of the port that the first one becomes.
    """

    port: str
    first: int
    count: int
    port_first: int


@dataclass(frozen=True)
class SkinWrapper:
    """What a ``skin_wrapper`` file says.

    Parameters
    ----------
    name : str
    ports : tuple of PortRun
    devices : tuple of str
        Names of the skins whose channels it passes on, in this order.
    total : int
        Channels that it counts on; 0 if it does not say.
    """

    name: str
    ports: tuple[PortRun, ...]
    devices: tuple[str, ...]
    total: int = 0


def wrapper_from(path: str, root: Node) -> SkinWrapper | None:
    """Ports; None if the file has none.

    Raises
    ------
    FileError
        If a value is missing or cannot be used.
    """
    ports, networks = root.find("paramlist", "ports"), root.find("paramlist", "networks")
    if ports is None:
        return None
    runs = [_port_run(path, node) for node in ports.children if node.tag == "elem"]
    if not runs:
        raise FileError(f"{path}:{ports.line}: ports has no elem, expected one for each port")
    total = root.find("param", "total_taxels")
    return SkinWrapper(
        root.name,
        tuple(runs),
        tuple(
            word
            for node in (networks.children if networks else [])
            if node.tag == "elem"
            for word in words(node.text)
        ),
        whole(path, total, total.text, 0, HIGHEST_CHANNEL, "channels") if total else 0,
    )


def _port_run(path: str, node: Node) -> PortRun:
    row = many(path, node, 0, HIGHEST_CHANNEL, "channels")
    expected = "first and last channel of the devices, first and last of the port, as many"
    if not node.name or len(row) != 4 or row[1] < row[0] or row[1] - row[0] != row[3] - row[2]:
        raise spoilt(path, node, node.text, expected)
    return PortRun(node.name, row[0], row[1] - row[0] + 1, row[2])
