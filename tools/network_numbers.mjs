#!/usr/bin/env node
// Measures the OpenDRIVE networks of real towns and writes bench/results/network.json and the tables of docs/network.md.
// Usage: tools/network_numbers.mjs [--only kvarnbyn,pardubice] [--roads FOLDER] [--out FOLDER] [--tool PROGRAM] [--table]
// --roads: folder with the refined roads "SITE drawn.default.gpkg" of tools/refinement_numbers.mjs. --table: only write the page.
import { execFileSync, spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, readdirSync, readFileSync, statSync, writeFileSync } from 'node:fs';
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

// The 1.8.1 schema is XSD 1.1, xmllint knows 1.0: without assertions and types by attribute (our junctions are common ones).
function schema_18(folder) {
  const copy = join(out, 'xsd18');
  mkdirSync(copy, { recursive: true });
  for (const file of readdirSync(folder)) {
    const lines = readFileSync(join(folder, file), 'utf8').split('\n').filter((line) => !/<xs:(assert|alternative)/.test(line))
      .map((line) => line.replace('name="junction" type="t_junction"', 'name="junction" type="t_junction_common"'));
    writeFileSync(join(copy, file), lines.join('\n'));
  }
  return join(copy, 'OpenDRIVE_Core.xsd');
}

function measure(site) {
  const raw = join(roads, `${site} drawn.default.gpkg`), gpkg = join(out, `${site}.gpkg`), xodr = join(out, `${site}.xodr`);
  const net = join(out, `${site}.net.xml`);
  orthodrive('elevate', '--roads', raw, '--dtm', join(data, dtm[site]), '-o', gpkg);
  // Once timed, once with the file read back.
  const built = run('/usr/bin/time', ['-f', 'took %U %S s %M kB', tool, 'network', '--roads', gpkg, '-o', xodr, '--findings', join(out, `${site}.findings.geojson`)]);
  if (built.status !== 0) throw new Error(built.stderr);
  const [, user, system, kilobytes] = built.stderr.match(/took ([\d.]+) ([\d.]+) s (\d+) kB/);
  const [, chain_km, chain_elements] = built.stderr.match(/chains of ([\d.]+) km fitted with (\d+) elements/);
  const [, plan_m, profile_m] = built.stderr.match(/nodes lie within ([\d.]+) m of the lines and ([\d.]+) m/);
  const checked = run(tool, ['network', '--roads', gpkg, '-o', xodr, '--check']);
  if (checked.status !== 0) throw new Error(checked.stderr);
  const [, points, round_trip_m] = checked.stderr.match(/(\d+) points of the surface lie within (\S+) m/);
  const xodr18 = join(out, `${site}.18.xodr`);
  orthodrive('network', '--roads', gpkg, '-o', xodr18, '--opendrive', '1.8');
  const scores = JSON.parse(orthodrive('evaluate', 'network', xodr, '--json'));
  const xsd = (folder, file) => join(data, 'opendrive/xsd', folder, file);
  const is_valid = (schema, file) => run('xmllint', ['--noout', '--schema', schema, file]).status === 0;
  const valid = is_valid(xsd('1.7.0', 'opendrive_17_core.xsd'), xodr), valid_18 = is_valid(schema_18(xsd('1.8.1', '')), xodr18);
  const netconvert = sumo(xodr, net);
  const routes = JSON.parse(execFileSync(join(root, 'tools/sumo_routes'), [gpkg, xodr, net], { encoding: 'utf8' }));
  const findings = {};
  for (const f of JSON.parse(readFileSync(join(out, `${site}.findings.geojson`), 'utf8')).features)
    findings[f.properties.code] = (findings[f.properties.code] ?? 0) + 1;
  numbers[site] = { scores, valid, valid_18, netconvert, routes, findings, seconds: +(+user + +system).toFixed(2), memory_mb: Math.round(kilobytes / 1024),
    plan_deviation_m: +plan_m, elevation_error_m: +profile_m, round_trip_m: +round_trip_m, round_trip_points: +points,
    chain_km: +chain_km, chain_elements: +chain_elements, file_mb: +(statSync(xodr).size / 1e6).toFixed(1) };
  writeFileSync(store, JSON.stringify(numbers, null, 1) + '\n');
}

