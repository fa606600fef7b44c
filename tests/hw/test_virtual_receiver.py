"""The servos' parser: what it finds, what it reports as damaged, and that it agrees with the host's."""

from hypothesis import given, settings
from hypothesis import strategies as st

from hw.protocol import Instruction, Packet, PacketReader, encode
from hw.virtual.receiver import Damaged, Receiver

packets = st.builds(
    Packet,
    st.integers(0, 253),
    st.sampled_from([int(item) for item in Instruction]),
    st.lists(st.sampled_from([0, 1, 0x55, 0xFD, 0xFE, 0xFF]), max_size=40).map(bytes),
)
pieces = st.lists(st.one_of(st.binary(max_size=30), packets.map(encode), st.just(b"\xff\xff\xfd\x00")), max_size=8)


def received(data: bytes, step: int = 4096) -> list[Packet | Damaged]:
    receiver = Receiver()
    return [item for i in range(0, len(data), step) for item in receiver.feed(data[i : i + step])]


def test_a_wrong_crc_names_the_servo() -> None:
    wire = bytearray(encode(Packet(7, Instruction.PING)))
    wire[-1] ^= 1
    ping = encode(Packet(8, Instruction.PING))
    assert received(bytes(wire) + ping) == [Damaged(7), Packet(8, Instruction.PING)]


def test_after_a_rest_a_long_packet_is_no_longer_waited_for() -> None:
    receiver = Receiver()
    assert receiver.feed(b"\xff\xff\xfd\x00\x01\xff\x03\x03") == []
    receiver.rest()
    assert receiver.feed(encode(Packet(8, Instruction.PING))) == [Packet(8, Instruction.PING)]


@settings(max_examples=400, deadline=None)
@given(pieces, st.integers(1, 17))
def test_both_parsers_find_the_same_packets_in_anything(items: list[bytes], step: int) -> None:
    wire = b"".join(items)
    reader = PacketReader()
    host = [packet for i in range(0, len(wire), step) for packet in reader.feed(wire[i : i + step])]
    servos = received(wire, step)
    assert [item for item in servos if isinstance(item, Packet)] == host
    assert sum(isinstance(item, Damaged) for item in servos) == reader.bad_crc


@settings(max_examples=300, deadline=None)
@given(packets, st.data())
def test_a_changed_byte_is_never_taken_for_another_packet(packet: Packet, data: st.DataObject) -> None:
    wire = bytearray(encode(packet))
    wire[data.draw(st.integers(0, len(wire) - 1))] ^= data.draw(st.integers(1, 255))
    assert not [item for item in received(bytes(wire)) if isinstance(item, Packet)]
