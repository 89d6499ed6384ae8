"""Messages of one triangle of an iCub's board, by the encoder of whole buses."""

from typing import Any

from skinfield.wire.can.messages import CanMessages
from skinfield.wire.icub import ICubEncoder
from skinfield.wire.icub.commands import TRIANGLES, BoardState, TriangleState


def triangle_payloads(raw: Any, base: Any, shift: int = 2, **board: Any) -> tuple[bytes, bytes]:
    """Head and tail of one triangle, of converter counts (12,) and their base."""
    state = BoardState(triangles=(TriangleState(shift=shift),) * TRIANGLES, **board)
    encoder, messages = ICubEncoder([(0, 0)], state), CanMessages(2)
    encoder.raw[0], encoder.base[0] = raw, base
    encoder.encode(messages, 0, 0)
    return messages.data[0].tobytes(), messages.data[1].tobytes()
