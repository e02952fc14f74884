// SPDX-License-Identifier: Apache-2.0
import {CanvasTexture, SRGBColorSpace} from 'three';

/** A round picture of 64 x 64 px: CSS colours at shares of the radius. */
export function radialTexture(stops: [number, string][]): CanvasTexture {
  const size = 64;
  const canvas = document.createElement('canvas');
  canvas.width = canvas.height = size;
  const context = canvas.getContext('2d')!;
  const gradient = context.createRadialGradient(size / 2, size / 2, 0, size / 2, size / 2, size / 2);
  for (const [offset, color] of stops) gradient.addColorStop(offset, color);
  context.fillStyle = gradient;
  context.fillRect(0, 0, size, size);
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  return texture;
}
