// SPDX-License-Identifier: Apache-2.0
// The 3D Tiles of the site and what of them is shown.

import {type Tile, TilesRenderer} from '3d-tiles-renderer';
import {
  type Camera,
  Group,
  Mesh,
  MeshDepthMaterial,
  type Object3D,
  Raycaster,
  Sphere,
  type Vector2,
  Vector3,
  type WebGLRenderer,
} from 'three';

import {type Site, tilesetUrl} from '../site';
import {graphicsBytes} from './tile_bytes';
import {describeHit} from './tile_features';
import {isRoadSurface, kindOf, type Layers, type SurfaceKind, stands, TileLooks} from './tile_looks';

const alwaysRefined_m = 1e4;
const tubeCasts_m = 0.4;
const topDepth = 2; // of the renderer's own counting: the root and its parts

/**
 * A tube has inner faces only, which throw its shadow from where its floor begins. What lies nearer to a wall than the bias and a
 * texel of the shadow map would be lit: a thin line along the wall's foot. So tubes throw their shadow from as far towards the sun
 * as their walls are thick.
 */
function tubeShadow(): MeshDepthMaterial {
  const material = new MeshDepthMaterial();
  material.onBeforeCompile = (shader) => {
    const place = '#include <project_vertex>';
    if (!shader.vertexShader.includes(place)) throw new Error('three.js has changed the shader of its depth material');
    shader.vertexShader = shader.vertexShader.replace(
      place,
      `${place}\ngl_Position.z += ${tubeCasts_m} * projectionMatrix[2][2];`,
    );
  };
  return material;
}

type LoadedTile = Tile & {engineData: {scene: Object3D | null}};

/** A tile in memory. */
export interface HeldTile {
  file: string;
  error_m: number; // of what is drawn; 0: level 0
  bytes: number; // of the graphics card
  visible: boolean;
}

/**
 * Positive: `a` mends the picture more than `b`, by the error of what is shown as long as it is missing. All parts of a
 * tile that the camera is in come first, coarse ones before fine ones: only all four together replace it. (The renderer's
 * own order goes by a tile's own error, which is 0 for the finest: what lies under the wheels would come last.)
 */
function byGain(a: Tile, b: Tile): number {
  const [gainA, gainB] = [a, b].map((tile) => tile.parent?.traversal.error ?? Infinity);
  if (a.traversal.used !== b.traversal.used) return a.traversal.used ? 1 : -1;
  if (gainA !== gainB) return gainA > gainB ? 1 : -1;
  if (a.internal.depth !== b.internal.depth) return b.internal.depth - a.internal.depth;
  return b.traversal.distanceFromCamera - a.traversal.distanceFromCamera || 0; // infinitely far both: NaN
}
/** Positive: `a` is dropped before `b`. */
function byAge(a: Tile, b: Tile): number {
  const [seenA, seenB] = [a, b].map(
    ({traversal}) => (traversal as Tile['traversal'] & {lastFrameVisited: number}).lastFrameVisited,
  );
  return seenA !== seenB ? seenB - seenA : -byGain(a, b);
}

/** Every tile has a place of its own on the globe; here all lie on the flat map that the lap is in, where they meet. */
class FlatPlaces {
  readonly name = 'flat_places';
  private readonly origins = new WeakMap<object, [number, number, number]>();

  preprocessNode(
    tile: {transform?: number[]; extras?: {origin?: [number, number, number]}},
    _folder: string,
    parent: object | null,
  ): void {
    const origin = tile.extras?.origin ?? [0, 0, 0];
    const from = (parent && this.origins.get(parent)) ?? [0, 0, 0];
    this.origins.set(tile, origin);
    tile.transform = [
      1,
      0,
      0,
      0,
      0,
      1,
      0,
      0,
      0,
      0,
      1,
      0,
      origin[0] - from[0],
      origin[1] - from[1],
      origin[2] - from[2],
      1,
    ];
  }
}

