// Cube maps with the lookup that halfdome prints for them: the shader must compile, and must find what is stored.
//
// The environment is `2 + a·d` for a unit vector d. A lobe about d makes of it `2 + s a·d` with one s for each roughness, so that
// it is known everywhere but for one number: no direction may be swapped, and no edge of a face may show.

import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

const slope = [0.6, 0.4, -0.9];
const light = (d) => 2 + d.reduce((sum, x, i) => sum + slope[i] * x, 0);

/// The environment as a Radiance picture of all directions.
function picture(width, height) {
    const pixels = new Uint8Array(4 * width * height);
    for (let y = 0; y < height; y++) {
        for (let x = 0; x < width; x++) {
            const [theta, phi] = [Math.PI * (y + 0.5) / height, 2 * Math.PI * ((x + 0.5) / width - 0.5)];
            const value = light([Math.sin(theta) * Math.sin(phi), Math.cos(theta), -Math.sin(theta) * Math.cos(phi)]);
            const exponent = Math.floor(Math.log2(value)) + 1;
            const mantissa = Math.min(255, Math.round(256 * value / 2 ** exponent));
            pixels.set([mantissa, mantissa, mantissa, exponent + 128], 4 * (y * width + x));
        }
    }
    const head = `#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${height} +X ${width}\n`;
    return Buffer.concat([Buffer.from(head, 'latin1'), pixels]);
}

/// The levels of a KTX2 cube map in half floats: lists of faces.
function levels(file) {
    const bytes = readFileSync(file);
    const [size, count] = [bytes.readUInt32LE(20), bytes.readUInt32LE(40)];
    return Array.from({ length: count }, (_, level) => {
        const [start, length] = [0, 8].map((at) => Number(bytes.readBigUInt64LE(80 + 24 * level + at)));
        const halves = Array.from({ length: length / 2 }, (_, i) => bytes.readUInt16LE(start + 2 * i));
        const face = halves.length / 6;
        return { side: size >> level, faces: [0, 1, 2, 3, 4, 5].map((i) => halves.slice(face * i, face * (i + 1))) };
    });
}

/// What the shader finds in the browser: a number for each direction and roughness. Both functions run there.
function look({ levels, lookup, directions, roughnesses }) {
    const gl = new OffscreenCanvas(1, 1).getContext('webgl2');
    if (!gl.getExtension('EXT_color_buffer_float')) throw new Error('there are no float targets');
    const compile = (type, source) => {
        const shader = gl.createShader(type);
        gl.shaderSource(shader, source);
        gl.compileShader(shader);
        if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
        return shader;
    };
    const corners = 'vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0';
    const vertices = `#version 300 es\nvoid main() { gl_Position = vec4(${corners}, 0.0, 1.0); }`;
    const fragments = `#version 300 es\nprecision highp float;\nprecision highp samplerCube;\n${lookup}
        uniform samplerCube map;\nuniform vec3 v;\nuniform float roughness;\nout vec4 found;
        void main() { found = vec4(cube_sample(map, v, roughness), 1.0); }`;
    const program = gl.createProgram();
    gl.attachShader(program, compile(gl.VERTEX_SHADER, vertices));
    gl.attachShader(program, compile(gl.FRAGMENT_SHADER, fragments));
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    gl.useProgram(program);

    gl.bindTexture(gl.TEXTURE_CUBE_MAP, gl.createTexture());
    levels.forEach(({ side, faces }, level) => faces.forEach((halves, face) => {
        const target = gl.TEXTURE_CUBE_MAP_POSITIVE_X + face;
        const data = new Uint16Array(halves);
        gl.texImage2D(target, level, gl.RGBA16F, side, side, 0, gl.RGBA, gl.HALF_FLOAT, data);
    }));
    gl.texParameteri(gl.TEXTURE_CUBE_MAP, gl.TEXTURE_MAX_LEVEL, levels.length - 1);
    gl.texParameteri(gl.TEXTURE_CUBE_MAP, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_NEAREST);
    gl.texParameteri(gl.TEXTURE_CUBE_MAP, gl.TEXTURE_MAG_FILTER, gl.LINEAR);

    const target = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, target);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, 1, 1);
    gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
    gl.viewport(0, 0, 1, 1);
    const pixel = new Float32Array(4);
    return roughnesses.map((roughness) => directions.map((direction) => {
        gl.uniform3fv(gl.getUniformLocation(program, 'v'), direction);
        gl.uniform1f(gl.getUniformLocation(program, 'roughness'), roughness);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.FLOAT, pixel);
        return pixel[0];
    }));
}

