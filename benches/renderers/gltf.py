"""Reads what Blender writes into a `.glb`: triangles in the world's coordinates, materials, punctual lights and the camera."""

import json
import struct

import numpy as np

KINDS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class Model:
    """`json` is the document; `meshes` has (name, positions, normals, coordinates, triangles, material), `lights` and
    `cameras` have (description, matrix from its own coordinates to the world's)."""

    def __init__(self, path):
        with open(path, "rb") as file:
            data = file.read()
        length = struct.unpack_from("<I", data, 12)[0]
        self.json = json.loads(data[20 : 20 + length])
        self.binary = data[28 + length :]
        self.meshes, self.lights, self.cameras = [], [], []
        for root in self.json["scenes"][self.json.get("scene", 0)]["nodes"]:
            self.visit(self.json["nodes"][root], np.eye(4))

    def visit(self, node, parent):
        matrix = parent @ placement(node)
        if "mesh" in node:
            for primitive in self.json["meshes"][node["mesh"]]["primitives"]:
                self.meshes.append(self.triangles(node.get("name", ""), primitive, matrix))
        if "camera" in node:
            self.cameras.append((self.json["cameras"][node["camera"]], matrix))
        light = node.get("extensions", {}).get("KHR_lights_punctual")
        if light:
            self.lights.append((self.json["extensions"]["KHR_lights_punctual"]["lights"][light["light"]], matrix))
        for child in node.get("children", []):
            self.visit(self.json["nodes"][child], matrix)

    def triangles(self, name, primitive, matrix):
        attributes, linear = primitive["attributes"], matrix[:3, :3]
        positions = self.array(attributes["POSITION"]) @ linear.T + matrix[:3, 3]
        triangles = self.array(primitive["indices"]).reshape(-1, 3).astype(np.uint32)
        if np.linalg.det(linear) < 0:
            triangles = triangles[:, ::-1]
        normals = self.array(attributes["NORMAL"]) @ np.linalg.inv(linear) if "NORMAL" in attributes else None
        if normals is not None:
            normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-20)
        coordinates = self.array(attributes["TEXCOORD_0"]) if "TEXCOORD_0" in attributes else None
        return name, positions, normals, coordinates, triangles, self.json["materials"][primitive["material"]]

    def array(self, number):
        accessor = self.json["accessors"][number]
        view = self.json["bufferViews"][accessor["bufferView"]]
        width, start = WIDTHS[accessor["type"]], view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        kind = KINDS[accessor["componentType"]]
        return np.frombuffer(self.binary, kind, accessor["count"] * width, start).reshape(-1, width)

    def image(self, texture):
        """The bytes of a texture's file, and the ending that tells its format."""
        image = self.json["images"][self.json["textures"][texture["index"]]["source"]]
        view = self.json["bufferViews"][image["bufferView"]]
        start = view.get("byteOffset", 0)
        return self.binary[start : start + view["byteLength"]], image["mimeType"].split("/")[1]


def placement(node):
    """A node's own matrix."""
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    matrix = np.eye(4)
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, :3] *= node.get("scale", (1, 1, 1))
    matrix[:3, 3] = node.get("translation", (0, 0, 0))
    return matrix
