// SPDX-License-Identifier: Apache-2.0
// Opens the tiles of a built site in CesiumJS, in Debian's Chromium: another reader of 3D Tiles sees the same site, where it is.
// node viewer/test/cesium_test.mjs SITE_DIR TOOL
// Leaves cesium_above.png and cesium_near.png in SITE_DIR. Exit code 0 when everything is as it should be.

import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {copyFileSync, cpSync, mkdtempSync, readFileSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';

import {pictureStatistics} from './pictures.mjs';
import {openBrowser, serveSite} from './serve_and_open.mjs';

const [siteDir, tool] = process.argv.slice(2);
if (!tool) {
  console.error('usage: node cesium_test.mjs SITE_DIR TOOL');
  process.exit(2);
}

/** Middle of what the labels show, in degrees, as GDAL has it. */
function middleOfSite() {
  const {wgs84Extent} = JSON.parse(execFileSync('gdalinfo', ['-json', join(siteDir, 'labels.tif')]));
  const corners = wgs84Extent.coordinates[0].slice(0, 4);
  return [0, 1].map((k) => corners.reduce((sum, corner) => sum + corner[k], 0) / 4);
}

/** Metres between two places of longitude and latitude, near each other. */
function apart_m([lonA, latA], [lonB, latB]) {
  const metresPerDegree = (Math.PI / 180) * 6378137;
  return Math.hypot(
    (lonA - lonB) * metresPerDegree * Math.cos((latA * Math.PI) / 180),
    (latA - latB) * metresPerDegree,
  );
}

/** Longitude, latitude and height of places on the driven lap. */
function lapPlaces(count) {
  const points = [
    ...readFileSync(join(siteDir, 'drive/lap.gpx'), 'utf8').matchAll(
      /<trkpt lat="([^"]+)" lon="([^"]+)"[^>]*>\s*<ele>([^<]+)/g,
    ),
  ];
  assert.ok(points.length > 10 * count, 'lap.gpx has hardly any points');
  return Array.from({length: count}, (_, i) => points[Math.floor((i * points.length) / count)]).map(
    ([, lat, lon, ele]) => [lon, lat, ele].map(Number),
  );
}

async function checkPicture(page, file) {
  await page.screenshot({path: join(siteDir, file)});
  const {width, height} = page.viewportSize();
  const middle = await page.screenshot({clip: {x: width / 4, y: height / 4, width: width / 2, height: height / 2}});
  const statistics = await pictureStatistics(page, middle);
  console.log(`${file}:`, statistics);
  assert.ok(statistics.deviation > 15, `${file} has hardly any contrast`);
  assert.ok(statistics.colors > 200, `${file} has hardly any colours`);
}

const inPage = (page, name, ...values) =>
  page.evaluate(([call, all]) => window.orthodrive[call](...all), [name, values]);
const stateOf = (page) => page.evaluate(() => window.orthodrive.state);

/** All of the site from above: it is where it should be. */
async function checkAbove(page, url) {
  await page.goto(url);
  await page.waitForFunction(() => window.orthodrive);
  await inPage(page, 'open');
  const {loaded, failures, lonLatDegHeight_m, radius_m} = await stateOf(page);
  const away_m = apart_m(lonLatDegHeight_m, middleOfSite());
  console.log(
    `${loaded} tiles, middle ${lonLatDegHeight_m.map((v) => v.toFixed(6))}, ${away_m.toFixed(2)} m from the middle of the labels, radius ${radius_m.toFixed(0)} m`,
  );
  assert.deepEqual(failures, [], 'tiles failed');
  assert.ok(loaded > 0, 'no tile was loaded');
  assert.ok(away_m < 5, `the site lies ${away_m.toFixed(1)} m from where it should`);
  await checkPicture(page, 'cesium_above.png');
}

/** The driven lap lies on the road that CesiumJS shows. GPX counts heights from the sea, CesiumJS from the ellipsoid. */
async function checkLap(page) {
  const places = lapPlaces(12);
  const heights = await inPage(page, 'heightsAt', places);
  assert.ok(heights.every(Number.isFinite), `no surface under the lap: ${heights}`);
  const geoid = heights.map((height, i) => height - places[i][2]);
  const [lowest, highest] = [Math.min(...geoid), Math.max(...geoid)];
  console.log(`the ellipsoid lies ${lowest.toFixed(2)} to ${highest.toFixed(2)} m below the lap's zero`);
  assert.ok(highest - lowest < 0.3, 'the lap does not lie on the road');
  const [first, second] = places;
  const part = (share) => [0, 1, 2].map((k) => first[k] + share * (second[k] - first[k]));
  const bearing = 60 / apart_m(first, second);
  await inPage(page, 'look', [...part(0).slice(0, 2), heights[0] + 6], [...part(bearing).slice(0, 2), heights[0]]);
  await checkPicture(page, 'cesium_near.png');
}

function firstContent(tile) {
  return tile.content ?? tile.children.map(firstContent).find(Boolean);
}

/** The test can fail: a broken tile is told. */
async function checkBrokenTile(page) {
  const tileset = JSON.parse(readFileSync(join(siteDir, 'scene/tileset.json'), 'utf8'));
  await page.route(`**/${firstContent(tileset.root).uri}`, (route) => route.fulfill({body: 'not a tile'}));
  await inPage(page, 'open');
  const {failures} = await stateOf(page);
  console.log('broken tile:', failures);
  assert.ok(failures.length > 0, 'CesiumJS says nothing of a broken tile');
}

const [scratch, profile] = ['page', 'profile'].map((name) => mkdtempSync(join(tmpdir(), `orthodrive-cesium-${name}-`)));
copyFileSync(new URL('cesium_page.html', import.meta.url), join(scratch, 'index.html'));
cpSync(new URL('../node_modules/cesium/Build/Cesium', import.meta.url), join(scratch, 'cesium'), {recursive: true}); // no link: `view` follows none out
const server = await serveSite(tool, siteDir, {ORTHODRIVE_VIEWER_DIR: scratch});
let context;
try {
  context = await openBrowser(profile, {pixels: 0.5, plain: true, bypassCSP: true}); // the policy is for our page, not for this one
  const problems = [];
  await context.route(
    (url) => ['http:', 'https:'].includes(url.protocol) && !url.href.startsWith(server.url),
    (route) => {
      problems.push(`asked for ${route.request().url()}`);
      return route.abort();
    },
  );
  const page = context.pages()[0] ?? (await context.newPage());
  page.on('console', (message) => message.type() === 'error' && problems.push(message.text()));
  page.on('pageerror', (error) => problems.push(error.message));
  page.on(
    'response',
    (response) => response.status() >= 400 && problems.push(`${response.status()} ${response.url()}`),
  );
  await checkAbove(page, server.url);
  await checkLap(page);
  assert.deepEqual((await stateOf(page)).failures, [], 'tiles failed');
  assert.deepEqual(problems, [], 'the page reports errors');
  await checkBrokenTile(page);
} finally {
  await context?.close();
  assert.equal(await server.stop(), 0, 'orthodrive view does not end well on Ctrl-C');
  for (const folder of [scratch, profile]) rmSync(folder, {recursive: true, force: true, maxRetries: 5});
}
console.log('CesiumJS shows the site');
