// SPDX-License-Identifier: Apache-2.0
// What the checks of the page share.

import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {join} from 'node:path';

export function lapText(siteDir) {
  return readFileSync(join(siteDir, 'drive/lap.csv'), 'utf8').trim();
}

/** These columns of lap.csv, in the site CRS: a list a row. */
export function readLap(siteDir, names) {
  const [header, ...rows] = lapText(siteDir).split('\n');
  const columns = names.map((name) => header.split(',').indexOf(name));
  return rows.map((row) => columns.map((column) => Number(row.split(',')[column])));
}

/** lap.csv with every row changed: `change` takes and returns an object with a number a column; left out ones are left out. */
export function changedLap(siteDir, change) {
  const [header, ...rows] = lapText(siteDir).split('\n');
  const names = header.split(',');
  const changed = rows.map((row) => {
    const values = row.split(',');
    return change(Object.fromEntries(names.map((name, i) => [name, Number(values[i])])));
  });
  return [Object.keys(changed[0]).join(','), ...changed.map((row) => Object.values(row).join(','))].join('\n');
}

/** All tiles are there and at least one more picture was drawn after the last change. */
export async function waitUntilDrawn(page) {
  await page.waitForFunction(() => window.orthodrive?.ready || window.orthodrive?.failures.length > 0);
  assert.deepEqual(await page.evaluate(() => window.orthodrive.failures), [], 'tiles failed to load');
  await page.evaluate(() => {
    // the browser has asked for the picture; this waits until its graphics process has drawn it
    const gl = document.getElementById('canvas').getContext('webgl2');
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  });
}

/** Of an address: without what takes longest to draw by a processor, for checks that do not look at it. */
export const sparse = 'off=trees,buildings,shadows';
/** Without the ground as well: for checks of the page around the picture. All tiles are loaded nevertheless. */
export const bare = `${sparse},terrain,roads`;

/** Brings what `sparse` or `bare` leave out back on a page that is open, or takes it away. */
export function showAll(page, on, without = bare) {
  return page.evaluate(
    ([names, state]) => names.split(',').forEach((name) => window.orthodrive.setLayer(name, state)),
    [without.slice('off='.length), on],
  );
}

/** Hides the page's cards, which lie over the picture, or shows them again. The page's policy refuses style elements. */
export function hideCards(page, hidden = true) {
  return page.evaluate((hide) => {
    window.withoutCards ??= new CSSStyleSheet();
    const sheet = window.withoutCards;
    sheet.replaceSync(hide ? '.card, footer, #message { visibility: hidden }' : '');
    if (!document.adoptedStyleSheets.includes(sheet)) document.adoptedStyleSheets.push(sheet);
  }, hidden);
}

/** The picture without the page's cards. */
export async function sceneShot(page) {
  await waitUntilDrawn(page);
  await hideCards(page);
  const png = await page.screenshot();
  await hideCards(page, false);
  return png;
}
