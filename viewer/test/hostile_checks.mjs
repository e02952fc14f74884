// SPDX-License-Identifier: Apache-2.0
// Checks that texts out of data are shown as texts, and that the page loads and runs nothing but its own.

import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {join} from 'node:path';

import {bare} from './page_helpers.mjs';

const hostile = '<img src=x onerror="window.hacked = true"><script>window.hacked = true</script>&lt;b&gt;"\'';

/** A site whose name, attribution, findings and file of a ghost want to be more than text. */
export async function checkHostileTexts(context, url, siteDir) {
  const json = (name) => JSON.parse(readFileSync(join(siteDir, name), 'utf8'));
  const page = await context.newPage();
  const run = {...json('run.json'), site: {name: hostile}, attribution: [hostile]};
  const findings = {
    type: 'FeatureCollection',
    features: [
      {
        type: 'Feature',
        geometry: {type: 'Point', coordinates: [16.2, 49.55]},
        properties: {severity: hostile, code: hostile, message: hostile},
      },
    ],
  };
  await page.route('**/site/run.json', (route) => route.fulfill({json: run}));
  await page.route('**/site/findings.geojson', (route) => route.fulfill({json: findings}));
  const asked = [];
  page.on('request', (request) => asked.push(request.url()));
  for (const ghost of ['../../secret.csv', '//evil.example/lap.csv']) {
    await page.goto(`${url}?play=0&${bare}&ghost=${encodeURIComponent(ghost)}`);
    await page.waitForFunction(
      () => document.getElementById('site-name').textContent !== '' && !document.getElementById('message').hidden,
    );
    const seen = await page.evaluate(() => ({
      name: document.getElementById('site-name').textContent,
      attribution: document.getElementById('attribution').textContent,
      message: document.getElementById('message').textContent,
      elements: document.querySelectorAll('#title img, footer *, #message *, script:not([src])').length,
      hacked: window.hacked,
    }));
    assert.deepEqual([seen.name, seen.attribution, seen.elements, seen.hacked], [hostile, hostile, 0, undefined]);
    assert.ok(seen.message.includes(ghost), `the page does not say what is wrong with the ghost: ${seen.message}`);
  }
  const elsewhere = asked.filter((address) => !address.startsWith(url) && !/^(blob|data):/.test(address));
  assert.deepEqual(elsewhere, [], 'the page asks elsewhere');
  assert.deepEqual(
    asked.filter((address) => new URL(address).pathname.includes('secret')),
    [],
    'the page looks for a ghost outside the site',
  );
  await checkPolicy(page);
  await page.close();
}

/** Even where a text became an element the browser would not run it, nor send anything away. */
async function checkPolicy(page) {
  const refused = await page.evaluate(async (text) => {
    const said = [];
    document.addEventListener('securitypolicyviolation', ({effectiveDirective}) => said.push(effectiveDirective));
    const box = document.createElement('div');
    box.innerHTML = text;
    const script = document.createElement('script');
    script.textContent = 'window.hacked = true';
    document.body.append(box, script);
    await fetch('http://evil.example/').catch(() => {});
    await new Promise((resolve) => setTimeout(resolve, 500));
    return {said, hacked: window.hacked};
  }, hostile);
  assert.equal(refused.hacked, undefined, 'the browser runs scripts out of data');
  for (const directive of ['script-src-elem', 'script-src-attr', 'connect-src'])
    assert.ok(refused.said.includes(directive), `nothing refuses ${directive}: ${refused.said}`);
}
