// Shows the baked file that the address names, from its own camera, lit by its lightmaps alone.

import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { registerLightmaps } from './lightmap.js';

const query = new URLSearchParams(location.search);
const status = document.querySelector('[role=status]');
// Light as it is: no tone curve, so that what is brighter than the screen is white.
const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
renderer.toneMapping = THREE.NoToneMapping;
const size = query.get('size')?.split('x').map(Number);
document.body.prepend(renderer.domElement);

async function show(file) {
    const { scene, cameras } = await registerLightmaps(new GLTFLoader()).loadAsync(file);
    // The file's own lights are in its lightmaps already.
    const lights = [];
    scene.traverse((object) => object.isLight && lights.push(object));
    lights.forEach((light) => light.removeFromParent());
    const camera = cameras[0] ?? framing(scene);
    // Before the controls turn it to the origin.
    const forward = camera.getWorldDirection(new THREE.Vector3());
    const place = camera.getWorldPosition(new THREE.Vector3());
    const controls = new OrbitControls(camera, renderer.domElement);
    controls.target.copy(place).addScaledVector(forward, place.length() || 1);
    controls.update();
    const draw = () => {
        const [width, height] = size ?? [innerWidth, innerHeight];
        renderer.setPixelRatio(size ? 1 : devicePixelRatio);
        renderer.setSize(width, height);
        camera.aspect = width / height;
        camera.updateProjectionMatrix();
        renderer.render(scene, camera);
    };
    controls.addEventListener('change', draw);
    addEventListener('resize', draw);
    draw();
    status.textContent = size ? '' : `${file}: ${renderer.info.render.triangles} triangles`;
}

/// A camera that sees all of a scene without one.
function framing(scene) {
    const sphere = new THREE.Box3().setFromObject(scene).getBoundingSphere(new THREE.Sphere());
    const camera = new THREE.PerspectiveCamera(40, 1, sphere.radius / 100, sphere.radius * 100);
    camera.position.copy(sphere.center).add(new THREE.Vector3(1, 1, 2).setLength(3 * sphere.radius));
    camera.lookAt(sphere.center);
    return camera;
}

const file = query.get('file');
if (file !== null) {
    window.shown = show(file).catch((error) => {
        status.textContent = `${file} cannot be shown: ${error.message}`;
        throw error;
    });
}
