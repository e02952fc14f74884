// SPDX-License-Identifier: Apache-2.0
// Measures how the viewer streams a built site in Chromium: node measure_stream.mjs SITE_DIR TOOL [name=value ...], JSON on stdout.
//   length=10000 m of the lap at speed=50 m/s, looked at from camera=driver (or follow). By the clock, or with step=0.2 as if
//   every picture took 0.2 s: for machines that draw slower than that, where loading is as slow.

import {mkdtempSync, readdirSync, readFileSync, rmSync, statSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';

import {readLap} from '../test/page_helpers.mjs';
import {openBrowser, serveSite} from '../test/serve_and_open.mjs';
import {gridPlaces, heldBytes, indicesAhead, isHole, lapPlaces, placeAt, summary} from './stream_numbers.mjs';

const [siteDir, tool, ...words] = process.argv.slice(2);
if (!tool) {
  console.error('usage: node measure_stream.mjs SITE_DIR TOOL [length=10000] [speed=50] [camera=driver] [step=0]');
  process.exit(2);
}
const given = Object.fromEntries(words.map((word) => word.split('=')));
const [length_m, speed_mps, step_s] = [
  ['length', 10_000],
  ['speed', 50],
  ['step', 0],
].map(([name, usual]) => Number(given[name] ?? usual));
const camera = given.camera ?? 'driver';

/** Drawn with fewer pixels, because the processor draws them; tiles are chosen by the size of the page as ever. */
const drivePixels = 0.25;

/** Of this program's children and theirs: the server and the browser. */
function processorSeconds() {
  const ticks = 100;
  const processes = new Map();
  for (const pid of readdirSync('/proc').filter((name) => /^\d+$/.test(name))) {
    try {
      const fields = readFileSync(`/proc/${pid}/stat`, 'utf8')
        .replace(/^.*\) /s, '')
        .split(' ');
      processes.set(Number(pid), {
        parent: Number(fields[1]),
        seconds: (Number(fields[11]) + Number(fields[12])) / ticks,
      });
    } catch {} // it has ended meanwhile
  }
  const isBelow = (pid) => pid === process.pid || (processes.has(pid) && isBelow(processes.get(pid).parent));
  return [...processes]
    .filter(([pid]) => pid !== process.pid && isBelow(pid))
    .reduce((sum, [, {seconds}]) => sum + seconds, 0);
}

/** A browser that knows nothing yet, with the site open. `watch` runs in the page from its beginning. */
async function withPage(query, {watch, note = () => {}, pixels = 1}, work) {
  const profile = mkdtempSync(join(tmpdir(), 'orthodrive-browser-'));
  const server = await serveSite(tool, siteDir);
  let context;
  try {
    context = await openBrowser(profile, {pixels});
    const page = context.pages()[0] ?? (await context.newPage());
    await page.goto('about:blank');
    await context.exposeFunction('streamNote', note);
    if (watch) await page.addInitScript(watch);
    note('begin');
    await page.goto(`${server.url}${query}`, {waitUntil: 'commit'});
    return await work(page);
  } finally {
    await context?.close();
    rmSync(profile, {recursive: true, force: true, maxRetries: 5});
    await server.stop();
  }
}

/** Seconds from the navigation. `first`: tiles cover all that is seen; `road`: level 0 under the car; `whole`: nothing more is to come. */
function watchFirst() {
  const times = {};
  window.streamTimes = times;
  const look = () => {
    const {orthodrive} = window;
    const note = (name, is) => {
      if (!is || times[name]) return;
      times[name] = performance.now() / 1000;
      void window.streamNote(name);
    };
    note('script', orthodrive);
    if (!times.first && orthodrive?.covered && orthodrive.frame > 0) {
      const gl = document.getElementById('canvas').getContext('webgl2');
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); // waits until the picture is drawn
      note('first', true);
    }
    if (times.first && !times.road && orthodrive.car) {
      // the car may come after the first picture
      const {x_m, y_m, z_m} = orthodrive.car;
      note('road', orthodrive.roadNear(x_m, y_m, z_m)?.error_m === 0);
    }
    note('whole', orthodrive?.ready);
    if (!times.whole) requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
}

