// SPDX-License-Identifier: Apache-2.0
// Tufts of grass around the eye, on the triangles of a tile's terrain: where they stand depends on the triangle alone.

import {
  type BufferGeometry,
  DoubleSide,
  Float32BufferAttribute,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  Mesh,
  MeshLambertMaterial,
  Vector3,
} from 'three';
import {randomOf} from '../noise';
import {groundTintGlsl} from './ground_tint';

const reach_m = 26,
  step_m = 5; // tufts are looked for anew when the eye has moved so far
const perSquare = 1.1; // tufts a square metre
const most = 3600,
  blades = 7;

/** Whether grass may stand at a place of the photo. */
type IsGrass = (u: number, v: number) => boolean;

/** A tuft in the frame of the tile: y up. Blades are triangles that lean outwards. */
function tuft(): InstancedBufferGeometry {
  const random = randomOf(31),
    positions: number[] = [],
    shades: number[] = [];
  for (let i = 0; i < blades; ++i) {
    const angle = (2 * Math.PI * (i + random())) / blades,
      lean = 0.25 + 0.5 * random(),
      height = 0.6 + 0.4 * random();
    const [cos, sin] = [Math.cos(angle), Math.sin(angle)],
      width = 0.035,
      from = 0.12 * random();
    positions.push(
      from * cos - width * sin,
      0,
      from * sin + width * cos,
      from * cos + width * sin,
      0,
      from * sin - width * cos,
      lean * cos,
      height,
      lean * sin,
    );
    shades.push(0.55, 0.55, 1.25);
  }
  const geometry = new InstancedBufferGeometry();
  geometry.setAttribute('position', new Float32BufferAttribute(positions, 3));
  geometry.setAttribute(
    'normal',
    new Float32BufferAttribute(
      positions.map((_, i) => (i % 3 === 1 ? 1 : 0)),
      3,
    ),
  );
  geometry.setAttribute('shade', new Float32BufferAttribute(shades, 1));
  return geometry;
}

export class GroundPlants {
  readonly object: Mesh<InstancedBufferGeometry, MeshLambertMaterial>;
  private readonly places = new InstancedBufferAttribute(new Float32Array(4 * most), 4); // place and size
  private readonly placesInPhoto = new InstancedBufferAttribute(new Float32Array(4 * most), 4); // and slope of the ground
  private middle?: Vector3;

  constructor(
    private readonly ground: Mesh<BufferGeometry>,
    private readonly isGrass: IsGrass,
    photo: MeshLambertMaterial,
    lowLod: {value: number},
  ) {
    const geometry = tuft();
    geometry.setAttribute('place', this.places);
    geometry.setAttribute('placeInPhoto', this.placesInPhoto);
    geometry.instanceCount = 0;
    const material = new MeshLambertMaterial({side: DoubleSide});
    material.onBeforeCompile = (shader) => {
      Object.assign(shader.uniforms, {photo: {value: photo.map}, lowLod});
      shader.vertexShader = shader.vertexShader
        .replace(
          '#include <common>',
          `#include <common>
        attribute float shade;
        attribute vec4 place, placeInPhoto;
        uniform sampler2D photo;
        uniform float lowLod;
        varying vec3 tuftColor;
        ${groundTintGlsl}`,
        )
        .replace(
          '#include <beginnormal_vertex>',
          `
        vec3 objectNormal = normalize(vec3(-placeInPhoto.z, 1.0, -placeInPhoto.w));`,
        )
        .replace(
          '#include <begin_vertex>',
          `
        float green;
        tuftColor = shade * grassTint(groundTint(photo, placeInPhoto.xy, lowLod, green));
        float away = distance((modelViewMatrix * vec4(place.xyz, 1.0)).xyz, vec3(0.0));
        float size = place.w * smoothstep(0.3, 0.7, green) * (1.0 - smoothstep(${(0.6 * reach_m).toFixed(1)}, ${reach_m.toFixed(1)}, away));
        float turn = 40.0 * place.w + 7.0 * place.x;
        vec3 turned = vec3(cos(turn) * position.x - sin(turn) * position.z, position.y, sin(turn) * position.x + cos(turn) * position.z);
        vec3 transformed = place.xyz + size * turned;`,
        );
      shader.fragmentShader = shader.fragmentShader
        .replace('#include <common>', '#include <common>\nvarying vec3 tuftColor;')
        .replace('#include <map_fragment>', 'diffuseColor.rgb = tuftColor;')
        .replace(
          '#include <normal_fragment_begin>',
          `
        vec3 normal = normalize(vNormal);
        vec3 nonPerturbedNormal = normal;`,
        );
    };
    this.object = new Mesh(geometry, material);
    this.object.matrixAutoUpdate = false;
    this.object.frustumCulled = false;
    this.object.receiveShadow = true;
    this.object.raycast = () => {};
  }

