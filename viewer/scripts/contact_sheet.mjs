// SPDX-License-Identifier: Apache-2.0
// Pictures of a built site from the driver's seat, evenly along its lap, on one sheet:
// node viewer/scripts/contact_sheet.mjs SITE_DIR TOOL OUT.jpg [COUNT]
// Beside the sheet, in a folder of its name, lie the single pictures.

import {mkdirSync, mkdtempSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';

import {readLap, sceneShot} from '../test/page_helpers.mjs';
import {openBrowser, serveSite} from '../test/serve_and_open.mjs';

const columns = 4,
  width = 400,
  height = 250;

const [siteDir, tool, sheet, countText = '20'] = process.argv.slice(2);
const count = Number(countText);
if (!sheet || !(count > 0)) {
  console.error('usage: node contact_sheet.mjs SITE_DIR TOOL OUT.jpg [COUNT]');
  process.exit(2);
}
const times = readLap(siteDir, ['t_s']).flat();
const first = times[0],
  last = times[times.length - 1];
const folder = sheet.replace(/\.jpg$/, '');
mkdirSync(folder, {recursive: true});

const profile = mkdtempSync(join(tmpdir(), 'orthodrive-browser-'));
const server = await serveSite(tool, siteDir);
let context;
try {
  context = await openBrowser(profile);
  const page = context.pages()[0] ?? (await context.newPage());
  await page.goto(`${server.url}?camera=driver&t=0&play=0&off=route`);
  const cells = [];
  for (let i = 0; i < count; ++i) {
    const t_s = ((i + 0.5) / count) * (last - first);
    await page.waitForFunction(() => window.orthodrive !== undefined);
    await page.evaluate((t) => window.orthodrive.setTime(t), t_s);
    const png = await sceneShot(page);
    writeFileSync(join(folder, `t${t_s.toFixed(0).padStart(4, '0')}.png`), png);
    cells.push(
      `<figure><img src="data:image/png;base64,${png.toString('base64')}"><figcaption>${t_s.toFixed(0)} s</figcaption></figure>`,
    );
  }
  const style = `body { margin: 0; display: grid; grid-template-columns: repeat(${columns}, ${width}px); background: white }
    figure { margin: 0; position: relative } img { width: ${width}px; height: ${height}px; display: block }
    figcaption { position: absolute; left: 4px; top: 2px; font: 13px sans-serif; color: white; text-shadow: 0 0 3px black }`;
  await page.setContent(`<style>${style}</style>${cells.join('')}`);
  await page.setViewportSize({width: columns * width, height: Math.ceil(count / columns) * height});
  await page.screenshot({path: sheet, type: 'jpeg', quality: 75});
} finally {
  await context?.close();
  rmSync(profile, {recursive: true, force: true, maxRetries: 5});
  await server.stop();
}
