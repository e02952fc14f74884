// SPDX-License-Identifier: Apache-2.0
// Starts `orthodrive view` and a browser for the tests.

import {spawn} from 'node:child_process';
import {createInterface} from 'node:readline';

import {chromium} from 'playwright-core';

/** Serves on a free port. stop() presses Ctrl-C and returns the exit code. */
export async function serveSite(tool, siteDir, environment = {}) {
  const server = spawn(tool, ['view', siteDir, '--port', '0', '--no-open', '--quiet'], {
    stdio: ['ignore', 'pipe', 'inherit'],
    env: {...process.env, ...environment},
  });
  const exited = new Promise((resolve, reject) => {
    server.once('exit', resolve);
    server.once('error', reject);
  });
  const firstLine = new Promise((resolve) => createInterface({input: server.stdout}).once('line', resolve));
  const url = await Promise.race([firstLine, exited]);
  if (typeof url !== 'string') throw new Error(`orthodrive view ended with exit code ${url}`);
  return {
    url,
    stop() {
      server.kill('SIGINT');
      return exited;
    },
  };
}

/**
 * Debian's Chromium with a fresh profile, no background traffic, and WebGL drawn by the processor; `pixels`: for each of
 * the page's; `touch`: its pages are touched; `plain`: without smooth edges and the blur behind cards, half of the work of a
 * picture, for checks that judge neither. Whatever its pages are asked for may take six minutes: other work beside it is no
 * error of the page.
 */
export async function openBrowser(profileDir, {pixels = 1, touch = false, plain = false, bypassCSP = false} = {}) {
  const context = await chromium.launchPersistentContext(profileDir, {
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    viewport: {width: 1280, height: 800},
    deviceScaleFactor: pixels,
    hasTouch: touch,
    bypassCSP,
    args: [
      '--headless=new',
      '--no-sandbox',
      '--disable-quic',
      '--no-first-run',
      '--disable-background-networking',
      '--disable-component-update',
      '--disable-sync',
      '--use-gl=angle',
      '--use-angle=swiftshader',
      '--enable-unsafe-swiftshader',
      ...(plain ? ['--webgl-msaa-sample-count=0'] : []),
    ],
  });
  if (plain)
    await context.addInitScript(() => {
      const sheet = new CSSStyleSheet();
      sheet.replaceSync('* { backdrop-filter: none !important }');
      document.adoptedStyleSheets.push(sheet);
    });
  context.setDefaultTimeout(360_000);
  return context;
}
