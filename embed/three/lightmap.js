// Plugins for three.js's GLTFLoader, for files that `halfdome bake --preset three` made:
//
//     const loader = new GLTFLoader();
//     registerLightmaps(loader);
//
// MOZ_lightmap hangs a lightmap on a material, with the second texture coordinates; MOZ_texture_rgbe is a texture in a
// Radiance picture. Texels are irradiance in W/m², which is what MeshStandardMaterial.lightMap takes.

import { LinearSRGBColorSpace } from 'three';
import { EXRLoader } from 'three/addons/loaders/EXRLoader.js';
import { HDRLoader } from 'three/addons/loaders/HDRLoader.js';

export function registerLightmaps(loader) {
    return loader.register((parser) => new Lightmap(parser)).register((parser) => new RadianceTexture(parser));
}

class Lightmap {
    name = 'MOZ_lightmap';

    constructor(parser) {
        this.parser = parser;
    }

    async extendMaterialParams(index, params) {
        const lightmap = this.parser.json.materials[index].extensions?.[this.name];
        if (lightmap === undefined) return;
        const info = { index: lightmap.index, texCoord: lightmap.texCoord ?? 1 };
        await this.parser.assignTexture(params, 'lightMap', info, LinearSRGBColorSpace);
        params.lightMapIntensity = lightmap.intensity ?? 1;
    }
}

class RadianceTexture {
    name = 'MOZ_texture_rgbe';

    constructor(parser) {
        this.parser = parser;
    }

    loadTexture(index) {
        const { textures, images } = this.parser.json;
        const radiance = textures[index].extensions?.[this.name]?.source;
        if (radiance !== undefined) {
            return this.parser.loadTextureImage(index, radiance, new HDRLoader(this.parser.options.manager));
        }
        const source = textures[index].source;
        if (images[source]?.mimeType === 'image/x-exr') {
            return this.parser.loadTextureImage(index, source, new EXRLoader(this.parser.options.manager));
        }
        return null;
    }
}
