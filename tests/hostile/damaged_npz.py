"""Problem files damaged in ways that a disk, another program or an attacker would choose."""

import io
import struct
import zipfile

import numpy as np

BYTES = [b"\x00", b"\xff", b"{", b"-", b"(", b"'", b"2L", b"\x93NUMPY", b"PK\x01\x02", b"PK\x05\x06", b"\n"]
HEADERS = [
    "{{{{",
    "-" * 3900,
    "(" * 3000,
    "{'descr': '<f8', 'fortran_order': False, 'shape': (0, 18446744073709551616), }",
    "{'descr': '<f8', 'fortran_order': False, 'shape': (2L, 2L), }",
    "{'descr': '<f8', 'fortran_order': False, 'shape': (2, -2), }",
    "{'descr': '<f8', 'fortran_order': False, 'shape': (9999999999, 9999999999), }",
    "{'descr': '<U99999999999', 'fortran_order': False, 'shape': (), }",
    "{'descr': '<V0', 'fortran_order': False, 'shape': (99999999999, 99999999999), }",
    "{'descr': '|O', 'fortran_order': False, 'shape': (1,), }",
    "{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (1,), }",
    "{'descr': '<f7', 'fortran_order': False, 'shape': (2, 2), }",
    "{'descr': '<f8', 'fortran_order': 1, 'shape': (2, 2), }",
    "{'descr': '\\d', 'fortran_order': False, 'shape': (1if 1 else 2,), }",
    "{'shape': (2, 2), 'shape': (2, 2), 'shape': (2, 2)}",
    " {'descr': '<f8', 'fortran_order': False, 'shape': (2, 2), }",
    "__import__('os').abort()",
    "",
]
TEXTS = [
    "\x1b]0;owned\x07",
    "\x00",
    "\x9b31m",
    "\u202egnp.exe",
    "a$b",
    "N, $mm",
    "<script>alert(1)</script>",
    "x" * 70_000,
    "\n\n",
    "",
]
DTYPES = [">f8", "<f4", "<i8", "<u8", "<f2", "<c16", "|b1", "<U3", "S4", "<M8[s]", "<m8[D]", "<g"]


def npy(array: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    np.save(buffer, array, allow_pickle=False)
    return buffer.getvalue()


def with_header(header: str, data: bytes, version: int = 1) -> bytes:
    text = header.encode("latin-1")
    size = struct.pack("<H" if version == 1 else "<I", len(text))
    return b"\x93NUMPY" + bytes([version, 0]) + size + text + data


def damaged_npz(arrays: dict[str, np.ndarray], rng: np.random.Generator) -> bytes:
    """A problem file with one to three things wrong with it, as bytes."""
    members = {f"{key}.npy": npy(np.asarray(value)) for key, value in arrays.items()}
    for _ in range(rng.integers(1, 3)):
        members = dict(_damaged_member(members, arrays, rng))
    method = rng.choice([0, 8, 12, 14], p=[0.48, 0.48, 0.03, 0.01])
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, data in members.items():
            archive.writestr(zipfile.ZipInfo(name), data, int(method))
    data = buffer.getvalue()
    return damaged_bytes(data, rng) if rng.random() < 0.4 else data


def damaged_bytes(data: bytes, rng: np.random.Generator) -> bytes:
    """Bytes flipped, inserted, cut out or cut off."""
    raw = bytearray(data)
    for _ in range(rng.integers(1, 5)):
        at = int(rng.integers(0, len(raw) + 1))
        # half of the damage where archives keep their own numbers: at the end
        at = max(0, len(raw) - int(rng.integers(1, 400))) if rng.random() < 0.5 else at
        kind = rng.integers(4)
        if kind == 0 and at < len(raw):
            raw[at] ^= 1 << int(rng.integers(8))
        elif kind == 1:
            raw[at:at] = BYTES[rng.integers(len(BYTES))]
        elif kind == 2:
            del raw[at : at + int(rng.integers(1, 20))]
        elif kind == 3 and rng.random() < 0.3:
            del raw[at:]
        if not raw:
            break
    return bytes(raw)


def _damaged_member(members: dict[str, bytes], arrays: dict[str, np.ndarray], rng: np.random.Generator):
    names = list(members)
    name = names[rng.integers(len(names))]
    key = name.removesuffix(".npy")
    kind = rng.integers(9)
    if kind == 0:
        del members[name]
    elif kind == 1:
        header = HEADERS[rng.integers(len(HEADERS))]
        members[name] = with_header(header, members[name][128:], int(rng.choice([1, 2])))
    elif kind == 2:
        members[name] = damaged_bytes(members[name], rng)
    elif kind == 3:
        shape = tuple(int(s) for s in rng.integers(0, 4, rng.integers(0, 4)))
        members[name] = npy(np.ones(shape))
    elif kind == 4 and key in arrays:
        with np.errstate(all="ignore"):
            members[name] = npy(np.zeros(np.shape(arrays[key]), DTYPES[rng.integers(len(DTYPES))]))
    elif kind == 5:
        members[f"k{TEXTS[rng.integers(len(TEXTS))][:60000]}.npy"] = members.pop(name)
    elif kind == 6:
        members[f"{rng.choice(['name', 'units', 'source', 'label', 'schema'])}.npy"] = _text(rng)
    elif kind == 7:
        members[rng.choice(["mu.npy", "A", "name", "../A.npy", "A.npy/"])] = members[name]
    else:
        value = (
            np.array(arrays.get(key, 1.0), dtype=float, ndmin=1, copy=True)
            if key in arrays and np.asarray(arrays[key]).dtype.kind == "f"
            else np.ones(1)
        )
        value.flat[rng.integers(value.size)] = rng.choice([np.nan, np.inf, -np.inf, 1e308, 5e-324, -1.0])
        members[name] = npy(value)
    return members or {"A.npy": b""}


def _text(rng: np.random.Generator) -> bytes:
    if rng.random() < 0.3:  # code points beyond the last, and halves of characters
        code = int(rng.choice([0x110000, 0xFFFFFFFF, 0xD800, 0xDFFF]))
        return with_header(
            "{'descr': '<U1', 'fortran_order': False, 'shape': (), }".ljust(117) + "\n",
            struct.pack("<I", code),
        )
    return npy(np.array(TEXTS[rng.integers(len(TEXTS))]))
