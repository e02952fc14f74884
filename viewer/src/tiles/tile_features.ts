// SPDX-License-Identifier: Apache-2.0
// What the parts of a tile are: roads and buildings by ids of the vertices (EXT_mesh_features), classes by the labels'
// picture, both with rows of a table (EXT_structural_metadata).

import {
  type BufferGeometry,
  CanvasTexture,
  type Intersection,
  type Mesh,
  NearestFilter,
  type Object3D,
  SRGBColorSpace,
} from 'three';
import type {GLTFLoaderPlugin, GLTFParser} from 'three/addons/loaders/GLTFLoader.js';

type Row = Record<string, string>;

interface TableJson {
  class: string;
  count: number;
  properties: Record<string, {values: number; stringOffsets: number}>;
}
interface FeatureIdsJson {
  label: string;
  texture?: {index: number};
}
interface GltfJson {
  extensions?: {EXT_structural_metadata?: {propertyTables: TableJson[]}};
  meshes: {primitives: {extensions?: {EXT_mesh_features?: {featureIds: FeatureIdsJson[]}}}[]}[];
  textures: {source: number}[];
  images: {bufferView: number}[];
}

/** Of one tile; kept in userData.features of its scene. */
interface TileFeatures {
  objects: Row[];
  labels: Row[];
  labelPicture?: Blob;
  labelTexture?: Promise<CanvasTexture>; // made when it is asked for
}

async function bytesOf(parser: GLTFParser, view: number): Promise<ArrayBuffer> {
  return (await parser.getDependency('bufferView', view)) as ArrayBuffer;
}

async function readTable(parser: GLTFParser, table: TableJson | undefined): Promise<Row[]> {
  if (!table) return [];
  const rows: Row[] = Array.from({length: table.count}, () => ({}));
  for (const [name, {values, stringOffsets}] of Object.entries(table.properties)) {
    const text = new Uint8Array(await bytesOf(parser, values));
    const ends = new Uint32Array(await bytesOf(parser, stringOffsets), 0, table.count + 1);
    rows.forEach((row, i) => (row[name] = new TextDecoder().decode(text.subarray(ends[i], ends[i + 1]))));
  }
  return rows;
}

/** For GLTFLoader.register(). */
export function tileFeaturesPlugin(parser: GLTFParser): GLTFLoaderPlugin {
  return {
    name: 'tile_features',
    async afterRoot(gltf): Promise<void> {
      const json = parser.json as GltfJson;
      const tables = json.extensions?.EXT_structural_metadata?.propertyTables ?? [];
      const find = (name: string) => tables.find((table) => table.class === name);
      const ids = json.meshes
        .flatMap((mesh) => mesh.primitives)
        .flatMap((part) => part.extensions?.EXT_mesh_features?.featureIds ?? []);
      const texture = ids.find((id) => id.label === 'label')?.texture;
      const features: TileFeatures = {
        objects: await readTable(parser, find('object')),
        labels: await readTable(parser, find('label')),
      };
      if (texture)
        features.labelPicture = new Blob(
          [await bytesOf(parser, json.images[json.textures[texture.index].source].bufferView)],
          {type: 'image/png'},
        );
      gltf.scene.userData.features = features;
    },
  };
}

export function featuresOf(object: Object3D | null): TileFeatures | undefined {
  for (; object; object = object.parent) if (object.userData.features) return object.userData.features as TileFeatures;
  return undefined;
}

/** The classes of a tile in their colours, for what shows the photo; undefined: the tile has no labels. */
export function labelTexture(features: TileFeatures | undefined): Promise<CanvasTexture> | undefined {
  if (!features?.labelPicture) return undefined;
  features.labelTexture ??= colored(features.labels, features.labelPicture);
  return features.labelTexture;
}

/** Values of the labels are in the first of four channels. Drawn by the processor: pixels come back from a GPU with a pause. */
async function labelsOf(labelPicture: Blob): Promise<ImageData> {
  const picture = await createImageBitmap(labelPicture, {colorSpaceConversion: 'none', premultiplyAlpha: 'none'});
  const context = new OffscreenCanvas(picture.width, picture.height).getContext('2d', {willReadFrequently: true})!;
  context.drawImage(picture, 0, 0);
  return context.getImageData(0, 0, picture.width, picture.height);
}

async function colored(labels: Row[], labelPicture: Blob): Promise<CanvasTexture> {
  const pixels = await labelsOf(labelPicture);
  const canvas = document.createElement('canvas');
  [canvas.width, canvas.height] = [pixels.width, pixels.height];
  const colors = labels.map(({color}) => parseInt(color?.slice(1) ?? '', 16)); // NaN in tiles of older versions: black
  for (let i = 0; i < pixels.data.length; i += 4) {
    const color = colors[pixels.data[i]] ?? 0xffffff;
    pixels.data.set([color >> 16, (color >> 8) & 255, color & 255, 255], i);
  }
  canvas.getContext('2d')!.putImageData(pixels, 0, 0);
  const texture = new CanvasTexture(canvas);
  texture.flipY = false;
  texture.colorSpace = SRGBColorSpace;
  texture.magFilter = NearestFilter;
  return texture;
}

export interface RoleWeights {
  data: Uint8Array;
  width: number;
  height: number;
}

const weightOf: Record<string, number> = {
  ground: 0,
  vegetation: 1,
  road: 2,
  maybe_road: 2,
  building: 2,
  other: 2,
  rail: 3,
};

/** Shares of open ground, plants, paving and rails in squares of two pixels of the labels (0 to 255); undefined: no labels. */
export function roleWeights(features: TileFeatures | undefined): Promise<RoleWeights> | undefined {
  return features?.labelPicture && weighed(features.labels, features.labelPicture);
}

async function weighed(labels: Row[], labelPicture: Blob): Promise<RoleWeights> {
  const ids = await labelsOf(labelPicture);
  const [width, height] = [ids.width >> 1, ids.height >> 1];
  const channels = labels.map(({role}) => weightOf[role]);
  const data = new Uint8Array(4 * width * height);
  for (let y = 0; y < 2 * height; ++y)
    for (let x = 0; x < 2 * width; ++x) {
      const channel = channels[ids.data[4 * (y * ids.width + x)]];
      if (channel !== undefined) data[4 * ((y >> 1) * width + (x >> 1)) + channel] += 63;
    }
  return {data, width, height};
}

/** The label at a place of the photo. */
async function labelAt({labels, labelPicture}: TileFeatures, u: number, v: number): Promise<Row | undefined> {
  if (!labelPicture) return undefined;
  const {data, width, height} = await labelsOf(labelPicture);
  const at = (share: number, size: number) => Math.min(size - 1, Math.max(0, Math.floor(share * size)));
  return labels[data[4 * (at(v, height) * width + at(u, width))]];
}

/** What was hit: kind, id, osm_id, name, type of a road or building, lane_id and lane_type of a road; class and role of the photo there. */
export async function describeHit(hit: Intersection): Promise<Row> {
  const mesh = hit.object as Mesh<BufferGeometry>;
  const features = featuresOf(mesh);
  if (!features || !hit.face) return {};
  const ids = mesh.geometry.getAttribute('_feature_id_0');
  const object = ids && features.objects[ids.getX(hit.face.a)];
  const label = !object || object.kind === 'road' ? hit.uv && (await labelAt(features, hit.uv.x, hit.uv.y)) : undefined;
  const row: Row = {...object, ...(label ? {class: label.name, role: label.role} : {})};
  return Object.fromEntries(Object.entries(row).filter(([, value]) => value !== ''));
}
