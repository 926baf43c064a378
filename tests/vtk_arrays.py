"""The numbers in a VTK XML file, read by its format alone."""

import base64
import struct

KINDS = {"Float64": "d", "Int64": "q", "UInt8": "B"}


def arrays(element):
    """Every array below an element, or in a whole tree, by name."""
    found = {}
    for array in element.iter("DataArray"):
        data = base64.b64decode(array.text)
        (size,) = struct.unpack_from("<Q", data)
        assert size == len(data) - 8
        kind = KINDS[array.get("type")]
        found[array.get("Name")] = struct.unpack_from(f"<{size // struct.calcsize(kind)}{kind}", data, 8)
    return found
