// SPDX-License-Identifier: Apache-2.0
// What a car is made of. What is outside mirrors the sky.

import {
  type Color,
  type ColorRepresentation,
  DoubleSide,
  MeshLambertMaterial,
  MeshPhysicalMaterial,
  MeshStandardMaterial,
} from 'three';

import {withSky} from '../sky/sky_light';

export interface CarMaterials {
  paint: MeshPhysicalMaterial;
  glass: MeshStandardMaterial;
  trim: MeshStandardMaterial; // plastic, rubber seals
  gap: MeshLambertMaterial; // between panels, in wheel housings
  cabin: MeshLambertMaterial; // dashboard and lining
  metal: MeshStandardMaterial;
  mirror: MeshStandardMaterial;
  headlamp: MeshStandardMaterial;
  rearLamp: MeshStandardMaterial;
  plate: MeshStandardMaterial;
}

const made = (color: ColorRepresentation | Color, roughness: number, metalness = 0) =>
  withSky(new MeshStandardMaterial({color, roughness, metalness}));

export function carMaterials(paint: number): CarMaterials {
  const headlamp = made(0xb9c2ca, 0.12, 0.4),
    rearLamp = made(0x7d0c0a, 0.15);
  headlamp.emissive.set(0x30343a);
  rearLamp.emissive.set(0xff1a10);
  return {
    paint: withSky(
      new MeshPhysicalMaterial({
        color: paint,
        roughness: 0.5,
        metalness: 0.15,
        clearcoat: 0.7,
        clearcoatRoughness: 0.04,
      }),
    ),
    glass: made(0x06080a, 0.04),
    trim: made(0x141517, 0.7),
    gap: new MeshLambertMaterial({color: 0x050505, side: DoubleSide}),
    cabin: new MeshLambertMaterial({color: 0x2b2c2f, side: DoubleSide}),
    metal: made(0xc3c8ce, 0.3, 0.85),
    mirror: made(0xdfe3e6, 0.03, 1),
    headlamp,
    rearLamp,
    plate: made(0xe8ebee, 0.5),
  };
}
