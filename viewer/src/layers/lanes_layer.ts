// SPDX-License-Identifier: Apache-2.0
// The lanes of all roads, coloured by their types, on the surface that is driven.

import {
  BufferGeometry,
  Color,
  DoubleSide,
  Float32BufferAttribute,
  Group,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  NotEqualStencilFunc,
  type Object3D,
  ReplaceStencilOp,
} from 'three';

import {roadsModule} from '../roads_module';

/** In the order of roadquery::LaneType: none, driving, shoulder, border, sidewalk, parking, biking, other. */
const colors = [0x9aa3aa, 0x2f8fe0, 0xb9a06a, 0x8a8f6a, 0xe0a53c, 0x9a62c8, 0x36b37e, 0x9aa3aa].map(
  (color) => new Color(color),
);
const over_m = 0.06; // the surface, so that it is not hidden by kerbs and paint

interface Drawn {
  positions: number[];
  colors: number[];
  triangles: number[];
  borders: number[]; // pairs of positions
}

/** Reads one strip (viewer/driving/lane_strips.hpp) and returns where the next begins. */
function addStrip(strips: Float32Array, at: number, drawn: Drawn): number {
  const [type, junction, count] = strips.subarray(at, at + 3);
  const first = drawn.positions.length / 3,
    start = at + 3;
  for (let i = 0; i < 2 * count; ++i) {
    const place = start + 3 * i;
    drawn.positions.push(strips[place], strips[place + 1], strips[place + 2] + over_m);
    drawn.colors.push(...(colors[type] ?? colors[0]).toArray());
  }
  for (let i = 0; i + 1 < count; ++i) {
    const a = first + 2 * i;
    drawn.triangles.push(a, a + 1, a + 2, a + 1, a + 3, a + 2);
    if (junction >= 0) continue; // ways over a junction lie one upon the other
    for (const side of [0, 1]) drawn.borders.push(a + side, a + 2 + side);
  }
  return start + 6 * count;
}

/** Many lanes lie in one place where roads meet: the stencil lets each pixel be tinted once. */
function tint(): MeshBasicMaterial {
  return new MeshBasicMaterial({
    vertexColors: true,
    transparent: true,
    opacity: 0.55,
    depthWrite: false,
    side: DoubleSide,
    polygonOffset: true,
    polygonOffsetFactor: -8,
    polygonOffsetUnits: -8,
    stencilWrite: true,
    stencilRef: 1,
    stencilFunc: NotEqualStencilFunc,
    stencilZPass: ReplaceStencilOp,
  });
}

export async function loadLanes(origin: readonly [number, number, number]): Promise<Object3D> {
  const module = await roadsModule();
  const count = module.make_strips(...origin);
  const strips = new Float32Array(module.memory.buffer, module.strips_at(), count);
  const drawn: Drawn = {positions: [], colors: [], triangles: [], borders: []};
  for (let at = 0; at < count; ) at = addStrip(strips, at, drawn);
  const positions = new Float32BufferAttribute(drawn.positions, 3);
  const areas = new BufferGeometry()
    .setAttribute('position', positions)
    .setAttribute('color', new Float32BufferAttribute(drawn.colors, 3));
  areas.setIndex(drawn.triangles);
  const borders = new BufferGeometry().setAttribute('position', positions);
  borders.setIndex(drawn.borders);
  const layer = new Group();
  layer.add(
    new Mesh(areas, tint()),
    new LineSegments(borders, new LineBasicMaterial({color: 0xffffff, transparent: true, opacity: 0.8})),
  );
  layer.children[1].renderOrder = 1;
  return layer;
}
