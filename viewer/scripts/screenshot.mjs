// SPDX-License-Identifier: Apache-2.0
// A picture of a built site, for documents: node viewer/scripts/screenshot.mjs SITE_DIR TOOL OUT.png ['?camera=follow&t=20']
// A name that ends in .jpg: a JPEG without the page's cards.

import {mkdtempSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';

import {hideCards} from '../test/page_helpers.mjs';
import {openBrowser, serveSite} from '../test/serve_and_open.mjs';

const [siteDir, tool, picture, query = '?'] = process.argv.slice(2);
if (!picture) {
  console.error("usage: node screenshot.mjs SITE_DIR TOOL OUT.png ['?camera=follow&t=20']");
  process.exit(2);
}
const profile = mkdtempSync(join(tmpdir(), 'orthodrive-browser-'));
const server = await serveSite(tool, siteDir);
let context;
try {
  context = await openBrowser(profile);
  const page = context.pages()[0] ?? (await context.newPage());
  await page.goto(`${server.url}${query}&play=0`);
  await page.waitForFunction(() => window.orthodrive?.ready);
  if (picture.endsWith('.jpg')) {
    await hideCards(page);
    await page.screenshot({path: picture, type: 'jpeg', quality: 70});
  } else {
    await page.screenshot({path: picture});
  }
} finally {
  await context?.close();
  rmSync(profile, {recursive: true, force: true, maxRetries: 5});
  await server.stop();
}
