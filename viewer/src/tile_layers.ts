// The 3D Tiles of the site and what of them is shown.

import {type Tile, TilesRenderer} from '3d-tiles-renderer';
import {
  Camera, Group, Material, Mesh, MeshLambertMaterial, MeshStandardMaterial, Object3D, Raycaster, Sphere, Texture, Vector2, Vector3,
  WebGLRenderer,
} from 'three';

import {tilesetUrl} from './site';
import {SurfaceMaterials} from './surface_materials';
import {describeHit} from './tile_features';

export interface Layers {
  terrain: boolean;
  roads: boolean;
  photo: boolean;
  materials: boolean; // of roads and beside them; without: the photo there as well
  buildings: boolean;
  trees: boolean;
  wireframe: boolean;
}

const alwaysRefined_m = 1e4;
const kinds = ['road', 'verge', 'marking', 'building', 'tree', 'barrier', 'track', 'lamp', 'object', 'water', 'terrain'] as const;
type SurfaceKind = (typeof kinds)[number];

/** Meshes are named by their kind (model/scene.hpp); the glTF loader may append to a name to keep names apart. */
function kindOf(mesh: Mesh): SurfaceKind {
  return kinds.find((kind) => mesh.name.startsWith(kind)) ?? 'terrain';
}

/** What stands beside the roads throws shadows and has no photo of its own. */
function stands(mesh: Mesh): boolean {
  return ['building', 'tree', 'barrier', 'track', 'lamp', 'object'].includes(kindOf(mesh));
}

/** Every tile has a place of its own on the globe; here all lie on the flat map that the lap is in, where they meet. */
class FlatPlaces {
  readonly name = 'flat_places';
  private readonly origins = new WeakMap<object, [number, number, number]>();

  preprocessNode(tile: {transform?: number[]; extras?: {origin?: [number, number, number]}}, _folder: string, parent: object | null): void {
    const origin = tile.extras?.origin ?? [0, 0, 0];
    const from = (parent && this.origins.get(parent)) ?? [0, 0, 0];
    this.origins.set(tile, origin);
    tile.transform = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, origin[0] - from[0], origin[1] - from[1], origin[2] - from[2], 1];
  }
}

export class TileLayers {
  /** In the site's local frame: tiles lie on the flat map, see FlatPlaces. */
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
    barrier: new MeshLambertMaterial({color: 0xa9a498}),
    track: new MeshLambertMaterial({color: 0x8b8378}),
    lamp: new MeshLambertMaterial({color: 0x8d9094}),
    object: new MeshLambertMaterial({color: 0x8d9094}),
    water: new MeshLambertMaterial({color: 0x8fb0bd}),
    marking: new MeshLambertMaterial({color: 0xf2f2ee, polygonOffset: true, polygonOffsetFactor: -4, polygonOffsetUnits: -4}),
  };

  private camera?: Camera;

  constructor(private readonly anisotropy: number) {
    this.surfaceMaterials = new SurfaceMaterials(anisotropy);
    this.surfaceMaterials.onChange = () => this.onChange();
    this.tiles.manager.addHandler(/\.(gltf|glb)$/, this.surfaceMaterials.gltfLoader(this.tiles.manager));
    this.group.add(this.tiles.group);
    this.tiles.registerPlugin(new FlatPlaces());
    this.tiles.errorTarget = 2; // pixels that a coarser level may differ by
    this.tiles.lruCache.minBytesSize = 3e8;
    this.tiles.lruCache.maxBytesSize = 4e8;
    this.tiles.addEventListener('load-model', ({scene}) => this.adopt(scene));
    this.tiles.addEventListener('dispose-model', ({scene}) => this.release(scene));
    this.tiles.addEventListener('load-error', ({tile, error, url}) => {
      const shown = tile ? this.standIn(tile as Tile) : '';
      this.failures.push(`${url}: ${error.message}${shown}`);
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

  /** The renderer takes a tile that failed for a finished one and would leave a hole: its parent is shown, or its parts. */
  private standIn(tile: Tile): string {
    if (tile.children?.length) {
      tile.geometricError = alwaysRefined_m;
      return '; finer tiles are shown in its place';
    }
    if (!tile.parent?.content) return '';
    tile.parent.geometricError = 0;
    return '; a coarser one is shown in its place';
  }

  /** What stands or lies under a place of the picture (-1..1 to the right and up); empty: nothing that is known. */
  async describe(place: Vector2, camera: Camera): Promise<Record<string, string>> {
    const ray = new Raycaster();
    ray.setFromCamera(place, camera);
    const hit = ray.intersectObject(this.group, true).find(({object}) => object.visible && !['verge', 'marking'].includes(kindOf(object as Mesh)));
    return hit ? describeHit(hit) : {};
  }

  /** Height of the topmost shown surface at most at `below_z_m`; undefined where no tile is loaded. */
  heightAt(x_m: number, y_m: number, below_z_m: number): number | undefined {
    const ray = new Raycaster(new Vector3(x_m, y_m, below_z_m), new Vector3(0, 0, -1));
    return ray.intersectObject(this.group, true)[0]?.point.z;
  }

  /** Bounding sphere in the local frame, once the tileset is there. */
  bounds(): Sphere | undefined {
    const sphere = new Sphere();
    return this.tiles.getBoundingSphere(sphere) ? sphere : undefined;
  }

  update(camera: Camera, renderer: WebGLRenderer): void {
    if (camera !== this.camera) { // one that is left asks for no tiles any more
      if (this.camera) this.tiles.deleteCamera(this.camera);
      this.camera = camera;
      this.tiles.setCamera(camera);
    }
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
      if (['tree', 'lamp'].includes(kindOf(mesh))) mesh.raycast = () => {}; // thousands of copies, and nothing stands on them
      mesh.castShadow = stands(mesh) || mesh.name.startsWith('road_tube'); // no sun in tunnels
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
      case 'terrain':
      case 'water': return terrain;
      case 'road': return roads;
      case 'verge': return terrain && roads && photo && materials;
      case 'marking': return roads && materials;
      case 'building':
      case 'barrier':
      case 'track':
      case 'lamp':
      case 'object': return buildings;
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
