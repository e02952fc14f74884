// SPDX-License-Identifier: Apache-2.0
// Near the eye the photo is too coarse to be looked at: there the ground shows patterns of what lies there, in the photo's
// own colours. What lies where comes from the labels' roles and from how green the photo is.

import {
  DataArrayTexture,
  DataTexture,
  Group,
  LinearFilter,
  LinearMipmapLinearFilter,
  type Mesh,
  type MeshLambertMaterial,
  type Object3D,
  RepeatWrapping,
  RGBAFormat,
  Scene,
  Sphere,
  type Texture,
  type Vector3,
  Vector4,
} from 'three';
import {type GroundPatterns, groundKinds, groundPattern_m, groundPattern_px} from './ground_patterns';
import GroundPainter from './ground_patterns.worker?worker';
import {GroundPlants} from './ground_plants';
import {groundTintGlsl} from './ground_tint';
import {featuresOf, roleWeights} from './tile_features';

const nearest_m = 16,
  farthest_m = 50; // patterns alone up to here; from here on the photo
const clumps_m = 160; // so far the photo is a little uneven, as the ground is
const colorSize_m = 4; // of the photo's means that give patterns their colours: cars and shadows of trees go under in them

interface Ground {
  lowLod: {value: number};
  weights?: Texture; // what lies where
  photo: MeshLambertMaterial;
  asked: boolean;
  plants?: GroundPlants; // once it is known what lies where
}

/** Sides of the photo, in metres: from the mesh's places in it. */
function photoSize_m(mesh: Mesh): number {
  const position = mesh.geometry.getAttribute('position'),
    uv = mesh.geometry.getAttribute('uv');
  let [west, east] = [0, 0];
  for (let i = 0; i < position.count; ++i) {
    if (position.getX(i) < position.getX(west)) west = i;
    if (position.getX(i) > position.getX(east)) east = i;
  }
  return (position.getX(east) - position.getX(west)) / Math.max(1e-6, uv.getX(east) - uv.getX(west));
}

function isDrawn(mesh: Object3D): boolean {
  while (mesh.parent) mesh = mesh.parent;
  return mesh instanceof Scene;
}

export class GroundDetail {
  /** What stands on the ground near the eye. */
  readonly object = new Group();
  onChange: () => void = () => {};
  private readonly grounds = new Map<Mesh, Ground>();
  private readonly patterns: {value: Texture | null} = {value: null};
  private readonly means = {value: groundKinds.map(() => new Vector4(1))};
  private readonly share = {value: 1};
  private painter?: Worker;
  private asked = 0;

  constructor(private readonly anisotropy: number) {}

  private paint(): void {
    if (this.painter) return;
    this.painter = new GroundPainter();
    ++this.asked;
    this.painter.onmessage = ({data: {data, means}}: MessageEvent<GroundPatterns>) => {
      --this.asked;
      this.painter!.terminate();
      const patterns = new DataArrayTexture(data, groundPattern_px, groundPattern_px, groundKinds.length);
      patterns.wrapS = patterns.wrapT = RepeatWrapping;
      patterns.magFilter = LinearFilter;
      patterns.minFilter = LinearMipmapLinearFilter;
      patterns.generateMipmaps = true;
      patterns.anisotropy = Math.min(4, this.anisotropy);
      patterns.needsUpdate = true;
      this.patterns.value = patterns;
      means.forEach((mean, i) => this.means.value[i].setX(mean));
      this.onChange();
    };
  }

  /** Off: the photo alone. */
  set shown(on: boolean) {
    this.object.visible = on;
    this.share.value = on ? 1 : 0;
  }

  /** Pictures are on their way. */
  get pending(): boolean {
    return this.asked > 0;
  }

  /** `material` shows the photo on `mesh`, a tile's terrain. */
  adopt(mesh: Mesh, material: MeshLambertMaterial): void {
    const image = material.map?.image as {width: number} | undefined;
    if (!image) return;
    const ground: Ground = {
      lowLod: {value: Math.max(0, Math.log2((colorSize_m * image.width) / photoSize_m(mesh)))},
      photo: material,
      asked: false,
    };
    this.grounds.set(mesh, ground);
  }

  /** Changes the code of a ground's material. Ground that is far from the eye keeps the short one. */
  private detail(ground: Ground): void {
    ground.photo.onBeforeCompile = (shader) => {
      Object.assign(shader.uniforms, {
        groundShare: this.share,
        groundPatterns: this.patterns,
        groundMeans: this.means,
        groundLowLod: ground.lowLod,
        groundWeights: {value: ground.weights},
      });
      const replace = (stage: 'vertexShader' | 'fragmentShader', from: string, to: string) => {
        if (!shader[stage].includes(from)) throw new Error('three.js has changed the shader of its Lambert material');
        shader[stage] = shader[stage].replace(from, to);
      };
      replace('vertexShader', '#include <common>', '#include <common>\nvarying vec2 groundPlace;');
      replace(
        'vertexShader',
        '#include <begin_vertex>',
        '#include <begin_vertex>\ngroundPlace = vec2(position.x, -position.z);',
      );
      replace('fragmentShader', '#include <common>', `#include <common>\n${declarations}`);
      replace('fragmentShader', '#include <map_fragment>', colorCode);
      replace('fragmentShader', '#include <normal_fragment_maps>', normalCode);
    };
    ground.photo.needsUpdate = true;
  }

