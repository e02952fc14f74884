// SPDX-License-Identifier: Apache-2.0
// Light and air: sky, sun with shadows, and haze in the colour of the horizon.

import {
  BackSide,
  Color,
  DataTexture,
  DirectionalLight,
  Fog,
  HemisphereLight,
  LinearFilter,
  LinearMipmapLinearFilter,
  Mesh,
  RedFormat,
  RepeatWrapping,
  type Scene,
  ShaderMaterial,
  SphereGeometry,
  Vector3,
} from 'three';

import {fractal, randomOf} from '../noise';
import {skyUniforms} from './sky_light';

/** Colours of the air at some height of the sun (degrees above the horizon), and shares of the light at noon. */
interface Air {
  elevation: number;
  zenith: Color;
  horizon: Color;
  sun: Color;
  sunShare: number;
  skyShare: number;
}
const air = (
  elevation: number,
  zenith: number,
  horizon: number,
  sun: number,
  sunShare: number,
  skyShare: number,
): Air => ({
  elevation,
  zenith: new Color(zenith),
  horizon: new Color(horizon),
  sun: new Color(sun),
  sunShare,
  skyShare,
});
const airs: Air[] = [
  // by eye, after photos of clear days
  air(-12, 0x05070f, 0x0d1322, 0x223355, 0.0, 0.05),
  air(-4, 0x1b2a4a, 0x6f6470, 0xff9a5a, 0.0, 0.2),
  air(1, 0x33588c, 0xe8b48c, 0xffa866, 0.35, 0.4),
  air(10, 0x3a70ae, 0xd9dcd8, 0xffdcb0, 0.75, 0.75),
  air(30, 0x3f78b5, 0xcfdde6, 0xfff4e2, 1.0, 1.0),
  air(90, 0x3f78b5, 0xcfdde6, 0xfff4e2, 1.0, 1.0),
];
const below = new Color(0xaab7bb);
const land = new Color(0x5d5d4e); // as paint and glass mirror it
const shadow_px = 2048;

function airAt(elevation: number): Air {
  const last = airs.findIndex((a) => a.elevation >= elevation);
  if (last <= 0) return airs[last < 0 ? airs.length - 1 : 0];
  const [a, b] = [airs[last - 1], airs[last]];
  const u = (elevation - a.elevation) / (b.elevation - a.elevation);
  const mix = (from: number, to: number) => from + u * (to - from);
  return {
    elevation,
    zenith: a.zenith.clone().lerp(b.zenith, u),
    horizon: a.horizon.clone().lerp(b.horizon, u),
    sun: a.sun.clone().lerp(b.sun, u),
    sunShare: mix(a.sunShare, b.sunShare),
    skyShare: mix(a.skyShare, b.skyShare),
  };
}

export class Sky {
  private readonly sun = new DirectionalLight();
  private readonly ambient = new HemisphereLight(0xe8f1ff, 0x8d8a80);
  private readonly fog = new Fog(0);
  private readonly dome = domeMaterial();
  private toSun = new Vector3(0, 0, 1);
  private relief = false;

  constructor(scene: Scene) {
    const dome = new Mesh(new SphereGeometry(1, 32, 24), this.dome);
    dome.renderOrder = 1; // of what is not transparent the last: only where nothing else is
    dome.frustumCulled = false;
    scene.add(dome, this.sun, this.sun.target, this.ambient);
    scene.fog = this.fog;
    this.sun.shadow.mapSize.set(shadow_px, shadow_px);
    this.sun.shadow.bias = -2e-4;
  }

  setShadows(on: boolean): void {
    this.sun.castShadow = on;
  }

  /** Towards the sun in the scene's frame. */
  setSun(toSun: Vector3): void {
    this.toSun = toSun.clone();
    this.light();
  }

  /** Light of relief maps, from the north-west whatever the hour, low and hard. */
  setRelief(relief: boolean): void {
    this.relief = relief;
    this.light();
  }

  /** Shadows are drawn within so far from what is looked at. */
  focus(target: Vector3, reach_m: number): void {
    const {camera} = this.sun.shadow;
    const direction = this.sun.position.clone().sub(this.sun.target.position).normalize();
    // The map moves by whole texels of itself, so that edges of shadows do not swim while driving.
    const texel_m = (2 * reach_m) / shadow_px;
    const snapped = new Vector3(...target.toArray().map((v) => Math.round(v / texel_m) * texel_m));
    this.sun.target.position.copy(snapped);
    this.sun.position.copy(snapped).addScaledVector(direction, 3 * reach_m);
    Object.assign(camera, {
      left: -reach_m,
      right: reach_m,
      top: reach_m,
      bottom: -reach_m,
      near: 0.1 * reach_m,
      far: 6 * reach_m,
    });
    this.sun.shadow.normalBias = 1.5 * texel_m;
    camera.updateProjectionMatrix();
  }