  /** `eye` in the scene's frame. Returns true when the tufts have changed. */
  update(eye: Vector3): boolean {
    const local = this.ground.worldToLocal(eye.clone());
    if (this.middle && this.middle.distanceTo(local) < step_m) return false;
    this.middle = local;
    this.object.matrix.copy(this.ground.matrixWorld);
    this.object.matrixWorldNeedsUpdate = true;
    const before = this.object.geometry.instanceCount;
    this.object.geometry.instanceCount = this.plant(local);
    this.places.needsUpdate = this.placesInPhoto.needsUpdate = true;
    return before > 0 || this.object.geometry.instanceCount > 0;
  }

  private plant(eye: Vector3): number {
    const {index} = this.ground.geometry,
      position = this.ground.geometry.getAttribute('position'),
      uv = this.ground.geometry.getAttribute('uv');
    const reach = reach_m + step_m;
    const [a, b, c, place] = [new Vector3(), new Vector3(), new Vector3(), new Vector3()];
    let count = 0;
    for (let i = 0; i < index!.count; i += 3) {
      const [ia, ib, ic] = [index!.getX(i), index!.getX(i + 1), index!.getX(i + 2)];
      a.fromBufferAttribute(position, ia);
      b.fromBufferAttribute(position, ib);
      c.fromBufferAttribute(position, ic);
      if (Math.min(a.x, b.x, c.x) > eye.x + reach || Math.max(a.x, b.x, c.x) < eye.x - reach) continue;
      if (Math.min(a.z, b.z, c.z) > eye.z + reach || Math.max(a.z, b.z, c.z) < eye.z - reach) continue;
      const random = randomOf(i + 1);
      const up = (b.x - a.x) * (c.z - a.z) - (b.z - a.z) * (c.x - a.x); // twice the area in plan, negative: seen from above
      const slopeX = ((b.y - a.y) * (c.z - a.z) - (c.y - a.y) * (b.z - a.z)) / up,
        slopeZ = ((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y)) / up;
      for (let tufts = Math.floor(0.5 * Math.abs(up) * perSquare + random()); tufts > 0; --tufts) {
        let [s, t] = [random(), random()];
        const size = 0.08 + 0.16 * random() ** 2;
        if (s + t > 1) [s, t] = [1 - s, 1 - t];
        place
          .copy(a)
          .multiplyScalar(1 - s - t)
          .addScaledVector(b, s)
          .addScaledVector(c, t);
        if (place.distanceTo(eye) > reach || count === most) continue;
        const u = (1 - s - t) * uv.getX(ia) + s * uv.getX(ib) + t * uv.getX(ic),
          v = (1 - s - t) * uv.getY(ia) + s * uv.getY(ib) + t * uv.getY(ic);
        if (!this.isGrass(u, v)) continue;
        this.places.setXYZW(count, place.x, place.y, place.z, size);
        this.placesInPhoto.setXYZW(count, u, v, slopeX, slopeZ);
        ++count;
      }
    }
    return count;
  }

  dispose(): void {
    this.object.removeFromParent();
    this.object.geometry.dispose();
    this.object.material.dispose();
  }
}
