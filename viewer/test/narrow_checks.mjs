// SPDX-License-Identifier: Apache-2.0
// Checks of the page on a telephone: 390 px wide, by touch.

import assert from 'node:assert/strict';
import {join} from 'node:path';

import {bare, waitUntilDrawn} from './page_helpers.mjs';

const telephone = {width: 390, height: 780};

/** Parts of the page that lie outside of it. */
function partsOutside(page) {
  return page.evaluate(() =>
    [...document.querySelectorAll('.card, #timeline *, #hud *, #pads *')]
      .filter((element) => {
        const box = element.getBoundingClientRect();
        return (
          box.width > 0 &&
          (box.left < -1 || box.right > window.innerWidth + 1 || box.top < -1 || box.bottom > window.innerHeight + 1)
        );
      })
      .map((element) => element.id || element.tagName),
  );
}

/** Pairs of cards of which one covers the other. */
function overlaps(page) {
  return page.evaluate(() => {
    const cards = [...document.querySelectorAll('#title, #fold, #map, #hud, #timeline, #pads .card')]
      .map((element) => [element.id || element.dataset.pedal, element.getBoundingClientRect()])
      .filter(([, box]) => box.width > 0);
    return cards.flatMap(([a, boxA], i) =>
      cards
        .slice(i + 1)
        .filter(
          ([, boxB]) =>
            boxA.left < boxB.right && boxB.left < boxA.right && boxA.top < boxB.bottom && boxB.top < boxA.bottom,
        )
        .map(([b]) => `${a} and ${b}`),
    );
  });
}

/** Everything stays on the page, and the panel opens and closes. */
export async function checkNarrow(page, siteDir) {
  await page.setViewportSize(telephone);
  await waitUntilDrawn(page);
  const isOpen = () => page.isVisible('#panel');
  assert.ok(!(await isOpen()), 'the panel covers a narrow page');
  assert.deepEqual(await overlaps(page), [], 'cards cover each other');
  await page.click('#fold');
  assert.ok(await isOpen(), 'the panel does not open');
  assert.deepEqual(await partsOutside(page), [], 'parts of the page lie outside of it');
  const link = page.locator('#link');
  await link.scrollIntoViewIfNeeded();
  assert.ok(await link.isVisible(), 'the end of the panel cannot be reached');
  await page.screenshot({path: join(siteDir, 'viewer_narrow.png')});
  await page.click('#fold');
}

/** Taps until the panel is open: a finger that a busy machine takes for a long press opens nothing. */
async function openPanel(page) {
  const taps = 10,
    patience_ms = 30_000;
  for (let tap = 1; ; ++tap) {
    await page.tap('#fold');
    try {
      return await page.waitForSelector('#panel', {state: 'visible', timeout: tap < taps ? patience_ms : undefined});
    } catch (error) {
      if (tap === taps) throw error;
      console.log(`touch: tap ${tap} has not opened the panel`);
    }
  }
}

/** Fingers: pads that are large enough drive the car, a drag turns the camera around it, and nothing covers anything. */
export async function checkTouch(context, url, siteDir) {
  const page = context.pages()[0];
  await page.setViewportSize(telephone);
  const session = await context.newCDPSession(page);
  await page.goto(`${url}?play=0&camera=orbit&t=8&${bare}`);
  await waitUntilDrawn(page);
  const touch = (type, ...points) =>
    session.send('Input.dispatchTouchEvent', {type, touchPoints: points.map(([x, y], id) => ({x, y, id}))});
  const camera = () => page.evaluate(() => window.orthodrive.cameraPosition);
  const before = await camera();
  await touch('touchStart', [200, 330]);
  for (const x of [220, 250, 290]) await touch('touchMove', [x, 330]);
  await page.waitForTimeout(300); // a finger that stops before it lifts flings nothing that a tap would have to stop
  await touch('touchEnd');
  await waitUntilDrawn(page);
  assert.ok(Math.hypot(...(await camera()).map((v, i) => v - before[i])) > 0.5, 'a finger does not turn the camera');

  await openPanel(page);
  await page.tap('#drive');
  await page.waitForFunction(() => window.orthodrive.driving);
  await page.tap('#fold');
  const pads = await page.locator('#pads .card').all();
  for (const pad of pads) {
    const {width, height} = await pad.boundingBox();
    assert.ok(width >= 44 && height >= 44, 'a pad is too small for a finger');
  }
  assert.deepEqual(await partsOutside(page), [], 'parts of the page lie outside of it');
  assert.deepEqual(await overlaps(page), [], 'cards cover each other');
  const start = await page.evaluate(() => window.orthodrive.car.speed_mps);
  const {x, y} = await page.locator('[data-pedal=up]').boundingBox();
  await touch('touchStart', [x + 20, y + 20]);
  await page.waitForFunction((speed) => window.orthodrive.car.speed_mps > speed + 1, start);
  await page.screenshot({path: join(siteDir, 'viewer_touch.png')});
  await touch('touchEnd');
}
