// SPDX-License-Identifier: Apache-2.0
// The sky as surfaces mirror it: one gradient for the dome, for wet-looking asphalt at grazing angles, glass, paint and water.

import {Color, type Material, Vector3, type WebGLProgramParametersWithUniforms} from 'three';

/** Linear colours of the sky and of the land below it; the direction of the sun in the scene's frame. */
export const skyUniforms = {
  zenith: {value: new Color()},
  horizon: {value: new Color()},
  land: {value: new Color()},
  toSun: {value: new Vector3(0, 0, 1)},
  sunColor: {value: new Color()},
};

/** `blur`: how far the horizon is smeared, as rough surfaces do. */
export const skyColorGlsl = `
uniform vec3 zenith, horizon, land;
vec3 skyColor(vec3 direction, float blur) {
  vec3 sky = mix(horizon, zenith, pow(max(direction.z, 0.0), 0.55));
  return mix(land, sky, smoothstep(-0.015 - blur, 0.015 + blur, direction.z));
}`;

const after = '#include <lights_fragment_maps>';

/** Changes the code of a physical material's shader: to be called in its onBeforeCompile. */
export function mirrorSky(shader: WebGLProgramParametersWithUniforms): void {
  if (!shader.fragmentShader.includes(after))
    throw new Error('three.js has changed the shader of its physical material');
  Object.assign(shader.uniforms, skyUniforms);
  shader.fragmentShader = shader.fragmentShader
    .replace('#include <common>', `#include <common>\n${skyColorGlsl}`)
    .replace(
      after,
      `${after}
    vec3 mirrored = reflect(-geometryViewDir, normal);
    mirrored = normalize(mix(mirrored, normal, material.roughness * material.roughness));
    radiance += (1.0 - 0.5 * material.roughness) * skyColor((vec4(mirrored, 0.0) * viewMatrix).xyz, 0.7 * material.roughness);
    #ifdef USE_CLEARCOAT
      clearcoatRadiance += 0.8 * skyColor((vec4(reflect(-geometryViewDir, clearcoatNormal), 0.0) * viewMatrix).xyz, 0.0);
    #endif`,
    );
}

export function withSky<T extends Material>(material: T): T {
  material.onBeforeCompile = mirrorSky;
  return material;
}
