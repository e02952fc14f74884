// SPDX-License-Identifier: Apache-2.0
// Opens a built site in a real browser (Debian's Chromium, software rendering) and checks what a person would look at.
// node viewer/test/browser_test.mjs SITE_DIR TOOL [first|rest]     first: the first pictures alone; rest: what comes after them
// Leaves viewer_*.png in SITE_DIR: of the cameras, the layers, a ghost, a telephone. Exit code 0 when everything is as it should be.

import assert from 'node:assert/strict';
import {mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';

import {checkDashboard, checkDriving, checkGhost, checkGhostPicture} from './drive_checks.mjs';
import {checkGround} from './ground_checks.mjs';
import {checkHostileTexts} from './hostile_checks.mjs';
import {checkLayers} from './layer_checks.mjs';
import {checkNarrow, checkTouch} from './narrow_checks.mjs';
import {bare, readLap, sceneShot, showAll, sparse, waitUntilDrawn} from './page_helpers.mjs';
import {comparePictures, pictureStatistics} from './pictures.mjs';
import {openBrowser, serveSite} from './serve_and_open.mjs';

const [siteDir, tool, part] = process.argv.slice(2);
if (!tool || (part && part !== 'first' && part !== 'rest')) {
  console.error('usage: node browser_test.mjs SITE_DIR TOOL [first|rest]');
  process.exit(2);
}

/** Runs a check and says what it took. */
async function timed(check, ...words) {
  const begun = performance.now();
  const result = await check(...words);
  console.log(`${check.name}: ${((performance.now() - begun) / 1000).toFixed(1)} s`);
  return result;
}

/** The first picture shows tiles wherever the site is seen, from where the address says; the page's controls come after it. Ends over the site. */
async function checkFirstPicture(context, page, url) {
  const [{width, height}, session] = [page.viewportSize(), await context.newCDPSession(page)];
  await page.addInitScript(() => {
    const look = () => {
      const {orthodrive} = window;
      const panel = document.getElementById('panel');
      if (!orthodrive || orthodrive.frame === 0)
        window.earlyPanel ||= panel !== null && panel.getBoundingClientRect().width > 0;
      else window.first ??= {covered: orthodrive.covered, mode: orthodrive.mode, tiles: orthodrive.tilesVisible};
      if (!window.first) requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
  });
  for (const [camera, pixels, address] of [
    ['driver', 0.5, '&camera=driver&t=8'], // the road near the eye takes long to draw
    ['fly', 1, ''],
  ]) {
    await session.send('Emulation.setDeviceMetricsOverride', {width, height, deviceScaleFactor: pixels, mobile: false});
    await page.goto(`${url}?play=0${address}`);
    await waitUntilDrawn(page);
    const {first, earlyPanel} = await page.evaluate(() => ({first: window.first, earlyPanel: window.earlyPanel}));
    assert.deepEqual(
      [first.covered, first.mode],
      [true, camera],
      `the first picture of the camera ${camera} has gaps, or another camera`,
    );
    assert.ok(first.tiles > 0, 'the first picture shows no tiles');
    assert.ok(!earlyPanel, 'the panel comes before the first picture');
    assert.ok((await page.isVisible('#panel')) && (await page.isVisible('#map')), 'the page has no controls');
  }
}

async function checkFlyCamera(page) {
  await waitUntilDrawn(page);
  const tilesVisible = await page.evaluate(() => window.orthodrive.tilesVisible);
  assert.ok(tilesVisible > 0, 'no tile is visible from the start camera');
  writeFileSync(join(siteDir, 'viewer_fly.png'), await page.screenshot());
  const statistics = await pictureStatistics(page, await sceneShot(page));
  console.log(`fly: ${tilesVisible} tiles visible,`, statistics);
  assert.ok(statistics.deviation > 15, 'the picture has hardly any contrast');
  assert.ok(statistics.colors > 200, 'the picture has hardly any colours');
}

/** What is seen is what is driven: the car is where lap.csv says, and on a surface there. */
async function checkFollowCamera(page) {
  const tileset = JSON.parse(readFileSync(join(siteDir, 'scene/tileset.json'), 'utf8'));
  const {origin} = tileset.asset.extras.orthodrive;
  const lap = readLap(siteDir, ['t_s', 'x_m', 'y_m', 'z_m']);
  await page.evaluate(() => window.orthodrive.setCamera('follow'));
  let worstGap_m = 0;
  const cameras = [];
  for (const share of [0.05, 0.3, 0.55, 0.8]) {
    const [t, ...position] = lap[Math.floor(share * lap.length)];
    await page.evaluate((t_s) => window.orthodrive.setTime(t_s), t - lap[0][0]);
    await waitUntilDrawn(page);
    const {car, camera, ground_m} = await page.evaluate(() => {
      const {car, cameraPosition, groundUnder} = window.orthodrive;
      return {car, camera: cameraPosition, ground_m: groundUnder(car.x_m, car.y_m, car.z_m)};
    });
    [car.x_m, car.y_m, car.z_m].forEach((value, i) =>
      assert.ok(Math.abs(value - (position[i] - origin[i])) < 0.01, `the car is not where lap.csv has it at ${t} s`),
    );
    const distance = Math.hypot(camera[0] - car.x_m, camera[1] - car.y_m, camera[2] - car.z_m);
    assert.ok(distance > 3 && distance < 15, `the following camera is ${distance.toFixed(1)} m from the car`);
    assert.ok(ground_m !== undefined, `no surface under the car at ${t} s`);
    worstGap_m = Math.max(worstGap_m, Math.abs(ground_m - car.z_m));
    cameras.push(camera);
  }
  console.log(`follow: largest gap between the car and the surface under it ${worstGap_m.toFixed(3)} m`);
  assert.ok(worstGap_m < 0.25, 'the car floats above or sinks into the surface');
  assert.ok(Math.hypot(cameras[0][0] - cameras[1][0], cameras[0][1] - cameras[1][1]) > 1, 'the camera does not follow');
}

async function checkPlaying(page) {
  const before = await page.evaluate(() => ({car: window.orthodrive.car, camera: window.orthodrive.cameraPosition}));
  await page.click('#play');
  await page.waitForFunction((s_m) => Math.abs(window.orthodrive.car.s_m - s_m) > 3, before.car.s_m);
  const camera = await page.evaluate(() => window.orthodrive.cameraPosition);
  assert.ok(
    Math.hypot(camera[0] - before.camera[0], camera[1] - before.camera[1]) > 1,
    'the camera stays behind while playing',
  );
  await page.click('#play');
}

/** Every camera shows something, from where its name says. */
async function checkCameras(page) {
  for (const [mode, nearest_m, farthest_m] of [
    ['follow', 3, 15],
    ['orbit', 3, 200],
    ['driver', 0.5, 2],
    ['top', 100, 1e5],
  ]) {
    await page.evaluate((name) => window.orthodrive.setCamera(name), mode);
    const statistics = await pictureStatistics(page, await sceneShot(page));
    const {car, camera} = await page.evaluate(() => ({
      car: window.orthodrive.car,
      camera: window.orthodrive.cameraPosition,
    }));
    const distance_m = Math.hypot(camera[0] - car.x_m, camera[1] - car.y_m, camera[2] - car.z_m);
    console.log(`${mode}: ${distance_m.toFixed(2)} m from the car,`, statistics);
    assert.ok(
      distance_m > nearest_m && distance_m < farthest_m,
      `the camera ${mode} is ${distance_m.toFixed(1)} m from the car`,
    );
    assert.ok(statistics.deviation > 10 && statistics.colors > 200, `the camera ${mode} shows hardly anything`);
    writeFileSync(join(siteDir, `viewer_${mode}.png`), await page.screenshot());
  }
  await page.evaluate(() => window.orthodrive.setCamera('follow'));
}

/** The sun goes from east to west, and twice the obliquity higher in June than in December; its shadows are seen. */
async function checkSun(page) {
  const sunsAt = (date, ...hours) =>
    page.evaluate(
      ([day, clocks]) =>
        clocks.map((clock) => {
          window.orthodrive.setDay(day, clock);
          return window.orthodrive.sun;
        }),
      [date, hours],
    );
  const sunAt = async (date, hour) => (await sunsAt(date, hour))[0];
  const aroundNoon = Array.from({length: 41}, (_, i) => 10 + 0.1 * i);
  const highest = async (date) => {
    const z = Math.max(...(await sunsAt(date, ...aroundNoon)).map((sun) => sun[2]));
    return (Math.asin(z) * 180) / Math.PI;
  };
  const difference = (await highest('2026-06-21')) - (await highest('2026-12-21'));
  assert.ok(
    Math.abs(difference - 2 * 23.436) < 0.05,
    `the sun is ${difference.toFixed(2)} degrees higher in June than in December`,
  );
  assert.ok((await sunAt('2026-06-21', 8))[0] > 0.3, 'the sun is not in the east in the morning');
  assert.ok((await sunAt('2026-12-21', 0))[2] < 0, 'the sun shines at midnight in winter');
  assert.ok((await sunAt('2026-06-21', 17))[0] < -0.3, 'the sun is not in the west in the afternoon');
  const lit = await sceneShot(page);
  await page.evaluate(() => window.orthodrive.setLayer('shadows', false));
  const changed = await comparePictures(page, lit, await sceneShot(page));
  console.log(`shadows: ${(100 * changed).toFixed(2)} % of the pixels change`);
  assert.ok(changed > 0.001, 'there are no shadows');
  await page.evaluate(() => window.orthodrive.setLayer('shadows', true));
}

/** The address of a view shows the same view again. */
async function checkLink(page) {
  await page.evaluate(() => {
    window.orthodrive.setDay('2026-10-01', 9.25);
    window.orthodrive.setLayer('buildings', false);
    window.orthodrive.setLayer('lanes', true);
    const {x_m, y_m, z_m} = window.orthodrive.car;
    window.orthodrive.setView({eye: [x_m - 120, y_m - 200, z_m + 120], target: [x_m, y_m, z_m]}); // a link has centimetres
  });
  const before = await sceneShot(page);
  await page.goto(await page.evaluate(() => window.orthodrive.link));
  const changed = await comparePictures(page, before, await sceneShot(page));
  assert.ok(changed < 0.001, `${(100 * changed).toFixed(1)} % of the pixels differ under the same link`);
}

/** A click on the road ahead tells what road it is, and of what way of the map. */
async function checkClick(page) {
  await page.evaluate(() => {
    window.orthodrive.setCamera('driver');
    window.orthodrive.setLayer('route', false);
  });
  await waitUntilDrawn(page);
  const road = await page.evaluate(() => window.orthodrive.describe(0, -0.15));
  console.log('click:', road);
  assert.equal(road.kind, 'road');
  assert.match(road.id, /^[0-9]+$/);
  assert.ok(road.class && road.role, 'the road has no class of the photo');
  const {width, height} = page.viewportSize();
  await page.mouse.click(width / 2, (height * 1.15) / 2);
  await page.waitForFunction(() => document.getElementById('message').textContent.includes('road'));
  await page.evaluate(() => window.orthodrive.setLayer('route', true));
}

/** A tile that cannot be had: its parent is shown in its place, and the page says so. */
async function checkBrokenTile(context, url) {
  const tileset = JSON.parse(readFileSync(join(siteDir, 'scene/tileset.json'), 'utf8'));
  const withParent = [];
  const walk = (tile, parent) => {
    if (parent?.content && tile.content && !tile.children) withParent.push(tile.content.uri);
    for (const child of tile.children ?? []) walk(child, tile);
  };
  walk(tileset.root, undefined);
  assert.ok(withParent.length > 0, 'the site has no coarser tiles');
  for (const breakTile of [
    (route) => route.fulfill({status: 404, body: ''}),
    (route) => route.fulfill({body: 'not a tile'}),
  ]) {
    const page = await context.newPage();
    await page.route(`**/${withParent[0]}`, breakTile);
    const {origin} = findTile(tileset.root, withParent[0]).extras;
    const near = [origin[0] + 1, origin[1] - 60, origin[2] + 60]; // so near that the finest level is asked for
    await page.goto(`${url}?play=0&camera=fly&${bare}&eye=${near.join(',')}&target=${origin.join(',')}`);
    await page.waitForFunction(() => window.orthodrive?.failures.length > 0 && window.orthodrive.ready);
    const [failure] = await page.evaluate(() => window.orthodrive.failures);
    console.log('broken tile:', failure);
    assert.match(failure, /a coarser one is shown in its place/);
    assert.match(await page.textContent('#message'), /coarser/);
    assert.ok(
      (await page.evaluate(([x, y, z]) => window.orthodrive.groundUnder(x, y, z + 500), origin)) !== undefined,
      'there is a hole',
    );
    await page.close();
  }
}

function findTile(tile, uri) {
  if (tile.content?.uri === uri) return tile;
  for (const child of tile.children ?? []) {
    const found = findTile(child, uri);
    if (found) return found;
  }
  return undefined;
}

/** Without WebGL the page says so. */
async function checkNoWebGl(context, url) {
  const page = await context.newPage();
  await page.addInitScript(() => (HTMLCanvasElement.prototype.getContext = () => null));
  await page.goto(url);
  await page.waitForSelector('#message.error:not([hidden])');
  assert.match(await page.textContent('#message'), /WebGL/);
  await page.close();
}

/** `page` shows the lap from behind the car. What a check does not look at is not drawn meanwhile: time goes with it. */
async function checkWhatComesAfter(context, page, url) {
  await timed(checkFollowCamera, page);
  await timed(checkLayers, page, siteDir);
  writeFileSync(join(siteDir, 'viewer_ground.png'), await timed(checkGround, page));
  await showAll(page, false);
  await timed(checkPlaying, page);
  await timed(checkDriving, page, siteDir);
  await timed(checkDashboard, context, page, url, siteDir);
  await timed(checkGhost, context, url, siteDir);
  await showAll(page, true);
  await timed(checkCameras, page);
  await timed(checkSun, page);
  await showAll(page, false, sparse);
  await timed(checkGhostPicture, page, siteDir);
  await timed(checkClick, page);
  await timed(checkLink, page);
  await showAll(page, false);
  await timed(checkNarrow, page, siteDir);
}

/** Pages that report errors, as they should. */
async function checkWhatGoesWrong(context, url) {
  await timed(checkHostileTexts, context, url, siteDir);
  await timed(checkBrokenTile, context, url);
  await timed(checkNoWebGl, context, url);
}

/** Runs checks in a browser of their own; `options` are those of openBrowser(). */
async function inBrowser(options, checks) {
  const profile = mkdtempSync(join(tmpdir(), 'orthodrive-browser-'));
  const context = await openBrowser(profile, options);
  try {
    await checks(context);
  } finally {
    await context.close();
    rmSync(profile, {recursive: true, force: true, maxRetries: 5});
  }
}

async function checkWithMouse(context, url) {
  const page = context.pages()[0] ?? (await context.newPage());
  const problems = [];
  page.on('console', (message) => message.type() === 'error' && problems.push(message.text()));
  page.on('pageerror', (error) => problems.push(error.message));
  page.on(
    'response',
    (response) => response.status() >= 400 && problems.push(`${response.status()} ${response.url()}`),
  );
  if (part !== 'rest') {
    await timed(checkFirstPicture, context, page, url);
    await timed(checkFlyCamera, page);
  }
  if (part !== 'first') {
    await page.goto(`${url}?play=0&camera=follow&${sparse}`);
    await waitUntilDrawn(page);
    await checkWhatComesAfter(context, page, url);
  }
  assert.deepEqual(problems, [], 'the page reports errors');
  if (part !== 'first') await checkWhatGoesWrong(context, url);
}

const server = await serveSite(tool, siteDir);
try {
  const plain = part === 'rest';
  const pixels = plain ? 0.5 : 1; // time goes with the pixels
  await inBrowser({pixels, plain}, (context) => checkWithMouse(context, server.url));
  if (part !== 'first')
    await inBrowser({pixels, plain, touch: true}, (context) => timed(checkTouch, context, server.url, siteDir));
} finally {
  assert.equal(await server.stop(), 0, 'orthodrive view does not end well on Ctrl-C');
}
console.log('the viewer works');