export class TileLayers {
  /** In the site's local frame: tiles lie on the flat map, see FlatPlaces. */
  readonly group = new Group();
  readonly layers: Layers = {
    terrain: true,
    roads: true,
    photo: true,
    labels: false,
    normals: false,
    materials: true,
    buildings: true,
    trees: true,
    wireframe: false,
  };
  loaded = 0;
  readonly failures: string[] = [];
  onChange: () => void = () => {};

  private readonly tiles = new TilesRenderer(tilesetUrl);
  private readonly looks: TileLooks;
  private readonly tubeShadow = tubeShadow();
  private readonly bytes = new WeakMap<Object3D, number>(); // of the models of tiles
  private camera?: Camera;

  constructor({tileset, coarsest}: Site, anisotropy: number) {
    this.looks = new TileLooks(anisotropy);
    this.looks.onChange = () => this.onChange();
    this.tiles.manager.addHandler(/\.(gltf|glb)$/, this.looks.gltfLoader(this.tiles.manager));
    this.group.add(this.tiles.group, this.looks.plants);
    this.tiles.registerPlugin(new FlatPlaces());
    const fetched = (url: string) =>
      url === tilesetUrl ? Promise.resolve(tileset) : coarsest.get(new URL(url, location.href).href);
    this.tiles.registerPlugin({
      name: 'read_once',
      fetchData: (url: string) => {
        const data = fetched(url);
        coarsest.delete(new URL(url, location.href).href); // an answer can be read once
        return data ?? null;
      },
    });
    this.tiles.maxDepth = topDepth;
    this.tiles.autoDisableRendererCulling = false; // parts of a tile that picture or shadow map do not show are not drawn
    this.tiles.errorTarget = 2; // pixels that a coarser level may differ by
    this.tiles.lruCache.minBytesSize = 2.8e8;
    this.tiles.lruCache.maxBytesSize = 3.8e8; // one more tile may come in before it is seen to be full
    this.tiles.lruCache.unloadPriorityCallback = byAge as (item: unknown) => number; // typed for an older way of calling it
    this.tiles.downloadQueue.priorityCallback = this.tiles.parseQueue.priorityCallback = byGain;
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

  /** From now on finer tiles than the coarsest are asked for. */
  allowFine(): void {
    this.tiles.maxDepth = Infinity;
  }

  get visible(): number {
    return this.tiles.visibleTiles.size;
  }
  /** A tile, coarse as it may be, lies wherever the present view shows the site. */
  get covered(): boolean {
    const top = this.tiles.root?.children ?? [];
    return (
      this.visible > 0 &&
      top.every((tile) => !tile.traversal.inFrustum || (tile as LoadedTile).engineData.scene !== null)
    );
  }
  get held(): HeldTile[] {
    const held: HeldTile[] = [];
    this.tiles.forEachLoadedModel((model: Object3D, tile: Tile) =>
      held.push({
        file: tile.content!.uri!,
        error_m: tile.geometricError,
        bytes: this.bytes.get(model) ?? 0,
        visible: this.tiles.visibleTiles.has(tile),
      }),
    );
    return held;
  }

  /** Nothing more to load for the present view. */
  get complete(): boolean {
    // The renderer's own loadProgress is 1 for a moment between loading and reading a tile, and before it has asked for any.
    const {queued, downloading, parsing} = (
      this.tiles as typeof this.tiles & {stats: Record<'queued' | 'downloading' | 'parsing', number>}
    ).stats;
    return (
      this.tiles.root !== null &&
      !this.tiles.processNodeQueue.running &&
      queued + downloading + parsing === 0 &&
      !this.looks.pending
    );
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
    const hit = ray
      .intersectObject(this.group, true)
      .find(({object}) => object.visible && !['verge', 'marking'].includes(kindOf(object as Mesh)));
    return hit ? describeHit(hit) : {};
  }

  /** Height of the topmost ground or road at most at `below_z_m`, nothing that stands on it; undefined where no tile is loaded. */
  heightAt(x_m: number, y_m: number, below_z_m: number): number | undefined {
    const ray = new Raycaster(new Vector3(x_m, y_m, below_z_m), new Vector3(0, 0, -1));
    return ray.intersectObject(this.group, true).find(({object}) => !stands(object as Mesh))?.point.z;
  }

  /** The road that is drawn nearest to a height, and the error of its tile; undefined: none within 50 m. */
  roadNear(x_m: number, y_m: number, z_m: number): {z_m: number; error_m: number} | undefined {
    const reach_m = 50;
    const ray = new Raycaster(new Vector3(x_m, y_m, z_m + reach_m), new Vector3(0, 0, -1), 0, 2 * reach_m);
    let nearest: {z_m: number; error_m: number} | undefined;
    this.tiles.visibleTiles.forEach((tile) => {
      const meshes = meshesOf((tile as LoadedTile).engineData.scene!).filter(
        (mesh) => mesh.visible && isRoadSurface(mesh),
      );
      for (const {point} of ray.intersectObjects(meshes, false))
        if (!nearest || Math.abs(point.z - z_m) < Math.abs(nearest.z_m - z_m))
          nearest = {z_m: point.z, error_m: tile.geometricError};
    });
    return nearest;
  }

  /** Bounding sphere in the local frame, once the tileset is there. */
  bounds(): Sphere | undefined {
    const sphere = new Sphere();
    return this.tiles.getBoundingSphere(sphere) ? sphere : undefined;
  }

  update(camera: Camera, renderer: WebGLRenderer): void {
    if (camera !== this.camera) {
      // one that is left asks for no tiles any more
      if (this.camera) this.tiles.deleteCamera(this.camera);
      this.camera = camera;
      this.tiles.setCamera(camera);
    }
    this.tiles.setResolutionFromRenderer(camera, renderer);
    this.tiles.update();
    this.looks.update(camera.getWorldPosition(new Vector3()));
  }

  setLayer(layer: keyof Layers, on: boolean): void {
    this.layers[layer] = on;
    this.looks.groundShown = this.isShown('verge');
    this.tiles.forEachLoadedModel((model) => this.apply(model));
    this.onChange();
  }

  private adopt(model: Object3D): void {
    ++this.loaded;
    const meshes = meshesOf(model);
    this.bytes.set(model, graphicsBytes(meshes));
    this.looks.adopt(meshes);
    for (const mesh of meshes) {
      if (['tree', 'lamp'].includes(kindOf(mesh))) mesh.raycast = () => {}; // thousands of copies, and nothing stands on them
      const isTube = mesh.name.startsWith('road_tube');
      mesh.castShadow = stands(mesh) || isTube; // no sun in tunnels
      if (isTube) mesh.customDepthMaterial = this.tubeShadow;
      mesh.receiveShadow = true;
    }
    this.apply(model);
    this.onChange();
  }

  private isShown(kind: SurfaceKind): boolean {
    const {terrain, roads, photo, labels, normals, materials, buildings, trees} = this.layers;
    const asSeen = photo && !labels && !normals; // no layer that shows something else of the ground
    switch (kind) {
      case 'terrain':
      case 'water':
        return terrain;
      case 'road':
        return roads;
      case 'verge':
        return terrain && roads && materials && asSeen;
      case 'marking':
        return roads && materials && !labels && !normals;
      case 'building':
      case 'barrier':
      case 'track':
      case 'lamp':
      case 'object':
        return buildings;
      case 'tree':
        return trees;
    }
  }

  private apply(model: Object3D): void {
    for (const mesh of meshesOf(model)) {
      mesh.material = this.looks.materialOf(mesh, this.layers);
      mesh.visible = this.isShown(kindOf(mesh));
    }
  }

  /** The renderer disposes of the glTF's own geometry and textures, not of our materials. */
  private release(model: Object3D): void {
    --this.loaded;
    this.looks.release(meshesOf(model));
  }
}

function meshesOf(model: Object3D): Mesh[] {
  const meshes: Mesh[] = [];
  model.traverse((object) => {
    if (object instanceof Mesh) meshes.push(object);
  });
  return meshes;
}