/// What a compiler of WGSL says of the text: nothing if all is well, null where there is none.
async function complaints(text) {
    const adapter = await navigator.gpu?.requestAdapter();
    if (!adapter) return null;
    const device = await adapter.requestDevice();
    const information = await device.createShaderModule({ code: text }).getCompilationInfo();
    return information.messages.map(({ lineNum, message }) => `line ${lineNum}: ${message}`);
}

/// Directions by a golden spiral, and pairs that an edge or a corner of the cube is between.
function directions() {
    const spiral = Array.from({ length: 64 }, (_, i) => {
        const [z, phi] = [1 - (2 * i + 1) / 64, i * Math.PI * (3 - Math.sqrt(5))];
        return [Math.cos(phi) * Math.sqrt(1 - z * z), z, Math.sin(phi) * Math.sqrt(1 - z * z)];
    });
    const pairs = [];
    for (const [a, b] of [[1, 1], [1, -1], [-1, 1], [-1, -1]]) {
        for (const c of [-0.97, -0.4, 0.3, 0.99]) {
            for (let axis = 0; axis < 3; axis++) {
                for (const long of [1.0001, 0.9999]) {
                    const d = [0, 0, 0];
                    [d[axis], d[(axis + 1) % 3], d[(axis + 2) % 3]] = [c, long * a, b];
                    pairs.push(d.map((x) => x / Math.hypot(...d)));
                }
            }
        }
    }
    return { spiral, pairs };
}

/// Makes cube maps by the program in the folder `out`, and looks them up in the browser's `page`.
export async function lookUp(run, out, page) {
    writeFileSync(join(out, 'slope.hdr'), picture(512, 256));
    const { spiral, pairs } = directions();
    const roughnesses = [0, 0.3, 0.5, 0.77, 1];
    const make = (axes, seams, language) => {
        const options = ['--size', '32', '--seams', seams, '--axes', axes, '--print-lookup', language, '--progress', 'none'];
        run('cubemap', 'slope.hdr', '-o', 'slope.ktx2', ...options);
        return readFileSync(join(out, `slope.${language}`), 'utf8');
    };
    for (const [axes, seams] of [['three', 'lookup'], ['bevy', 'lookup'], ['world', 'lookup'], ['three', 'warp']]) {
        const lookup = make(axes, seams, 'glsl');
        const map = levels(join(out, 'slope.ktx2'));
        const found = await page.evaluate(look, { levels: map, lookup, directions: [...spiral, ...pairs], roughnesses });
        for (const [i, values] of found.entries()) {
            // The s of least squares.
            const changes = spiral.map((d) => light(d) - 2);
            const product = (values) => changes.reduce((sum, x, k) => sum + x * values[k], 0);
            const s = product(values.map((value) => value - 2)) / product(changes);
            const worst = Math.max(...changes.map((x, k) => Math.abs(values[k] / (2 + s * x) - 1)));
            let step = 0;
            for (let k = spiral.length; k < values.length; k += 2) {
                step = Math.max(step, Math.abs(values[k] - values[k + 1]) / values[k]);
            }
            const name = `${axes}, ${seams}, roughness ${roughnesses[i]}: `;
            const figures = `s ${s.toFixed(3)}, error ${worst.toFixed(4)}, step ${step.toFixed(5)}`;
            if (axes === 'three') console.log(name + figures);
            // The first level is limited by the picture's eight bits, the last ones by having 4 texels a side.
            assert(worst < (seams === 'lookup' ? 0.02 : 0.06) && step < 0.002, name + figures);
            assert(i === 0 ? Math.abs(s - 1) < 0.01 && worst < 0.01 : s < 0.99 && s > 0.4, name + figures);
        }
    }
    const found = await page.evaluate(complaints, make('bevy', 'lookup', 'wgsl'));
    assert(found === null || found.length === 0, found?.join('\n'));
    console.log(found === null ? 'WGSL: skipped, as the browser has no WebGPU' : 'WGSL: compiles');
}