  /** Asks for what the ground near the eye needs. */
  update(eye: Vector3): void {
    if (!this.object.visible) return; // nobody would see it
    for (const [mesh, ground] of this.grounds) {
      const drawn = isDrawn(mesh); // tiles that are finer or coarser than wanted are held, too
      if (ground.plants) ground.plants.object.visible = drawn;
      if (!drawn) continue;
      if (ground.plants?.update(eye)) this.onChange();
      if (ground.asked) continue;
      mesh.geometry.boundingSphere ?? mesh.geometry.computeBoundingSphere();
      const sphere = new Sphere().copy(mesh.geometry.boundingSphere!).applyMatrix4(mesh.matrixWorld);
      if (sphere.distanceToPoint(eye) > 2 * farthest_m) continue;
      ground.asked = true;
      const weights = roleWeights(featuresOf(mesh));
      if (!weights) continue;
      this.paint();
      ++this.asked;
      void weights.then(({data, width, height}) => {
        --this.asked;
        if (!this.grounds.has(mesh)) return;
        const texture = new DataTexture(data, width, height, RGBAFormat);
        texture.magFilter = texture.minFilter = LinearFilter;
        texture.needsUpdate = true;
        ground.weights = texture;
        this.detail(ground);
        const isGrass = (u: number, v: number) => {
          const at = 4 * (Math.floor(v * height) * width + Math.floor(u * width));
          return data[at] + data[at + 1] > 200; // open ground or plants; how green it is the graphics processor sees
        };
        ground.plants = new GroundPlants(mesh, isGrass, ground.photo, ground.lowLod);
        this.object.add(ground.plants.object);
        this.onChange();
      });
    }
  }

  release(mesh: Mesh): void {
    const ground = this.grounds.get(mesh);
    ground?.weights?.dispose();
    ground?.plants?.dispose();
    this.grounds.delete(mesh);
  }
}

const declarations = `
varying vec2 groundPlace;
uniform mediump sampler2DArray groundPatterns;
uniform vec4 groundMeans[${groundKinds.length}];
uniform float groundLowLod, groundShare;
uniform sampler2D groundWeights;
vec3 groundTilt;
${groundTintGlsl}`;

// The second set of the pattern is three times as large, smoothed and turned by the angle of a 3-4-5 triangle, so that tiles of 480 m
// are whole multiples of it, too, and nothing seems to repeat.
const colorCode = `
#include <map_fragment>
groundTilt = vec3(0.0);
#ifdef USE_MAP
{
  vec2 fine = groundPlace / ${groundPattern_m.toFixed(1)};
  vec2 coarse = vec2(0.6 * fine.x - 0.8 * fine.y, 0.8 * fine.x + 0.6 * fine.y) / 3.0;
  vec2 fineX = dFdx(fine), fineY = dFdy(fine);
  float coarseLod = max(4.0, log2(${groundPattern_px.toFixed(1)} * max(length(fineX), length(fineY)))); // clumps, no blades
  float near = 1.0 - smoothstep(${nearest_m.toFixed(1)}, ${farthest_m.toFixed(1)}, length(vViewPosition));
  float clumps = 1.0 - smoothstep(0.5 * ${clumps_m.toFixed(1)}, ${clumps_m.toFixed(1)}, length(vViewPosition));
  vec4 weights = clumps * groundShare > 0.0 ? texture(groundWeights, vMapUv) : vec4(0.0); // open ground, plants, paving, rails
  if (dot(weights, vec4(1.0)) > 0.02) {
    float green;
    vec3 low = groundTint(map, vMapUv, groundLowLod, green);
    float shares[${groundKinds.length}] = float[](weights.r * green, weights.r * (1.0 - green), weights.g, weights.b, weights.a);
    vec3 sum = vec3(0.0);
    float uneven = 0.0;
    for (int kind = 0; kind < ${groundKinds.length}; ++kind) {
      if (shares[kind] < 0.03) continue;
      float clump = mix(1.0, textureLod(groundPatterns, vec3(coarse, kind), coarseLod).r / groundMeans[kind].x, 1.2);
      uneven += shares[kind] * clump;
      if (near <= 0.0) continue;
      vec4 pattern = textureGrad(groundPatterns, vec3(fine, kind), fineX, fineY);
      vec3 tint = kind == 0 ? grassTint(low) : kind == 2 ? mix(low, brightness(low) * vec3(1.2, 1.0, 0.7), 0.5) : low; // no crowns on the ground
      sum += shares[kind] * clump * (pattern.r / groundMeans[kind].x) * tint * (1.0 + 2.0 * (pattern.g - 0.5) * vec3(1.0, 0.0, -1.0));
      groundTilt.xy += shares[kind] * near * (2.0 * pattern.ba - 1.0);
    }
    float known = dot(weights, vec4(1.0));
    vec3 far = diffuseColor.rgb * mix(1.0, uneven / known, clumps);
    diffuseColor.rgb = mix(diffuseColor.rgb, mix(far, sum / known, near), min(1.0, known));
  }
}
#endif`;

const normalCode = `
#include <normal_fragment_maps>
normal = normalize(normal + (viewMatrix * vec4(groundTilt, 0.0)).xyz);`;
