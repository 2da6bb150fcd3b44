// Models for the tests: a tent of two triangles as GLB, and a floor with a lamp above it as OBJ with MTL.

function glb(json, binary) {
  const chunk = (kind, bytes, padding) => {
    const data = Buffer.concat([bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4, padding)]);
    const head = Buffer.alloc(8);
    head.writeUInt32LE(data.length);
    head.write(kind, 4, "latin1");
    return Buffer.concat([head, data]);
  };
  const chunks = [chunk("JSON", Buffer.from(JSON.stringify(json)), " "), chunk("BIN\0", binary, 0)];
  const head = Buffer.alloc(12);
  head.write("glTF");
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(12 + chunks[0].length + chunks[1].length, 8);
  return Buffer.concat([head, ...chunks]);
}

const positions = new Float32Array([-1, 0, 1, 1, 0, 1, 0, 1, 0, 1, 0, -1, -1, 0, -1, 0, 1, 0]);

export const GLB = glb(
  {
    asset: { version: "2.0" },
    buffers: [{ byteLength: positions.byteLength }],
    bufferViews: [{ buffer: 0, byteLength: positions.byteLength }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 6, type: "VEC3", min: [-1, 0, -1], max: [1, 1, 1] }],
    materials: [{ pbrMetallicRoughness: { baseColorFactor: [0.8, 0.3, 0.1, 1], metallicFactor: 0 } }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, material: 0 }] }],
    nodes: [{ mesh: 0 }],
  },
  Buffer.from(positions.buffer),
);

export const OBJ = `mtllib lamp.mtl
v -2 0 -2
v 2 0 -2
v 2 0 2
v -2 0 2
v -.5 2 -.5
v .5 2 -.5
v .5 2 .5
v -.5 2 .5
usemtl floor
f 1 4 3 2
usemtl lamp
f 5 6 7 8
`;

export const MTL = `newmtl floor
Kd .2 .6 .9
newmtl lamp
Ke 9 8 6
`;
