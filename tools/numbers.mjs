#!/usr/bin/env node
// Measures the numbers that docs/numbers.md shows and writes that page. Builds every site from nothing, so it takes most of
// an hour on two cores. Usage: tools/numbers.mjs [--only village,kvarnbyn,pardubice] [--out FOLDER]
// What is not measured in this run keeps its last values from bench/results/numbers.json.
import { execFileSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { existsSync, mkdirSync, readFileSync, readdirSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { cpus, totalmem } from 'node:os';
import { dirname, join, relative } from 'node:path';
import { fileURLToPath } from 'node:url';

const root = join(dirname(fileURLToPath(import.meta.url)), '..');
const tool = join(root, 'build/release/orthodrive');
const argument = (name, fallback) => {
  const at = process.argv.indexOf(name);
  return at < 0 ? fallback : process.argv[at + 1];
};
const out = argument('--out', join(root, 'out/numbers'));
const only = argument('--only', 'village,kvarnbyn,pardubice').split(',');
const store = join(root, 'bench/results/numbers.json');
const numbers = existsSync(store) ? JSON.parse(readFileSync(store, 'utf8')) : {};

const orthodrive = (...args) => execFileSync(tool, ['--quiet', ...args], { encoding: 'utf8', maxBuffer: 1 << 26, stdio: ['ignore', 'pipe', 'inherit'] });
const evaluate = (...args) => JSON.parse(orthodrive('evaluate', ...args, '--json'));
const commit = execFileSync('git', ['-C', root, 'rev-parse', '--short', 'HEAD'], { encoding: 'utf8' }).trim();
const changed = execFileSync('git', ['-C', root, 'status', '--porcelain', '--untracked-files=no'], { encoding: 'utf8' }).trim() !== '';
const measured = { commit: commit + (changed ? ' + changes' : ''), cores: cpus().length, cpu: cpus()[0].model, memory_gb: Math.round(totalmem() / 1e9) };

function build(site, name, ...more) {
  const folder = join(out, name);
  rmSync(folder, { recursive: true, force: true });
  const start = Date.now();
  orthodrive('build', site, '-o', folder, ...more);
  const seconds = (Date.now() - start) / 1000;
  const run = JSON.parse(readFileSync(join(folder, 'run.json'), 'utf8'));
  return {
    ...measured, folder, seconds,
    peak_gb: Math.max(...run.stages.map((s) => s.peak_memory_bytes)) / 1e9,
    stages: run.stages.map((s) => ({ stage: s.stage, seconds: s.seconds, peak_mb: s.peak_memory_bytes / 1e6 })),
  };
}

// Files whose content must not depend on the run: all but the timings.
function hashes(folder) {
  const result = {};
  const visit = (dir) => {
    for (const name of readdirSync(dir).sort()) {
      const path = join(dir, name);
      if (statSync(path).isDirectory()) { if (name !== '.orthodrive') visit(path); }
      else if (name !== 'run.json' && name !== 'report.html') result[relative(folder, path)] = createHash('sha256').update(readFileSync(path)).digest('hex');
    }
  };
  visit(folder);
  return result;
}

mkdirSync(out, { recursive: true });
if (only.includes('village')) {
  const site = join(out, 'village_site');
  rmSync(site, { recursive: true, force: true });
  orthodrive('synth', '--preset', 'village', '--seed', '7', '-o', site);
  const built = build(join(site, 'site.toml'), 'village', '--threads', '2');
  const again = build(join(site, 'site.toml'), 'village_again', '--threads', '2');
  const single = build(join(site, 'site.toml'), 'village_1_thread', '--threads', '1');
  const reference = hashes(built.folder);
  const differ = (other) => { const h = hashes(other); return Object.keys({ ...reference, ...h }).filter((f) => reference[f] !== h[f]); };
  numbers.village = {
    ...built, files: Object.keys(reference).length, differ_again: differ(again.folder), differ_1_thread: differ(single.folder),
    input: evaluate('roads', join(site, 'roads.osm'), join(site, 'truth')),
    result: evaluate('site', built.folder, '--truth', join(site, 'truth')),
  };
}
for (const name of ['kvarnbyn', 'pardubice'])
  if (only.includes(name)) numbers[name] = { ...build(join(root, `sites/${name}.toml`), name), network: evaluate('network', join(out, name, 'roads.xodr')) };
if (only.includes('kvarnbyn'))  // built from the 10 m terrain; the 2 m terrain of the west is the truth
  numbers.kvarnbyn.heights = evaluate('heights', join(out, 'kvarnbyn/roads.gpkg'), join(root, '../shared/data/kvarnbyn/dtm_2m_west.tif'));

for (const site of Object.values(numbers)) delete site.folder;
mkdirSync(dirname(store), { recursive: true });
writeFileSync(store, JSON.stringify(numbers, null, 1) + '\n');

const f = (value, digits = 2) => value === undefined || value === null ? 'not measured' : value.toFixed(digits);
const yes = (good) => good ? 'yes' : '**no**';
const { village, kvarnbyn, pardubice } = numbers;
const rows = [];
if (kvarnbyn) {
  rows.push(['Kvarnbyn (2.1 x 1.5 km): seconds to build', '<= 300', f(kvarnbyn.seconds, 0), kvarnbyn.seconds <= 300]);
  rows.push(['Kvarnbyn: peak memory (GB)', '<= 4', f(kvarnbyn.peak_gb), kvarnbyn.peak_gb <= 4]);
}
if (pardubice) {
  rows.push(['Pardubice (23 km2): seconds to build', '<= 1800', f(pardubice.seconds, 0), pardubice.seconds <= 1800]);
  rows.push(['Pardubice: peak memory (GB)', '<= 8', f(pardubice.peak_gb), pardubice.peak_gb <= 8]);
}
if (village) {
  const before = 100 * village.input.surface_iou, after = 100 * village.result.roads.surface_iou;
  rows.push(['Village: road surface IoU, points above the input', '>= 10', `${f(after - before, 1)} (${f(before, 1)} -> ${f(after, 1)})`, after - before >= 10]);
  const e0 = village.input.offset_m.mean_abs, e1 = village.result.roads.offset_m.mean_abs;
  rows.push(['Village: mean centre-line error, share of the input\'s', '<= 0.5', `${f(e1 / e0)} (${f(e0)} m -> ${f(e1)} m)`, e1 <= 0.5 * e0]);
  rows.push(['Village: files that differ, same seed twice', '0', `${village.differ_again.length} of ${village.files}`, village.differ_again.length === 0]);
  rows.push(['Village: files that differ, 1 and 2 threads', '0', `${village.differ_1_thread.length} of ${village.files}`, village.differ_1_thread.length === 0]);
}
let page = `# Numbers

Written by \`tools/numbers.mjs\` from \`bench/results/numbers.json\`; every number was measured on the commit beside it. The machines are
shared and noisy; these seconds are of an otherwise idle machine. The network was
trained on thirteen villages of other seeds, so village 7 is a new place, but one in a style it knows; Kvarnbyn's west and
Pardubice were in its training, too. The road IoU of the network on held-out places stands in
[models/default.md](../models/default.md).

| | asked | reached | |
|---|---|---|---|
${rows.map(([what, asked, reached, good]) => `| ${what} | ${asked} | ${reached} | ${yes(good)} |`).join('\n')}

`;
if (village) {
  const r = village.result, line = (what, unit, pick) => `| ${what} | ${unit} | ${pick(village.input)} | ${pick(r.roads)} |`;
  page += `## Village (synthetic, seed 7, 1 km2 at 0.2 m/px): against exact truth

| | unit | input OSM | result |
|---|---|---|---|
${line('road surface IoU', '%', (x) => f(100 * x.surface_iou, 1))}
${['bias', 'mean_abs', 'p95'].map((k) => line(`centre line offset, ${k}`, 'm', (x) => f(x.offset_m[k]))).join('\n')}
${['bias', 'mean_abs', 'p95'].map((k) => line(`width, ${k}`, 'm', (x) => f(x.width_m[k]))).join('\n')}

Heights of the result: bias ${f(r.heights.z_m.bias)} m, mean ${f(r.heights.z_m.mean_abs)} m, 95 % ${f(r.heights.z_m.p95)} m.
Labels: road IoU ${f(100 * r.labels.road_iou, 1)} %, mean IoU ${f(100 * r.labels.mean_iou, 1)} %, pixel accuracy ${f(100 * r.labels.pixel_accuracy, 1)} %.

`;
}
for (const [title, site] of [['Kvarnbyn', kvarnbyn], ['Pardubice', pardubice], ['Village', village]])
  if (site) {
    page += `## ${title}: seconds and peak memory a stage

Commit ${site.commit}, ${site.cores} cores (${site.cpu}), ${site.memory_gb} GB.

| stage | seconds | peak MB |
|---|---|---|
${site.stages.map((s) => `| ${s.stage} | ${f(s.seconds, 1)} | ${f(s.peak_mb, 0)} |`).join('\n')}
| all | ${f(site.seconds, 1)} | ${f(1000 * site.peak_gb, 0)} |

`;
    if (site.heights) page += `Heights, built from 10 m terrain, against the 2 m terrain of the western part (${site.heights.z_m.n} nodes): bias ${f(site.heights.z_m.bias)} m, mean ${f(site.heights.z_m.mean_abs)} m, 95 % ${f(site.heights.z_m.p95)} m.\n\n`;
    if (site.network) page += `Network: ${site.network.roads} roads, ${site.network.junctions} junctions, ${f(site.network.length_m / 1000, 1)} km, largest joint gap ${site.network.max_joint_gap_m.toExponential(1)} m, largest gradient kink ${site.network.max_gradient_kink.toExponential(1)}, ${f(100 * site.network.connected_share, 1)} % of the length connected.\n\n`;
  }
writeFileSync(join(root, 'docs/numbers.md'), page.trimEnd() + '\n');
console.log(rows.map((r) => r.join('  ')).join('\n'));
