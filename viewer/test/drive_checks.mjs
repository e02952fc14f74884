// SPDX-License-Identifier: Apache-2.0
// Checks of what the page shows of drives: one's own, the dashboard, a second lap as a ghost.

import assert from 'node:assert/strict';
import {mkdtempSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';

import {bare, changedLap, readLap, sceneShot, waitUntilDrawn} from './page_helpers.mjs';
import {comparePictures} from './pictures.mjs';

/** Where the lap turns least in the next seconds: a car whose wheel nobody holds stays on the road there. */
function startOfStraight(siteDir) {
  const lap = readLap(siteDir, ['t_s', 'heading_rad']),
    ahead_s = 4;
  const turn = (from) => {
    const rows = lap.filter(([t_s]) => t_s >= from && t_s <= from + ahead_s);
    return Math.max(...rows.map(([, heading]) => Math.abs(Math.sin(heading - rows[0][1]))));
  };
  const starts = [];
  for (let t_s = lap[0][0] + 5; t_s + ahead_s < lap.at(-1)[0]; t_s += 0.5) starts.push(t_s);
  return starts.reduce((best, t_s) => (turn(t_s) < turn(best) ? t_s : best)) - lap[0][0];
}

/** Somebody takes over the car: it drives off on the throttle, turns with the wheel, off the road too, and stops on what is seen. */
export async function checkDriving(page, siteDir) {
  await page.evaluate((t_s) => {
    window.orthodrive.setPlaying(false);
    window.orthodrive.setCamera('follow');
    window.orthodrive.setTime(t_s);
  }, startOfStraight(siteDir));
  const start = await page.evaluate(() => window.orthodrive.car);
  await page.click('#drive');
  await page.waitForFunction(() => window.orthodrive.driving);
  const hold = async (key, until, argument) => {
    await page.keyboard.down(key);
    await page.waitForFunction(until, argument, {polling: 20});
    await page.keyboard.up(key);
  };
  await hold('ArrowUp', (speed) => window.orthodrive.car.speed_mps > speed + 3, start.speed_mps);
  const fast = await page.evaluate(() => ({...window.orthodrive.car, wheels: window.orthodrive.wheelsOnRoad}));
  assert.ok(Math.hypot(fast.x_m - start.x_m, fast.y_m - start.y_m) > 2, 'the car stays where it was');
  assert.equal(fast.wheels, 4, 'the car is not on the road');
  const {ghost, gap_s} = await page.evaluate(() => ({ghost: window.orthodrive.ghost, gap_s: window.orthodrive.gap_s}));
  assert.ok(ghost.s_m > start.s_m, 'the simulated lap does not go on as a ghost');
  assert.ok(Math.abs(gap_s) < 5, `the gap to the simulated lap is ${gap_s} s`);
  await hold('ArrowLeft', (heading) => Math.sin(window.orthodrive.car.heading_rad - heading) > 0.03, fast.heading_rad);
  await hold('ArrowDown', () => window.orthodrive.car.speed_mps < 0.3);
  await waitUntilDrawn(page); // coarser tiles lie elsewhere
  const {car, ground_m} = await page.evaluate(() => {
    const {car, groundUnder} = window.orthodrive;
    return {car, ground_m: groundUnder(car.x_m, car.y_m, car.z_m)};
  });
  console.log(
    `driving: ${(fast.speed_mps * 3.6).toFixed(0)} km/h reached, ${Math.abs(car.z_m - ground_m).toFixed(3)} m over the surface when it stopped`,
  );
  assert.ok(Math.abs(car.z_m - ground_m) < 0.25, 'the car floats above or sinks into the surface');
  await page.click('#drive');
  await page.waitForFunction(() => !window.orthodrive.driving);
  await page.waitForFunction(() => window.orthodrive.ghost === undefined);
}

const wheels = ['load_fl_n', 'load_fr_n', 'load_rl_n', 'load_rr_n'];
const dashboardParts = ['throttle', 'brake', 'gear', 'revs', 'g-circle', 'loads'];

/** What the dashboard shows of each part: a share, a text, or null where it is hidden. */
function readDashboard(page) {
  return page.evaluate(
    (ids) =>
      Object.fromEntries(
        ids.map((id) => {
          const element = document.getElementById(id);
          const shown = element.getBoundingClientRect().width > 0;
          const value =
            element.style.getPropertyValue('--share') ||
            element.textContent.trim() ||
            (['g-circle', 'loads'].includes(id) ? 'shown' : null);
          return [id, shown ? value : null];
        }),
      ),
    [...dashboardParts, ...wheels],
  );
}

/** The dashboard shows what the lap has, and nothing of what it does not have. */
export async function checkDashboard(context, page, url, siteDir) {
  const names = ['t_s', 'throttle', 'brake', 'gear', 'engine_rpm', ...wheels];
  const lap = readLap(siteDir, names);
  const most_n = Math.max(...lap.flatMap((row) => row.slice(5)));
  for (const share of [0.2, 0.6]) {
    const row = lap[Math.floor(share * lap.length)];
    await page.evaluate((t_s) => window.orthodrive.setTime(t_s), row[0] - lap[0][0]);
    await waitUntilDrawn(page);
    const shown = await readDashboard(page);
    assert.equal(shown.gear, String(row[3]));
    assert.ok(Math.abs(parseInt(shown.revs, 10) - row[4]) <= 15, `${shown.revs} are not ${row[4]} 1/min`);
    for (const [id, expected] of [
      ['throttle', row[1]],
      ['brake', row[2]],
    ])
      assert.ok(Math.abs(shown[id] - expected) < 0.01, `${id} shows ${shown[id]} of ${expected}`);
    wheels.forEach((wheel, i) =>
      assert.ok(Math.abs(shown[wheel] - row[5 + i] / most_n) < 0.03, `${wheel} shows ${shown[wheel]}`),
    );
    assert.notEqual(shown['g-circle'], null, 'there is no circle of accelerations');
  }
  for (const [missing, hidden] of [
    [/^(gear|load_.*|brake)$/, ['gear', 'loads', 'brake']],
    [/^(a_lon_mps2|throttle|brake|gear|engine_rpm)$/, ['g-circle', 'throttle', 'brake', 'gear', 'revs']],
  ]) {
    const csv = changedLap(siteDir, (row) =>
      Object.fromEntries(Object.entries(row).filter(([name]) => !missing.test(name))),
    );
    const other = await context.newPage();
    await other.route('**/site/drive/lap.csv', (route) => route.fulfill({body: csv}));
    await other.goto(`${url}?play=0&camera=follow&t=8&${bare}`);
    await waitUntilDrawn(other);
    const shown = await readDashboard(other);
    for (const id of dashboardParts)
      assert.equal(shown[id] === null, hidden.includes(id), `without ${missing} the part ${id} shows ${shown[id]}`);
    await other.close();
  }
}

const lapFolder = 'drive_b';
const factor = 0.9; // of the times of the second lap

/** A second lap that takes nine tenths of the time is seen ahead, with its time gap, and the link brings it back. */
export async function checkGhost(context, url, siteDir) {
  const faster = changedLap(siteDir, (row) => ({...row, t_s: row.t_s * factor, speed_mps: row.speed_mps / factor}));
  const page = await context.newPage();
  await page.route(`**/site/${lapFolder}/lap.csv`, (route) => route.fulfill({body: faster}));
  await page.goto(`${url}?play=0&camera=follow&t=4&${bare}&ghost=${lapFolder}/lap.csv`);
  await waitUntilDrawn(page);
  const state = async (t_s) => {
    await page.evaluate((t) => window.orthodrive.setTime(t), t_s);
    await waitUntilDrawn(page);
    return page.evaluate(() => ({
      car: window.orthodrive.car,
      ghost: window.orthodrive.ghost,
      gap_s: window.orthodrive.gap_s,
      text: document.getElementById('gap').textContent,
    }));
  };
  for (const t_s of [20, 4]) {
    const {car, ghost, gap_s, text} = await state(t_s);
    const apart_m = Math.hypot(car.x_m - ghost.x_m, car.y_m - ghost.y_m);
    console.log(`ghost: ${apart_m.toFixed(1)} m ahead after ${t_s} s, gap ${gap_s.toFixed(3)} s, shown as ${text}`);
    assert.ok(Math.abs(gap_s - (1 - factor) * t_s) < 0.02, `the gap is ${gap_s} s`);
    assert.equal(text, `+${gap_s.toFixed(2)} s`);
    assert.ok(ghost.s_m > car.s_m + 1 && apart_m > 1, 'the faster car is not ahead');
  }
  const withGhost = await sceneShot(page);
  await page.goto(await page.evaluate(() => window.orthodrive.link));
  const restored = await comparePictures(page, withGhost, await sceneShot(page));
  assert.ok(restored < 0.001, `${(100 * restored).toFixed(1)} % of the pixels differ under the same link with a ghost`);
  await checkGhostFiles(page, faster);
  await page.close();
}

/** The ghost stands in the picture, and its switch takes it and its gap away. `page` shows the lap from behind the car. */
export async function checkGhostPicture(page, siteDir) {
  const faster = changedLap(siteDir, (row) => ({...row, t_s: row.t_s * factor, speed_mps: row.speed_mps / factor}));
  await page.evaluate(() => window.orthodrive.setTime(4));
  await page.setInputFiles('#ghost-file', {name: 'faster.csv', mimeType: 'text/csv', buffer: Buffer.from(faster)});
  await page.waitForFunction(() => window.orthodrive.ghost !== undefined);
  const withGhost = await sceneShot(page);
  await page.screenshot({path: join(siteDir, 'viewer_ghost.png')});
  await page.evaluate(() => window.orthodrive.setLayer('ghost', false));
  const changed = await comparePictures(page, withGhost, await sceneShot(page));
  console.log(`ghost: ${(100 * changed).toFixed(2)} % of the pixels change`);
  assert.ok(changed > 0.002, 'the ghost is not to be seen');
  assert.ok(await page.isHidden('#gap-row'), 'there is a gap to a ghost that is not shown');
  await page.evaluate(() => window.orthodrive.setLayer('ghost', true));
  await page.click('#ghost-remove');
  await page.waitForFunction(() => window.orthodrive.ghost === undefined);
}

/** Files of one's own: chosen, dropped, broken. */
async function checkGhostFiles(page, csv) {
  const folder = mkdtempSync(join(tmpdir(), 'orthodrive-ghost-'));
  await page.click('#ghost-remove');
  await page.waitForFunction(() => window.orthodrive.ghost === undefined);
  writeFileSync(join(folder, 'mine.csv'), csv);
  await page.setInputFiles('#ghost-file', join(folder, 'mine.csv'));
  await page.waitForFunction(() => window.orthodrive.ghost !== undefined);
  assert.equal(await page.textContent('#ghost-name'), 'mine.csv');
  assert.ok(
    !(await page.evaluate(() => window.orthodrive.link)).includes('ghost'),
    'the link names a file that only this reader has',
  );
  writeFileSync(join(folder, 'broken.csv'), 't_s,x_m\n0,1\n');
  await page.setInputFiles('#ghost-file', join(folder, 'broken.csv'));
  await page.waitForFunction(() => document.getElementById('message').textContent === 'broken.csv has no column s_m');
  await page.click('#ghost-remove');
  await page.evaluate((text) => {
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([text], 'dropped.csv'));
    document.getElementById('canvas').dispatchEvent(new DragEvent('drop', {dataTransfer, bubbles: true}));
  }, csv);
  await page.waitForFunction(
    () => document.getElementById('ghost-name').textContent === 'dropped.csv' && window.orthodrive.ghost !== undefined,
  );
  rmSync(folder, {recursive: true});
}
