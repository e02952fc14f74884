// The 3D Tiles of the site and what of them is shown.

import {TilesRenderer} from '3d-tiles-renderer';
import {
  Camera, Group, Material, Matrix4, Mesh, MeshLambertMaterial, MeshStandardMaterial, Object3D, Raycaster, Sphere, Texture, Vector3,
  WebGLRenderer,
} from 'three';

import {tilesetUrl} from './site';
import {SurfaceMaterials} from './surface_materials';

export interface Layers {
  terrain: boolean;
  roads: boolean;
  photo: boolean;
  materials: boolean; // of roads and beside them; without: the photo there as well
  buildings: boolean;
  trees: boolean;
  wireframe: boolean;
}

const kinds = ['road', 'verge', 'marking', 'building', 'tree', 'terrain'] as const;
type SurfaceKind = (typeof kinds)[number];

/** Meshes are named by their kind (model/scene.hpp); the glTF loader may append to a name to keep names apart. */
function kindOf(mesh: Mesh): SurfaceKind {
  return kinds.find((kind) => mesh.name.startsWith(kind)) ?? 'terrain';
}

/** What stands beside the roads has no photo of its own. */
function stands(mesh: Mesh): boolean {
  return ['building', 'tree'].includes(kindOf(mesh));
}

export class TileLayers {
  /** In the site's local frame: the tileset's root transform (local to ECEF) is undone. */
  readonly group = new Group();
  readonly layers: Layers = {terrain: true, roads: true, photo: true, materials: true, buildings: true, trees: true, wireframe: false};
  loaded = 0;
  readonly failures: string[] = [];
  onChange: () => void = () => {};

  private readonly tiles = new TilesRenderer(tilesetUrl);
  private readonly surfaceMaterials: SurfaceMaterials;
  private readonly looks = new Map<Mesh, {photo: MeshLambertMaterial; surface?: string}>();
  private readonly reliefMaterials: Record<SurfaceKind, MeshLambertMaterial> = {
    terrain: new MeshLambertMaterial({color: 0xd3d4ce}),
    verge: new MeshLambertMaterial({color: 0xd3d4ce}),
    road: new MeshLambertMaterial({color: 0x6b7078}),
    building: new MeshLambertMaterial({color: 0xb9b4ab}),
    tree: new MeshLambertMaterial({color: 0x7f8f72}),
    marking: new MeshLambertMaterial({color: 0xf2f2ee, polygonOffset: true, polygonOffsetFactor: -4, polygonOffsetUnits: -4}),
  };

  constructor(localFromEcef: Matrix4, private readonly anisotropy: number) {
    this.surfaceMaterials = new SurfaceMaterials(anisotropy);
    this.surfaceMaterials.onChange = () => this.onChange();
    this.tiles.manager.addHandler(/\.(gltf|glb)$/, this.surfaceMaterials.gltfLoader(this.tiles.manager));
    this.group.matrixAutoUpdate = false;
    this.group.matrix.copy(localFromEcef);
    this.group.add(this.tiles.group);
    this.tiles.errorTarget = 1; // pixels: there is one level of detail, so that all tiles in view are wanted
    // A whole town at 0.5 m/px has 0.7 GB of textures; the default limit of 0.4 GB would load and drop them in turns.
    this.tiles.lruCache.minBytesSize = 1.5e9;
    this.tiles.lruCache.maxBytesSize = 2e9;
    this.tiles.addEventListener('load-model', ({scene}) => this.adopt(scene));
    this.tiles.addEventListener('dispose-model', ({scene}) => this.release(scene));
    this.tiles.addEventListener('load-error', ({error, url}) => {
      this.failures.push(`${url}: ${error.message}`);
      this.onChange();
    });
    for (const event of ['load-root-tileset', 'tile-visibility-change', 'needs-update'] as const)
      this.tiles.addEventListener(event, () => this.onChange());
  }

  get visible(): number {
    return this.tiles.visibleTiles.size;
  }
  /** Nothing more to load for the present view. */
  get complete(): boolean {
    return this.tiles.root !== null && this.tiles.loadProgress === 1;
  }

  /** Height of the topmost shown surface at most at `below_z_m`; undefined where no tile is loaded. */
  heightAt(x_m: number, y_m: number, below_z_m: number): number | undefined {
    const ray = new Raycaster(new Vector3(x_m, y_m, below_z_m), new Vector3(0, 0, -1));
    return ray.intersectObject(this.group, true)[0]?.point.z;
  }

  /** Bounding sphere in the local frame, once the tileset is there. */
  bounds(): Sphere | undefined {
    const sphere = new Sphere();
    return this.tiles.getBoundingSphere(sphere) ? sphere.applyMatrix4(this.group.matrix) : undefined;
  }

  update(camera: Camera, renderer: WebGLRenderer): void {
    this.tiles.setCamera(camera);
    this.tiles.setResolutionFromRenderer(camera, renderer);
    this.tiles.update();
  }

  setLayer(layer: keyof Layers, on: boolean): void {
    this.layers[layer] = on;
    this.tiles.forEachLoadedModel((model) => this.apply(model));
    this.onChange();
  }

  private adopt(model: Object3D): void {
    ++this.loaded;
    const meshes = meshesOf(model);
    const photos = meshes.map((mesh) => (mesh.material as MeshStandardMaterial).map).filter((map) => map !== null);
    const map: Texture | null = photos[0] ?? null;
    if (map) map.anisotropy = this.anisotropy;
    for (const mesh of meshes) {
      if (kindOf(mesh) === 'tree') mesh.raycast = () => {}; // thousands of copies, and nothing stands on them
      mesh.castShadow = stands(mesh);
      mesh.receiveShadow = true;
      const own = mesh.material as MeshStandardMaterial;
      this.looks.set(mesh, {photo: new MeshLambertMaterial({map}), surface: own.name === 'photo' ? undefined : own.name});
    }
    this.apply(model);
    this.onChange();
  }

  private materialOf(mesh: Mesh): Material {
    const {photo, surface} = this.looks.get(mesh)!;
    const {layers} = this;
    const material = !layers.photo ? this.reliefMaterials[kindOf(mesh)] :
                     surface !== undefined && (layers.materials || stands(mesh)) ?
                       this.surfaceMaterials.get(surface) : photo;
    material.wireframe = layers.wireframe;
    return material;
  }

  private isShown(kind: SurfaceKind): boolean {
    const {terrain, roads, photo, materials, buildings, trees} = this.layers;
    switch (kind) {
      case 'terrain': return terrain;
      case 'road': return roads;
      case 'verge': return terrain && roads && photo && materials;
      case 'marking': return roads && materials;
      case 'building': return buildings;
      case 'tree': return trees;
    }
  }

  private apply(model: Object3D): void {
    for (const mesh of meshesOf(model)) {
      mesh.material = this.materialOf(mesh);
      mesh.visible = this.isShown(kindOf(mesh));
    }
  }

  /** The renderer disposes of the glTF's own geometry and textures, not of our materials. */
  private release(model: Object3D): void {
    --this.loaded;
    for (const mesh of meshesOf(model)) {
      this.looks.get(mesh)?.photo.dispose();
      this.looks.delete(mesh);
    }
  }
}

function meshesOf(model: Object3D): Mesh[] {
  const meshes: Mesh[] = [];
  model.traverse((object) => {
    if (object instanceof Mesh) meshes.push(object);
  });
  return meshes;
}
