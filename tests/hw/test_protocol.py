"""Packets against the e-Manual's examples and against the official SDK."""

import pytest
from dynamixel_sdk import Protocol2PacketHandler
from hypothesis import given, settings
from hypothesis import strategies as st

from hw.protocol import BROADCAST, Instruction, Packet, PacketReader, crc16, encode, encode_status, stuff, unstuff

SDK = Protocol2PacketHandler()

EXAMPLES = {
    "ping": (Packet(1, Instruction.PING), "FF FF FD 00 01 03 00 01 19 4E"),
    "read": (Packet(1, Instruction.READ, b"\x84\0\x04\0"), "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15"),
    "write": (
        Packet(1, Instruction.WRITE, b"\x74\0\0\x02\0\0"),
        "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89",
    ),
    "reg write": (
        Packet(1, Instruction.REG_WRITE, b"\x68\0\xc8\0\0\0"),
        "FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E",
    ),
    "action": (Packet(1, Instruction.ACTION), "FF FF FD 00 01 03 00 05 02 CE"),
    "factory reset": (Packet(1, Instruction.FACTORY_RESET, b"\x01"), "FF FF FD 00 01 04 00 06 01 A1 E6"),
    "reboot": (Packet(1, Instruction.REBOOT), "FF FF FD 00 01 03 00 08 2F 4E"),
    "clear": (
        Packet(1, Instruction.CLEAR, b"\x01\x44\x58\x4c\x22"),
        "FF FF FD 00 01 08 00 10 01 44 58 4C 22 B1 DC",
    ),
    "sync read": (
        Packet(BROADCAST, Instruction.SYNC_READ, b"\x84\0\x04\0\x01\x02"),
        "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA",
    ),
    "sync write": (
        Packet(BROADCAST, Instruction.SYNC_WRITE, b"\x74\0\x04\0\x01\x96\0\0\0\x02\xaa\0\0\0"),
        "FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87",
    ),
    "bulk read": (
        Packet(BROADCAST, Instruction.BULK_READ, b"\x01\x90\0\x02\0\x02\x92\0\x01\0"),
        "FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05",
    ),
    "bulk write": (
        Packet(BROADCAST, Instruction.BULK_WRITE, b"\x01\x20\0\x02\0\xa0\0\x02\x1f\0\x01\0\x50"),
        "FF FF FD 00 FE 10 00 93 01 20 00 02 00 A0 00 02 1F 00 01 00 50 B7 68",
    ),
    "status": (Packet(1, Instruction.STATUS, b"\0\xa6\0\0\0"), "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0"),
}


@pytest.mark.parametrize("name", EXAMPLES)
def test_packets_of_the_manual(name: str) -> None:
    packet, wire = EXAMPLES[name]
    assert encode(packet) == bytes.fromhex(wire)
    assert list(PacketReader().feed(bytes.fromhex(wire))) == [packet]


@settings(deadline=None)
@given(st.binary(max_size=1500), st.integers(0, 0xFFFF))
def test_crc_equals_the_sdks(data: bytes, initial: int) -> None:
    assert crc16(data, initial) == SDK.updateCRC(initial, data, len(data))


@settings(deadline=None)
@given(st.lists(st.sampled_from([0xFF, 0xFD, 0x00, 0x55]), max_size=60))
def test_stuffing_is_reversible_and_hides_headers(values: list[int]) -> None:
    body = bytes([Instruction.STATUS, *values])
    assert unstuff(stuff(body)) == body
    assert b"\xff\xff\xfd\x00" not in stuff(body)


plain_bytes = st.lists(st.sampled_from([0xFF, 0x00, 0x12]), max_size=20).map(bytes)


@settings(deadline=None)
@given(plain_bytes, plain_bytes)
def test_the_sdk_undoes_our_stuffing(before: bytes, after: bytes) -> None:
    # One header only: after a first one, the SDK's removeStuffing also eats a byte of "FF FD FD", which is its fault.
    data = before + b"\xff\xff\xfd" + after
    plain = SDK.removeStuffing(list(encode_status(7, 0, data)))
    length = plain[5] | plain[6] << 8
    assert bytes(plain[9 : 7 + length - 2]) == data


packets = st.builds(
    Packet,
    st.integers(0, 253),
    st.sampled_from([int(item) for item in Instruction]),
    st.lists(st.sampled_from([0, 1, 0x55, 0xFD, 0xFE, 0xFF]), max_size=40).map(bytes),
)
noise = st.lists(st.integers(0, 0xFC), max_size=10).map(bytes)


@settings(deadline=None)
@given(st.lists(st.tuples(noise, packets), max_size=6), st.integers(1, 17))
def test_reader_finds_every_packet_in_noise_however_it_is_cut(items: list[tuple[bytes, Packet]], step: int) -> None:
    wire = b"".join(before + encode(packet) for before, packet in items)
    reader = PacketReader()
    found = [packet for i in range(0, len(wire), step) for packet in reader.feed(wire[i : i + step])]
    assert found == [packet for _, packet in items]
    assert reader.bad_crc == 0


@settings(deadline=None)
@given(packets, st.data())
def test_a_changed_byte_never_yields_another_packet(packet: Packet, data: st.DataObject) -> None:
    wire = bytearray(encode(packet))
    at = data.draw(st.integers(0, len(wire) - 1))
    wire[at] ^= data.draw(st.integers(1, 255))
    assert list(PacketReader().feed(bytes(wire))) == []


@settings(max_examples=400, deadline=None)
@given(st.lists(st.one_of(st.binary(max_size=30), packets.map(encode)), max_size=8))
def test_reader_survives_anything_and_recovers(pieces: list[bytes]) -> None:
    reader = PacketReader()
    for piece in pieces:
        list(reader.feed(piece))
    ping = Packet(9, Instruction.PING)
    # A header with a long length in the noise may hold the reader back until that many bytes have come.
    assert ping in list(reader.feed(encode(ping) * 200))
