#!/usr/bin/env node
// Measures the OpenDRIVE networks of real towns and writes bench/results/network.json and the tables of docs/network.md.
// Usage: tools/network_numbers.mjs [--only kvarnbyn,pardubice] [--roads FOLDER] [--out FOLDER] [--tool PROGRAM] [--table]
// --roads: folder with the refined roads "SITE drawn.default.gpkg" of tools/refinement_numbers.mjs. --table: only write the page.
import { execFileSync, spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, statSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const root = join(dirname(fileURLToPath(import.meta.url)), '..');
const argument = (name, fallback) => {
  const at = process.argv.indexOf(name);
  return at < 0 ? fallback : process.argv[at + 1];
};
const tool = argument('--tool', join(root, 'build/release/orthodrive'));
const roads = argument('--roads', join(root, 'out/refinement/roads'));
const out = argument('--out', join(root, 'out/network'));
const only = argument('--only', 'kvarnbyn,pardubice').split(',');
const data = join(root, '../shared/data');
const dtm = { kvarnbyn: 'kvarnbyn/dtm_10m_utm33.tif', pardubice: 'pardubice/dtm_20m.tif' };
const store = join(root, 'bench/results/network.json');
const numbers = existsSync(store) ? JSON.parse(readFileSync(store, 'utf8')) : {};
mkdirSync(out, { recursive: true });

const run = (program, args, options = {}) =>
  spawnSync(program, args, { encoding: 'utf8', maxBuffer: 1 << 28, ...options });
function orthodrive(...args) {
  const { status, stdout, stderr } = run(tool, ['--quiet', ...args]);
  if (status !== 0) throw new Error(`orthodrive ${args.join(' ')}\n${stderr}`);
  return stdout;
}

// Warnings by their text without names and numbers, e.g. {"Found sharp turn with radius # at the start of edge #.": 3}.
function sumo(xodr, net) {
  const { status, stdout, stderr } = run('netconvert', ['--opendrive-files', xodr, '--xml-validation', 'never',
    '--aggregate-warnings', '-1', '-o', net], { env: { ...process.env, SUMO_HOME: '/usr/share/sumo' } });
  const lines = (stdout + stderr).split('\n').filter((line) => /^(Warning|Error)/.test(line));
  const kinds = {};
  for (const line of lines) {
    const kind = line.replace(/'[^']*'|-?\d+(\.\d+)?/g, '#');
    kinds[kind] = (kinds[kind] ?? 0) + 1;
  }
  return { status, errors: lines.filter((line) => line.startsWith('Error')).length,
    warnings: lines.filter((line) => line.startsWith('Warning')).length, kinds };
}

function measure(site) {
  const raw = join(roads, `${site} drawn.default.gpkg`), gpkg = join(out, `${site}.gpkg`), xodr = join(out, `${site}.xodr`);
  const net = join(out, `${site}.net.xml`);
  orthodrive('elevate', '--roads', raw, '--dtm', join(data, dtm[site]), '-o', gpkg);
  const start = process.hrtime.bigint();
  orthodrive('network', '--roads', gpkg, '-o', xodr, '--findings', join(out, `${site}.findings.geojson`));
  const seconds = Number(process.hrtime.bigint() - start) / 1e9;
  const scores = JSON.parse(orthodrive('evaluate', 'network', xodr, '--json'));
  const schema = join(data, 'opendrive/xsd/1.7.0/opendrive_17_core.xsd');
  const valid = run('xmllint', ['--noout', '--schema', schema, xodr]).status === 0;
  const netconvert = sumo(xodr, net);
  const routes = JSON.parse(execFileSync(join(root, 'tools/sumo_routes'), [gpkg, xodr, net], { encoding: 'utf8' }));
  const findings = {};
  for (const f of JSON.parse(readFileSync(join(out, `${site}.findings.geojson`), 'utf8')).features)
    findings[f.properties.code] = (findings[f.properties.code] ?? 0) + 1;
  numbers[site] = { scores, valid, netconvert, routes, findings, seconds: +seconds.toFixed(2), file_mb: +(statSync(xodr).size / 1e6).toFixed(1) };
  writeFileSync(store, JSON.stringify(numbers, null, 1) + '\n');
}

// ---- the tables of docs/network.md, between the marks
function table() {
  const sites = Object.keys(numbers), title = (s) => s[0].toUpperCase() + s.slice(1);
  const row = (name, asked, value) => `| ${name} | ${asked} | ${sites.map((s) => value(numbers[s])).join(' | ')} |`;
  const fixed = (value, digits) => (value === null || value === undefined || Number.isNaN(value) ? '-' : (+value).toFixed(digits));
  const tiny = (value) => (value < 1e-6 ? 'below 1e-6' : fixed(value, 6));
  const plain = (n) => n.scores.roads - n.scores.connecting_roads;
  const elements = (n) => Object.values(n.scores.elements).reduce((sum, count) => sum + count, 0);
  return [
    `| | asked | ${sites.map(title).join(' | ')} |`, `|---|---|${sites.map(() => '---').join('|')}|`,
    row('roads + connecting roads', '', (n) => `${plain(n)} + ${n.scores.connecting_roads}`),
    row('junctions', '', (n) => n.scores.junctions),
    row('length, connecting roads included, km', '', (n) => fixed(n.scores.length_m / 1000, 1)),
    row('elements: line / arc / spiral / paramPoly3', '', (n) => Object.values(n.scores.elements).length
      ? ['line', 'arc', 'spiral', 'paramPoly3'].map((kind) => n.scores.elements[kind]).join(' / ') : '-'),
    row('metres an element, connecting roads included', '', (n) => fixed(n.scores.length_m / elements(n), 1)),
    row('valid against the 1.7.0 schema', 'yes', (n) => (n.valid ? 'yes' : 'NO')),
    row('netconvert: errors / warnings', '0 / 0', (n) => `${n.netconvert.errors} / ${n.netconvert.warnings}`),
    row('routes of OSM that SUMO finds', '99 %', (n) => `${fixed(100 * n.routes.share, 1)} %`),
    row('the same without the U-turns netconvert adds', '', (n) => `${fixed(100 * n.routes.no_u_turns_share, 1)} %`),
    row('connected share of the length', '', (n) => `${fixed(100 * n.scores.connected_share, 1)} %`),
    row('links without an answer, lane link errors', '0, 0', (n) => `${n.scores.broken_links}, ${n.scores.lane_link_errors}`),
    row('largest gap between ends that meet, m', '', (n) => tiny(n.scores.max_joint_gap_m)),
    row('largest heading jump, rad', '', (n) => tiny(n.scores.max_heading_jump_rad)),
    row('largest gradient kink', '0.001', (n) => tiny(n.scores.max_gradient_kink)),
    row('largest curvature jump outside junctions, 1/m', '0', (n) => tiny(n.scores.max_curvature_jump)),
    row('smallest clearance of crossings on two levels, m', '4.7', (n) => fixed(n.scores.min_clearance_m, 2)),
    row('network stage, s', '', (n) => n.seconds),
    row('file, MB', '', (n) => n.file_mb),
  ].join('\n');
}

function write_page() {
  const page = join(root, 'docs/network.md'), text = readFileSync(page, 'utf8');
  const begin = '<!-- network_numbers -->', end = '<!-- /network_numbers -->';
  const a = text.indexOf(begin), b = text.indexOf(end);
  if (a < 0 || b < 0) throw new Error(`${page} lacks the marks ${begin} ... ${end}`);
  writeFileSync(page, `${text.slice(0, a + begin.length)}\n${table()}\n${text.slice(b)}`);
}

if (!process.argv.includes('--table')) only.forEach(measure);
write_page();
