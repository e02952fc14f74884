// SPDX-License-Identifier: Apache-2.0
// Checks of the ground near the eye.

import assert from 'node:assert/strict';

import {sceneShot, waitUntilDrawn} from './page_helpers.mjs';
import {fineContrast} from './pictures.mjs';

const beside_m = 7; // the middle of the lane: beside the road
const eye_m = 1.6;

/** Beside the road the ground has detail that the photo lacks, and the layer of materials takes it away and brings it back. */
export async function checkGround(page) {
  await page.evaluate(() => {
    window.orthodrive.setCamera('follow');
    window.orthodrive.setTime(20);
    window.orthodrive.setLayer('route', false);
  });
  await waitUntilDrawn(page);
  const [eye, target] = await page.evaluate(
    ([aside, up]) => {
      const {car, groundUnder} = window.orthodrive;
      const [cos, sin] = [Math.cos(car.heading_rad), Math.sin(car.heading_rad)];
      const at = (ahead, right, above) => {
        const [x, y] = [car.x_m + ahead * cos + right * sin, car.y_m + ahead * sin - right * cos];
        return [x, y, groundUnder(x, y, car.z_m + 3) + above];
      };
      return [at(0, aside, up), at(4, aside + 1, 0)];
    },
    [beside_m, eye_m],
  );
  await page.evaluate((view) => window.orthodrive.setView(view), {eye, target});
  const near = await sceneShot(page);
  await page.evaluate(() => window.orthodrive.setLayer('materials', false));
  const photo = await sceneShot(page);
  await page.evaluate(() => window.orthodrive.setLayer('materials', true));
  const again = await sceneShot(page);
  const [detailed, plain, restored] = [
    await fineContrast(page, near),
    await fineContrast(page, photo),
    await fineContrast(page, again),
  ];
  console.log(`ground: contrast between pixels ${detailed.toFixed(2)}, of the photo ${plain.toFixed(2)}`);
  assert.ok(detailed > 2 * plain, 'the ground near the eye shows no more than the photo');
  assert.ok(
    Math.abs(restored - detailed) < 0.02 * detailed,
    'switching the materials back does not bring the ground back',
  );
  await page.evaluate(() => {
    window.orthodrive.setLayer('route', true);
    window.orthodrive.setCamera('follow');
  });
  return near;
}
