#!/usr/bin/env node
// SPDX-License-Identifier: Apache-2.0
// Validates .glb files (or all of a folder) with Khronos' gltf-validator: one line a file, exit code 1 on any error.
//   npm ci --prefix viewer && node tools/validate_gltf.mjs DIR/scene [more files or folders]
import {readdirSync, readFileSync, statSync} from 'node:fs';
import {createRequire} from 'node:module';
import {dirname, join} from 'node:path';

// The package is the viewer's; ORTHODRIVE_NODE_MODULES names another folder that has it.
const packages = process.env.ORTHODRIVE_NODE_MODULES ?? new URL('../viewer/node_modules', import.meta.url).pathname;
const validator = createRequire(join(packages, 'gltf-validator', 'index.js'))('gltf-validator');

const files = process.argv.slice(2).flatMap((path) =>
  statSync(path).isDirectory()
    ? readdirSync(path)
        .filter((name) => name.endsWith('.glb'))
        .sort()
        .map((name) => join(path, name))
    : [path],
);
if (files.length === 0) {
  console.error('no .glb file given');
  process.exit(2);
}
let failed = 0;
for (const file of files) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(file)), {
    uri: file,
    externalResourceFunction: async (uri) => new Uint8Array(readFileSync(join(dirname(file), decodeURIComponent(uri)))),
  });
  const {numErrors, numWarnings} = report.issues;
  console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings, ${report.info.totalTriangleCount} triangles`);
  for (const issue of report.issues.messages.filter((m) => m.severity <= 1))
    console.log(`  ${issue.code} ${issue.pointer ?? ''}: ${issue.message}`);
  if (numErrors > 0) ++failed;
}
process.exit(failed > 0 ? 1 : 0);