  setHazeRange(near_m: number, far_m: number): void {
    this.fog.near = near_m;
    this.fog.far = far_m;
  }

  /** Flat ground has brightness 1 under the light of a high sun. Lambert reflects irradiance / pi. */
  private light(): void {
    const elevation = (Math.asin(Math.max(-1, Math.min(1, this.toSun.z))) * 180) / Math.PI;
    const state = this.relief ? airAt(90) : airAt(elevation);
    const direction = this.relief ? new Vector3(-0.58, 0.58, 0.57) : this.toSun.clone();
    direction.z = Math.max(direction.z, 0.02);
    direction.normalize();
    this.sun.position.copy(this.sun.target.position).add(direction);
    this.sun.color.copy(state.sun);
    // A low sun lights the ground less; a little more than in truth, so that dusk can still be seen.
    const slant = this.relief ? 1 / direction.z : 1 / Math.max(direction.z, 0.5);
    this.sun.intensity = (this.relief ? 0.75 : 0.55 * state.sunShare) * Math.PI * slant;
    this.ambient.intensity = (this.relief ? 0.4 : 0.5 * state.skyShare) * Math.PI;
    skyUniforms.zenith.value.copy(state.zenith);
    skyUniforms.horizon.value.copy(state.horizon);
    skyUniforms.land.value.copy(land).multiplyScalar(state.skyShare);
    skyUniforms.toSun.value.copy(this.relief ? new Vector3(0, 0, -1) : this.toSun);
    skyUniforms.sunColor.value.copy(state.sun);
    this.dome.uniforms.below.value = below.clone().lerp(state.horizon, 1 - state.skyShare);
    this.dome.uniforms.cloudShare.value = this.relief ? 0 : state.skyShare;
    this.fog.color.copy(state.horizon);
  }
}

/** Of the clouds' thickness; repeats. */
function cloudNoise(): DataTexture {
  const size = 256;
  const values = fractal(size, 4, 6, randomOf(21));
  const texture = new DataTexture(
    Uint8Array.from(values, (v) => 255 * Math.min(1, Math.max(0, 0.5 + 0.8 * v))),
    size,
    size,
    RedFormat,
  );
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.magFilter = LinearFilter;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.generateMipmaps = texture.needsUpdate = true;
  return texture;
}

/** Around the camera behind everything else. The gradient follows the direction of view, not the distance. */
function domeMaterial(): ShaderMaterial {
  return new ShaderMaterial({
    side: BackSide,
    depthWrite: false,
    fog: false,
    uniforms: {...skyUniforms, below: {value: below}, noise: {value: cloudNoise()}, cloudShare: {value: 1}},
    vertexShader: `
      varying vec3 direction;
      void main() {
        direction = position;
        gl_Position = projectionMatrix * vec4(mat3(viewMatrix) * position, 1.0);
        gl_Position.z = gl_Position.w; // as far as can be
      }`,
    fragmentShader: `
      uniform vec3 zenith, horizon, below, toSun, sunColor;
      uniform sampler2D noise;
      uniform float cloudShare;
      varying vec3 direction;
      void main() {
        vec3 view = normalize(direction);
        vec3 color = view.z > 0.0 ? mix(horizon, zenith, pow(view.z, 0.55)) : mix(horizon, below, min(1.0, -view.z * 4.0));
        float off = acos(clamp(dot(view, toSun), -1.0, 1.0)); // the sun's disc and the glow around it
        color = mix(color, sunColor, 0.35 * exp(-6.0 * off) + smoothstep(0.0065, 0.0045, off));
        if (view.z > 0.02 && cloudShare > 0.0) { // fair weather: small clouds at one height, thinner towards the horizon
          vec2 place = view.xy / (view.z + 0.08);
          float thick = 0.7 * texture2D(noise, 0.045 * place).r + 0.3 * texture2D(noise, 0.21 * place + 0.4).r;
          float cover = smoothstep(0.5, 0.72, thick) * smoothstep(0.02, 0.22, view.z) * cloudShare;
          vec3 lit = mix(sunColor, vec3(1.0), 0.6), shade = mix(horizon, zenith, 0.25);
          color = mix(color, mix(lit, shade, 0.55 * smoothstep(0.58, 0.85, thick)), 0.85 * cover);
        }
        float grain = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))); // against bands (Jimenez 2014)
        gl_FragColor = vec4(color, 1.0);
        #include <colorspace_fragment>
        gl_FragColor.rgb += (grain - 0.5) / 255.0;
      }`,
  });
}