async function measureFirst(query) {
  const used = {};
  const since = (name) => used[name] - used.begin;
  return withPage(query, {watch: watchFirst, note: (name) => (used[name] = processorSeconds())}, async (page) => {
    await page.waitForFunction(() => window.streamTimes?.whole);
    const {times, requests, held} = await page.evaluate(() => ({
      times: window.streamTimes,
      held: window.orthodrive.held.length,
      requests: performance
        .getEntriesByType('resource')
        .map(({name, startTime, responseEnd, encodedBodySize}) => [
          name.split('/').slice(3).join('/'),
          Math.round(startTime),
          Math.round(responseEnd),
          encodedBodySize,
        ]),
    }));
    if (given.requests) requests.forEach((request) => console.error(request.join(' ')));
    return {
      script_s: times.script,
      first_s: times.first,
      road_s: times.road,
      whole_s: times.whole,
      tiles: held,
      script_processor_s: since('script'),
      first_processor_s: since('first'),
      road_processor_s: since('road'),
      whole_processor_s: since('whole'),
    };
  });
}

/** Goes to a place of the lap and waits for the next picture; tells what it shows. Runs in the page. */
async function pictureAt({t_s, places}) {
  const {orthodrive} = window;
  const before = orthodrive.frame;
  orthodrive.setTime(t_s);
  while (orthodrive.frame === before) await new Promise(requestAnimationFrame);
  const inPicture = ([x, , ahead]) => Math.abs(x) <= 1 && ahead > -1 && ahead < 1;
  return {
    held: orthodrive.held,
    drawn: orthodrive.drawn,
    visible: orthodrive.tilesVisible,
    failures: orthodrive.failures,
    roads: places
      .map(({x_m, y_m, z_m}) =>
        inPicture(orthodrive.pictured(x_m, y_m, z_m)) ? (orthodrive.roadNear(x_m, y_m, z_m) ?? null) : undefined,
      )
      .map((road) => (road === undefined ? 'unseen' : road)),
  };
}

async function measureDrive(places) {
  const grid = gridPlaces(places);
  const fileBytes = (file) => statSync(join(siteDir, 'scene', file)).size;
  return withPage(`?camera=${camera}&t=0&play=0`, {pixels: drivePixels}, async (page) => {
    await page.waitForFunction(() => window.orthodrive?.ready);
    const pictures = [];
    const start = performance.now();
    for (let s_m = 0; s_m < Math.min(length_m, places[places.length - 1].s_m); ) {
      const t_s = step_s ? (pictures.length + 1) * step_s : (performance.now() - start) / 1000;
      s_m = Math.min(length_m, places[places.length - 1].s_m, speed_mps * t_s);
      const ahead = indicesAhead(s_m, grid.length);
      const {held, drawn, visible, failures, roads} = await page.evaluate(pictureAt, {
        t_s: placeAt(places, s_m).t_s,
        places: ahead.map((i) => grid[i]),
      });
      if (failures.length > 0) throw new Error(failures[0]);
      const seen = ahead.map((i, k) => [i, roads[k]]).filter(([, road]) => road !== 'unseen');
      pictures.push({
        t_s,
        s_m,
        drawn,
        visible,
        held: heldBytes(held, fileBytes),
        places: seen.length,
        holes: seen.filter(([i, road]) => isHole(grid[i], road)).map(([i]) => i),
        coarse: seen.filter(([, road]) => road?.error_m > 0).map(([i]) => i),
      });
      if (given.pictures) console.error(JSON.stringify(pictures[pictures.length - 1]));
    }
    return {camera, speed_mps, step_s, ...summary(pictures)};
  });
}

const {origin} = JSON.parse(readFileSync(join(siteDir, 'scene/tileset.json'), 'utf8')).asset.extras.orthodrive;
const places = lapPlaces(readLap(siteDir, ['t_s', 's_m', 'x_m', 'y_m', 'z_m']), origin);
const result = {first: {}};
for (const mode of given.first === '0' ? [] : ['fly', camera])
  result.first[mode] = await measureFirst(`?camera=${mode}&t=0&play=0`);
if (length_m > 0) result.drive = await measureDrive(places);
console.log(JSON.stringify(result, null, 1));
