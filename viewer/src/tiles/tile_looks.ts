// SPDX-License-Identifier: Apache-2.0
// What the parts of the tiles look like, by the layers that are shown: photo, materials, classes, normals, relief.

import {
  type LoadingManager,
  type Material,
  type Mesh,
  MeshLambertMaterial,
  MeshNormalMaterial,
  type MeshStandardMaterial,
  type Object3D,
  type Texture,
  type Vector3,
} from 'three';
import type {GLTFLoader} from 'three/addons/loaders/GLTFLoader.js';

import {GroundDetail} from './ground_detail';
import {SurfaceMaterials} from './surface_materials';
import {featuresOf, labelTexture} from './tile_features';

export interface Layers {
  terrain: boolean;
  roads: boolean;
  photo: boolean;
  labels: boolean; // what the photo shows, in the colours of the classes
  normals: boolean; // of the surfaces: red to the east, green to the north, blue upwards
  materials: boolean; // of roads and beside them; without: the photo there as well
  buildings: boolean;
  trees: boolean;
  wireframe: boolean;
}

const kinds = [
  'road',
  'verge',
  'marking',
  'building',
  'tree',
  'barrier',
  'track',
  'lamp',
  'object',
  'water',
  'terrain',
] as const;
export type SurfaceKind = (typeof kinds)[number];

/** Meshes are named by their kind (model/scene.hpp); the glTF loader may append to a name to keep names apart. */
export function kindOf(mesh: Mesh): SurfaceKind {
  return kinds.find((kind) => mesh.name.startsWith(kind)) ?? 'terrain';
}

/** What cars drive on, and nothing of what belongs to it. */
export function isRoadSurface(mesh: Mesh): boolean {
  return /^road(_in_tunnel)?(_\d+)*$/.test(mesh.name);
}

/** What stands beside the roads throws shadows and has no photo of its own. */
export function stands(mesh: Mesh): boolean {
  return ['building', 'tree', 'barrier', 'track', 'lamp', 'object'].includes(kindOf(mesh));
}

/** In the scene's axes: three.js shows those of the camera. */
function normalMaterial(): MeshNormalMaterial {
  const material = new MeshNormalMaterial();
  material.onBeforeCompile = (shader) => {
    const ofCamera = 'normalize( normal )';
    if (!shader.fragmentShader.includes(ofCamera))
      throw new Error('three.js has changed the shader of its normal material');
    shader.fragmentShader = shader.fragmentShader.replace(
      ofCamera,
      'normalize( ( vec4( normal, 0.0 ) * viewMatrix ).xyz )',
    );
  };
  return material;
}

interface Look {
  photo: MeshLambertMaterial;
  surface?: string; // name of a shared material
  labels?: MeshLambertMaterial; // made when they are shown
}

export class TileLooks {
  onChange: () => void = () => {};
  private readonly surfaceMaterials: SurfaceMaterials;
  private readonly ground: GroundDetail;
  private readonly looks = new Map<Mesh, Look>();
  private readonly normals = normalMaterial();
  private readonly relief: Record<SurfaceKind, MeshLambertMaterial> = {
    terrain: new MeshLambertMaterial({color: 0xd3d4ce}),
    verge: new MeshLambertMaterial({color: 0xd3d4ce}),
    road: new MeshLambertMaterial({color: 0x6b7078}),
    building: new MeshLambertMaterial({color: 0xb9b4ab}),
    tree: new MeshLambertMaterial({color: 0x7f8f72}),
    barrier: new MeshLambertMaterial({color: 0xa9a498}),
    track: new MeshLambertMaterial({color: 0x8b8378}),
    lamp: new MeshLambertMaterial({color: 0x8d9094}),
    object: new MeshLambertMaterial({color: 0x8d9094}),
    water: new MeshLambertMaterial({color: 0x8fb0bd}),
    marking: new MeshLambertMaterial({
      color: 0xf2f2ee,
      polygonOffset: true,
      polygonOffsetFactor: -4,
      polygonOffsetUnits: -4,
    }),
  };
  private pictures = 0; // of labels that are on their way

  constructor(private readonly anisotropy: number) {
    this.surfaceMaterials = new SurfaceMaterials(anisotropy);
    this.surfaceMaterials.onChange = () => this.onChange();
    this.ground = new GroundDetail(anisotropy);
    this.ground.onChange = () => this.onChange();
  }

  gltfLoader(manager: LoadingManager): GLTFLoader {
    return this.surfaceMaterials.gltfLoader(manager);
  }
  /** Pictures are on their way. */
  get pending(): boolean {
    return this.pictures > 0 || this.ground.pending || this.surfaceMaterials.pending;
  }

  /** Of one tile. */
  adopt(meshes: Mesh[]): void {
    const map: Texture | null =
      meshes.map((mesh) => (mesh.material as MeshStandardMaterial).map).find((one) => one !== null) ?? null;
    if (map) map.anisotropy = this.anisotropy;
    for (const mesh of meshes) {
      const own = mesh.material as MeshStandardMaterial;
      const photo = new MeshLambertMaterial({map});
      if (kindOf(mesh) === 'terrain') this.ground.adopt(mesh, photo);
      this.looks.set(mesh, {photo, surface: own.name === 'photo' ? undefined : own.name});
    }
  }

  update(eye: Vector3): void {
    this.ground.update(eye);
  }
  /** What stands on the ground near the eye, beside what is in the tiles. */
  get plants(): Object3D {
    return this.ground.object;
  }
  /** Patterns and plants near the eye; off: the photo alone. */
  set groundShown(on: boolean) {
    this.ground.shown = on;
  }

  materialOf(mesh: Mesh, layers: Layers): Material {
    const material = this.chosen(mesh, layers) as Material & {wireframe: boolean};
    material.wireframe = layers.wireframe;
    return material;
  }

  private chosen(mesh: Mesh, layers: Layers): Material {
    const look = this.looks.get(mesh)!;
    if (layers.normals) return this.normals;
    if (layers.labels) return stands(mesh) ? this.relief[kindOf(mesh)] : this.labelsOf(mesh, look);
    if (!layers.photo) return this.relief[kindOf(mesh)];
    if (look.surface !== undefined && (layers.materials || stands(mesh)))
      return this.surfaceMaterials.get(look.surface);
    return look.photo;
  }

  /** Grey until the picture is there, and where the tile has none. */
  private labelsOf(mesh: Mesh, look: Look): Material {
    if (look.labels) return look.labels;
    const material = new MeshLambertMaterial({color: 0xd3d4ce});
    look.labels = material;
    const picture = labelTexture(featuresOf(mesh));
    if (!picture) return material;
    ++this.pictures;
    void picture.then((map) => {
      --this.pictures;
      material.color.set(0xffffff);
      material.map = map;
      material.needsUpdate = true;
      this.onChange();
    });
    return material;
  }

  /** The renderer disposes of the glTF's own geometry and textures, not of what was made here. */
  release(meshes: Mesh[]): void {
    for (const mesh of meshes) {
      const look = this.looks.get(mesh);
      this.ground.release(mesh);
      look?.photo.dispose();
      look?.labels?.map?.dispose();
      look?.labels?.dispose();
      this.looks.delete(mesh);
    }
  }
}
