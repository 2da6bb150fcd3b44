"""Changes the JSON of a `.glb`."""

import json
import struct


def extend(path, material, extensions):
    """Gives a material extensions that Blender's exporter does not know, in place of those of their names."""
    if not extensions:
        return
    with open(path, "rb") as file:
        data = file.read()
    length = struct.unpack_from("<I", data, 12)[0]
    document, rest = json.loads(data[20 : 20 + length]), data[20 + length :]
    for described in document["materials"]:
        if described["name"] == material:
            described.setdefault("extensions", {}).update(extensions)
    used = document.setdefault("extensionsUsed", [])
    used += [name for name in extensions if name not in used]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A)
    with open(path, "wb") as file:
        file.write(head + text + rest)
