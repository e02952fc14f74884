// SPDX-License-Identifier: Apache-2.0
// Hedges and trees from afar are lumps of few triangles. Here they get leaves: the rim of a lump dissolves into the leaves of
// its texture, light comes through, and the inside is dark. Trees near by have cards with leaves: they are lit likewise.

import {
  CustomBlending,
  DoubleSide,
  MeshLambertMaterial,
  OneFactor,
  type WebGLProgramParametersWithUniforms,
  ZeroFactor,
} from 'three';

const fluff = 0.15; // lumps are drawn so much wider, because their rims are full of holes

function replace(
  shader: WebGLProgramParametersWithUniforms,
  stage: 'vertexShader' | 'fragmentShader',
  from: string,
  to: string,
): void {
  if (!shader[stage].includes(from)) throw new Error('three.js has changed the shader of its Lambert material');
  shader[stage] = shader[stage].replace(from, to);
}

/** Bark is of the same mesh: it is what is not green before it is tinted. */
function addLeaves(shader: WebGLProgramParametersWithUniforms): void {
  replace(shader, 'vertexShader', '#include <common>', '#include <common>\nvarying float leafy;');
  replace(
    shader,
    'vertexShader',
    '#include <begin_vertex>',
    `#include <begin_vertex>
    leafy = step(color.r, color.g);
    transformed.xz *= 1.0 + ${fluff} * leafy;`,
  );
  replace(shader, 'fragmentShader', '#include <common>', '#include <common>\nvarying float leafy;');
  replace(
    shader,
    'fragmentShader',
    '#include <alphatest_fragment>',
    `
    if (leafy > 0.5) {
      float facing = abs(dot(normalize(vNormal), normalize(vViewPosition)));
      float clump = texture2D(map, 0.31 * vMapUv + 0.21).g / 0.6, leaf = 0.7 * clump + 0.3 * sampledDiffuseColor.g / 0.6; // 1 in the mean
      float wanted = 1.5 - 1.25 * smoothstep(0.1, 0.85, facing);
      float soft = 0.06 + 3.0 * length(fwidth(vMapUv)); // from afar the texture is smooth, and so are the edges
      diffuseColor.a = smoothstep(wanted - soft, wanted + soft, leaf);
      if (diffuseColor.a < 0.02) discard;
      float mass = texture2D(map, 0.19 * vMapUv).g / 0.6;
      diffuseColor.rgb *= mix(0.6, 1.25, smoothstep(0.7, 1.25, mass));
      diffuseColor.rgb *= mix(0.55, 1.12, smoothstep(wanted - 0.1, wanted + 0.7, leaf)); // what lies deeper is darker
    } else {
      diffuseColor.a = 1.0;
    }`,
  );
  lightThrough(shader);
}

/** Leaves let light through, and face all ways. */
function lightThrough(shader: WebGLProgramParametersWithUniforms): void {
  replace(
    shader,
    'fragmentShader',
    '#include <lights_lambert_pars_fragment>',
    `#include <lights_lambert_pars_fragment>
    void lightLeaves(const in IncidentLight light, const in vec3 position, const in vec3 n, const in vec3 view, const in vec3 coat,
                     const in LambertMaterial material, inout ReflectedLight reflectedLight) {
      float straight = dot(n, light.direction);
      float lit = leafy > 0.5 ? saturate((straight + 0.35) / 1.35) : saturate(straight);
      float through = leafy * 0.35 * pow(saturate(dot(-view, light.direction)), 3.0) * saturate(0.4 - straight);
      reflectedLight.directDiffuse += light.color * (lit + through * vec3(1.1, 1.3, 0.5)) * BRDF_Lambert(material.diffuseColor);
    }
    #undef RE_Direct
    #define RE_Direct lightLeaves`,
  );
}

// The opacity decides how many samples of a pixel are drawn, and stays out of the picture: the page would shine through.
const covered = {
  alphaToCoverage: true,
  blending: CustomBlending,
  blendSrc: OneFactor,
  blendDst: ZeroFactor,
  blendSrcAlpha: ZeroFactor,
  blendDstAlpha: OneFactor,
} as const;

export function foliageMaterial(): MeshLambertMaterial {
  const material = new MeshLambertMaterial({name: 'foliage', vertexColors: true, ...covered});
  material.onBeforeCompile = addLeaves;
  return material;
}

/** Cards show both sides; both are lit as the crown that they belong to. */
function addCards(shader: WebGLProgramParametersWithUniforms): void {
  replace(shader, 'vertexShader', '#include <common>', '#include <common>\nvarying float leafy;');
  replace(
    shader,
    'vertexShader',
    '#include <begin_vertex>',
    '#include <begin_vertex>\nleafy = step(color.r, color.g);',
  );
  replace(shader, 'fragmentShader', '#include <common>', '#include <common>\nvarying float leafy;');
  replace(
    shader,
    'fragmentShader',
    '#include <normal_fragment_begin>',
    `
    vec3 normal = normalize(vNormal);
    vec3 nonPerturbedNormal = normal;`,
  );
  lightThrough(shader);
}

/** `alphaTest` is glTF's: what has less opacity is a hole. From afar the smaller pictures mix leaves and holes. */
export function leavesMaterial(): MeshLambertMaterial {
  const material = new MeshLambertMaterial({
    name: 'leaves',
    vertexColors: true,
    side: DoubleSide,
    alphaTest: 0.5,
    ...covered,
  });
  material.onBeforeCompile = addCards;
  return material;
}
