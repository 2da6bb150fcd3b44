// Levels for the test, as glTF.

/// glTF with these quadrilaterals: `corners` counter-clockwise from the front, `material`, and optional `lightmap`.
function level(quads, materials, camera) {
    const floats = [];
    const accessors = [];
    const bufferViews = [];
    const push = (vectors, type) => {
        bufferViews.push({ buffer: 0, byteOffset: 4 * floats.length, byteLength: 4 * vectors.flat().length });
        floats.push(...vectors.flat());
        const bounds = type === 'VEC3' && {
            min: [0, 1, 2].map((i) => Math.fround(Math.min(...vectors.map((v) => v[i])))),
            max: [0, 1, 2].map((i) => Math.fround(Math.max(...vectors.map((v) => v[i])))),
        };
        accessors.push({ bufferView: bufferViews.length - 1, componentType: 5126, count: vectors.length, type, ...bounds });
        return accessors.length - 1;
    };
    const primitive = ({ corners: [a, b, c, d], material, lightmap }) => {
        const sub = (p, q) => p.map((x, i) => x - q[i]);
        const [e, f] = [sub(b, a), sub(d, a)];
        const normal = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
        const length = Math.hypot(...normal);
        const list = [a, b, c, a, c, d];
        const attributes = {
            POSITION: push(list, 'VEC3'),
            NORMAL: push(list.map(() => normal.map((x) => x / length)), 'VEC3'),
        };
        if (lightmap) {
            const [s, t, u, v] = lightmap;
            attributes.TEXCOORD_0 = attributes.TEXCOORD_1 = push([s, t, u, s, u, v], 'VEC2');
        }
        return { attributes, material };
    };
    const meshes = quads.map((quad) => ({ primitives: [primitive(quad)] }));
    const nodes = [...meshes.map((_, mesh) => ({ mesh })), { camera: 0, ...camera.node }];
    const buffer = Buffer.from(new Float32Array(floats).buffer);
    const uri = `data:application/octet-stream;base64,${buffer.toString('base64')}`;
    return {
        asset: { version: '2.0' },
        buffers: [{ byteLength: buffer.length, uri }],
        bufferViews, accessors, materials, meshes, nodes,
        cameras: [{ type: 'perspective', perspective: { yfov: camera.yfov, znear: 0.01 } }],
        scenes: [{ nodes: nodes.map((_, node) => node) }],
        scene: 0,
    };
}

/// Without the specular layer that glTF's materials have otherwise, and that takes two percent from the light below.
const matte = (r, g, b, extensions, more) => ({
    pbrMetallicRoughness: { baseColorFactor: [r, g, b, 1], metallicFactor: 0, roughnessFactor: 1 },
    extensions: { KHR_materials_specular: { specularFactor: 0 }, ...extensions },
    ...more,
});

/// A wall with an albedo of one half, and its lightmap: a left texel of 2 pi and a right one of pi / 2.
export function furnace() {
    const corners = [[-4, -4, -2], [4, -4, -2], [4, 4, -2], [-4, 4, -2]];
    const lightmap = [[0, 1], [1, 1], [1, 0], [0, 0]];
    const material = matte(0.5, 0.5, 0.5, { MOZ_lightmap: { index: 0, texCoord: 1, intensity: 1 } });
    const gltf = level([{ corners, material: 0, lightmap }], [material], { yfov: 1.57, node: {} });
    gltf.extensionsUsed = ['KHR_materials_specular', 'MOZ_lightmap', 'MOZ_texture_rgbe'];
    gltf.images = [{ uri: 'light%20map.hdr', mimeType: 'image/vnd.radiance' }];
    gltf.samplers = [{ magFilter: 9728, minFilter: 9728, wrapS: 33071, wrapT: 33071 }];
    gltf.textures = [{ sampler: 0, extensions: { MOZ_texture_rgbe: { source: 0 } } }];
    // 2 pi is 201/256 of 8, and pi / 2 is 201/256 of 2.
    const header = Buffer.from('#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n');
    return { gltf, hdr: Buffer.concat([header, Buffer.from([201, 201, 201, 131, 201, 201, 201, 129])]) };
}

/// A room with a red and a green wall, a lamp in the ceiling and a box, seen from its open front.
export function room() {
    const box = (x0, y0, z0, x1, y1, z1, material) => [
        [[x0, y0, z1], [x1, y0, z1], [x1, y1, z1], [x0, y1, z1]],
        [[x1, y0, z0], [x0, y0, z0], [x0, y1, z0], [x1, y1, z0]],
        [[x1, y0, z1], [x1, y0, z0], [x1, y1, z0], [x1, y1, z1]],
        [[x0, y0, z0], [x0, y0, z1], [x0, y1, z1], [x0, y1, z0]],
        [[x0, y1, z1], [x1, y1, z1], [x1, y1, z0], [x0, y1, z0]],
    ].map((corners) => ({ corners, material }));
    const quads = [
        { corners: [[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]], material: 0 },
        { corners: [[-1, 2, -1], [1, 2, -1], [1, 2, 1], [-1, 2, 1]], material: 0 },
        { corners: [[-1, 0, -1], [1, 0, -1], [1, 2, -1], [-1, 2, -1]], material: 0 },
        { corners: [[-1, 0, 1], [-1, 0, -1], [-1, 2, -1], [-1, 2, 1]], material: 1 },
        { corners: [[1, 0, -1], [1, 0, 1], [1, 2, 1], [1, 2, -1]], material: 2 },
        { corners: [[-0.4, 1.99, -0.4], [0.4, 1.99, -0.4], [0.4, 1.99, 0.4], [-0.4, 1.99, 0.4]], material: 3 },
        ...box(-0.1, 0.001, -0.5, 0.5, 0.8, 0.1, 0),
    ];
    const strength = { KHR_materials_emissive_strength: { emissiveStrength: 6 } };
    const lamp = matte(0, 0, 0, strength, { emissiveFactor: [1, 1, 1] });
    const materials = [matte(0.7, 0.7, 0.7), matte(0.6, 0.1, 0.1), matte(0.1, 0.5, 0.1), lamp];
    const gltf = level(quads, materials, { yfov: 0.7, node: { translation: [0, 1, 3.8] } });
    gltf.extensionsUsed = ['KHR_materials_emissive_strength', 'KHR_materials_specular'];
    return gltf;
}