// ---- the tables of docs/network.md, between the marks
function table() {
  const sites = Object.keys(numbers), title = (s) => s[0].toUpperCase() + s.slice(1);
  const row = (name, asked, value) => `| ${name} | ${asked} | ${sites.map((s) => value(numbers[s])).join(' | ')} |`;
  const fixed = (value, digits) => (value === null || value === undefined || Number.isNaN(value) ? '-' : (+value).toFixed(digits));
  const tiny = (value) => (value < 1e-6 ? 'below 1e-6' : fixed(value, 6));
  const plain = (n) => n.scores.roads - n.scores.connecting_roads;
  const grades = (n) => Object.entries(n.netconvert.kinds).reduce((sum, [kind, count]) => sum + (/grade/i.test(kind) ? count : 0), 0);
  return [
    `| | asked | ${sites.map(title).join(' | ')} |`, `|---|---|${sites.map(() => '---').join('|')}|`,
    row('roads + connecting roads', '', (n) => `${plain(n)} + ${n.scores.connecting_roads}`),
    row('junctions', '', (n) => n.scores.junctions),
    row('length, connecting roads included, km', '', (n) => fixed(n.scores.length_m / 1000, 1)),
    row('elements: line / arc / spiral / paramPoly3', '', (n) => Object.values(n.scores.elements).length
      ? ['line', 'arc', 'spiral', 'paramPoly3'].map((kind) => n.scores.elements[kind]).join(' / ') : '-'),
    row('metres an element, roads outside junctions', '20', (n) => fixed(n.scores.mean_road_element_m, 2)),
    row('metres an element, whole chains before they are cut', '20', (n) => fixed(1000 * n.chain_km / n.chain_elements, 1)),
    row('largest distance of a node from the reference line, m', '0.10', (n) => fixed(n.plan_deviation_m, 3)),
    row('largest distance of a node from the profile, m', '', (n) => fixed(n.elevation_error_m, 3)),
    row('largest curvature jump outside junctions, 1/m', '0', (n) => tiny(n.scores.max_curvature_jump)),
    row('largest curvature rate outside junctions, 1/m2', 'bounded', (n) => fixed(n.scores.max_curvature_rate, 3)),
    row('largest heading jump, rad', '0', (n) => tiny(n.scores.max_heading_jump_rad)),
    row('largest gap between ends that meet, m', '', (n) => tiny(n.scores.max_joint_gap_m)),
    row('largest gradient kink', '0.001', (n) => tiny(n.scores.max_gradient_kink)),
    row('valid against the 1.7.0 / 1.8.1 schema', 'yes / yes', (n) => `${n.valid ? 'yes' : 'NO'} / ${n.valid_18 ? 'yes' : 'NO'}`),
    row('netconvert: errors', '0', (n) => n.netconvert.errors),
    row('netconvert: warnings about geometry or links', '0', (n) => n.netconvert.warnings - grades(n)),
    row('netconvert: warnings about grades (docs/heights.md)', '', (n) => grades(n)),
    row('routes of OSM that SUMO finds', '99 %', (n) => `${fixed(100 * n.routes.share, 1)} %`),
    row('the same without the U-turns netconvert adds', '', (n) => `${fixed(100 * n.routes.no_u_turns_share, 1)} %`),
    row('connected share of the length', '', (n) => `${fixed(100 * n.scores.connected_share, 1)} %`),
    row('links without an answer, lane link errors, dead lanes', '0, 0, 0',
      (n) => `${n.scores.broken_links}, ${n.scores.lane_link_errors}, ${n.scores.dead_lanes}`),
    row('narrowest driving lane where it is widest, m', '', (n) => fixed(n.scores.min_lane_width_m, 2)),
    row('crossings on two levels', '', (n) => n.scores.crossings),
    row('smallest clearance there, m', '4.7', (n) => fixed(n.scores.min_clearance_m, 2)),
    row('surface read back, largest difference, m', '0.001', (n) => n.round_trip_m.toExponential(1)),
    row('network stage with reading and writing, s of processor time', '', (n) => fixed(n.seconds, 1)),
    row('memory, MB', '', (n) => n.memory_mb),
    row('file, MB', '', (n) => n.file_mb),
  ].join('\n');
}

// Every crossing on two levels of every town, by clearance.
function crossings_table() {
  const end = (e) => `${e.highway}${e.osm_id ? `, way ${e.osm_id}` : ' (in a junction)'}`;
  const rows = Object.entries(numbers).flatMap(([site, n]) => n.scores.crossing_places.map((c) =>
    `| ${site} | ${Math.round(c.x)}, ${Math.round(c.y)} | ${end(c.upper)} | ${end(c.lower)} | ${c.clearance_m.toFixed(2)} |`));
  return ['| town | place (x, y), m | above | below | clearance, m |', '|---|---|---|---|---|', ...rows].join('\n');
}

function write_between(text, name, content) {
  const begin = `<!-- ${name} -->`, end = `<!-- /${name} -->`, a = text.indexOf(begin), b = text.indexOf(end);
  if (a < 0 || b < 0) throw new Error(`docs/network.md lacks the marks ${begin} ... ${end}`);
  return `${text.slice(0, a + begin.length)}\n${content}\n${text.slice(b)}`;
}

function write_page() {
  const page = join(root, 'docs/network.md');
  const text = write_between(readFileSync(page, 'utf8'), 'network_numbers', table());
  writeFileSync(page, write_between(text, 'network_crossings', crossings_table()));
}

if (!process.argv.includes('--table')) only.forEach(measure);
write_page();
