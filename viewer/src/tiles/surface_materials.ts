// SPDX-License-Identifier: Apache-2.0
// Tileable materials of roads, verges and paint, shared by all tiles: their pictures lie in scene/materials once.

import {
  type LoadingManager,
  type Material,
  MeshBasicMaterial,
  type MeshLambertMaterial,
  MeshStandardMaterial,
  RepeatWrapping,
  SRGBColorSpace,
  type Texture,
  TextureLoader,
} from 'three';
import {MeshoptDecoder} from 'three/addons/libs/meshopt_decoder.module.js';
import {GLTFLoader} from 'three/addons/loaders/GLTFLoader.js';
import {tilesetUrl} from '../site';
import {withSky} from '../sky/sky_light';
import {foliageMaterial, leavesMaterial} from './foliage';
import {tileFeaturesPlugin} from './tile_features';

/** What the file says about its materials, as far as it is used here. */
interface GltfJson {
  materials: {name?: string; pbrMetallicRoughness?: {baseColorTexture?: {index: number}}}[];
  textures: {source: number}[];
  images: {uri?: string}[];
}

type SurfaceMaterial = MeshStandardMaterial | MeshLambertMaterial;

export class SurfaceMaterials {
  onChange: () => void = () => {};
  private readonly textures = new TextureLoader();
  private readonly byName = new Map<string, SurfaceMaterial>();
  private asked = 0; // of pictures

  constructor(private readonly anisotropy: number) {}

  /** A loader that leaves materials with tileable pictures to this class: it gives them by name, without textures. */
  gltfLoader(manager: LoadingManager): GLTFLoader {
    return new GLTFLoader(manager)
      .setMeshoptDecoder(MeshoptDecoder)
      .register(tileFeaturesPlugin)
      .register((parser) => ({
        name: 'shared_surface_materials',
        loadMaterial(index: number): Promise<Material> | null {
          const json = parser.json as GltfJson;
          const {name, pbrMetallicRoughness} = json.materials[index];
          const texture = pbrMetallicRoughness?.baseColorTexture?.index;
          if (texture === undefined || json.images[json.textures[texture].source].uri === undefined) return null;
          return Promise.resolve(new MeshBasicMaterial({name}));
        },
      }));
  }

  /** Pictures are on their way. */
  get pending(): boolean {
    return this.asked > 0;
  }

  /** The material of that name; pictures follow when they are loaded. */
  get(name: string): SurfaceMaterial {
    const known = this.byName.get(name);
    if (known) return known;
    const material = this.make(name);
    this.byName.set(name, material);
    return material;
  }

  private make(name: string): SurfaceMaterial {
    const color = this.texture(`${name}_color.${name === 'leaves' ? 'png' : 'jpg'}`);
    color.colorSpace = SRGBColorSpace;
    if (name === 'leaves') return Object.assign(leavesMaterial(), {map: color});
    const normalMap = this.texture(`${name}_normal.jpg`);
    if (name === 'foliage') {
      for (const texture of [color, normalMap]) texture.repeat.setScalar(0.5);
      return Object.assign(foliageMaterial(), {map: color, normalMap});
    }
    const material = withSky(
      new MeshStandardMaterial({
        name,
        map: color,
        normalMap,
        roughnessMap: this.texture(`${name}_roughness.jpg`),
        metalness: 0,
        vertexColors: true,
      }),
    );
    // Verge, gravel beside roads and paint lie on other triangles: they are drawn a little nearer, and after them.
    if (name === 'verge')
      Object.assign(material, {transparent: true, depthWrite: false, polygonOffset: true, polygonOffsetFactor: -1});
    if (name === 'gravel')
      Object.assign(material, {polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -1});
    if (name === 'paint')
      Object.assign(material, {polygonOffset: true, polygonOffsetFactor: -4, polygonOffsetUnits: -4});
    return material;
  }

  private texture(file: string): Texture {
    const url = new URL(`materials/${file}`, new URL(tilesetUrl, location.href)).href;
    const done = () => {
      --this.asked;
      this.onChange();
    };
    ++this.asked;
    const texture = this.textures.load(url, done, undefined, done);
    texture.wrapS = texture.wrapT = RepeatWrapping;
    texture.flipY = false;
    texture.channel = 1;
    texture.anisotropy = this.anisotropy;
    return texture;
  }
}
