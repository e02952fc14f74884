// SPDX-License-Identifier: Apache-2.0
// Checks of the layers.

import assert from 'node:assert/strict';
import {writeFileSync} from 'node:fs';
import {join} from 'node:path';

import {sceneShot} from './page_helpers.mjs';
import {comparePictures, meanColor} from './pictures.mjs';

/** Name, how it is not usually, how much of the picture changes at least. */
const layers = [
  ['photo', false, 0.02],
  ['terrain', false, 0.02],
  ['roads', false, 0.02],
  ['wireframe', true, 0.02],
  ['labels', true, 0.02],
  ['normals', true, 0.2],
  ['lanes', true, 0.02],
  ['map-roads', true, 0.0005],
  ['refined-roads', true, 0.0005],
  ['error-bars', true, 0.0005],
];

/** Each layer changes the picture, and switching it back brings the same picture again. */
export async function checkLayers(page, siteDir) {
  const before = await sceneShot(page);
  for (const [layer, on, least] of layers) {
    const set = (value) => page.evaluate(([name, state]) => window.orthodrive.setLayer(name, state), [layer, value]);
    await set(on);
    const picture = await sceneShot(page);
    writeFileSync(join(siteDir, `viewer_layer_${layer}.png`), picture);
    const changed = await comparePictures(page, before, picture);
    if (layer === 'normals') await checkNormals(page, picture);
    await set(!on);
    const restored = await comparePictures(page, before, await sceneShot(page));
    console.log(`layer ${layer}: ${(100 * changed).toFixed(2)} % of the pixels change`);
    assert.ok(changed > least, `the switch of ${layer} does not change the picture`);
    assert.ok(restored < 0.001, `switching ${layer} back does not bring the picture back`);
  }
}

/** The ground of the lower half is nearly level: half red, half green, all blue, whichever way one looks. */
async function checkNormals(page, picture) {
  const {red, green, blue} = await meanColor(page, picture, 0.8);
  console.log(`normals: mean colour of the ground ${[red, green, blue].map(Math.round)}`);
  assert.ok(blue > red + 50 && blue > green + 50 && Math.abs(red - green) < 25, 'the ground is not level');
}
