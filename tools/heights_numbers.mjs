#!/usr/bin/env node
// Measures heights: all methods and samplings of `orthodrive elevate` on Kvarnbyn and on synthetic sites, for the tables and
// pictures of docs/heights.md, which it writes. Some minutes on two cores.
// Usage: tools/heights_numbers.mjs [--only kvarnbyn,village,circuit,junction,speed] [--out FOLDER] [--sites FOLDER] [--refined FILE]
//        [--tool PROGRAM] [--table]   (--table: write the page from what was measured before)
// --sites: synthetic sites village-99, circuit, junction as `orthodrive synth` makes them (made when they lack); --refined: Kvarnbyn's
// refined roads (tools/refinement_numbers.mjs leaves them in out/refinement/roads). Synthetic roads are the true lines, so that heights
// alone are measured; their true banking goes with them, as a measured one would. Needs python3 to read GeoPackages.
// What is not measured in this run keeps its last values from bench/results/heights.json.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { cpus } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const root = join(dirname(fileURLToPath(import.meta.url)), '..');
const argument = (name, fallback) => {
  const at = process.argv.indexOf(name);
  return at < 0 ? fallback : process.argv[at + 1];
};
const tool = argument('--tool', join(root, 'build/release/orthodrive'));
const out = argument('--out', join(root, 'out/heights'));
const sites = argument('--sites', join(root, 'out/synth'));
const refined = argument('--refined', join(root, 'out/refinement/roads/kvarnbyn drawn.default.gpkg'));
const only = argument('--only', 'kvarnbyn,village,circuit,junction,speed').split(',');
const data = join(root, '../shared/data');
const store = join(root, 'bench/results/heights.json');
const numbers = existsSync(store) ? JSON.parse(readFileSync(store, 'utf8')) : { rows: {}, profiles: {} };
mkdirSync(out, { recursive: true });

const orthodrive = (...args) => execFileSync(tool, ['--quiet', ...args], { encoding: 'utf8', maxBuffer: 1 << 26, stdio: ['ignore', 'pipe', 'inherit'] });
const git = (...args) => execFileSync('git', ['-C', root, ...args], { encoding: 'utf8' }).trim();
const commit = git('rev-parse', '--short', 'HEAD') + (git('status', '--porcelain', '--untracked-files=no', '--', '.', ':!bench/results', ':!docs') ? ' + changes' : '');
const save = () => writeFileSync(store, JSON.stringify(numbers, null, 1) + '\n');

const methods = {
  none: ['none', ['--method', 'moving-average', '--window', '1']],
  ma11: ['moving avg. (11)', ['--method', 'moving-average', '--window', '11']],
  ma35: ['moving avg. (35)', ['--method', 'moving-average', '--window', '35']],
  ma67: ['moving avg. (67)', ['--method', 'moving-average', '--window', '67']],
  reference: ['NLO', ['--method', 'reference']],
  default: ['**default**', ['--method', 'default']],
};
const samplings = ['bilinear', 'cubic'];

// Distance, height and gradient of the nodes of one way.
const nodes_of = (file, osm_id) => JSON.parse(execFileSync('python3', ['-c', `
import json, sqlite3, sys
rows = sqlite3.connect(sys.argv[1]).execute('select s_m, z_m, gradient from nodes where osm_id = ? and part = 0 order by fid', (int(sys.argv[2]),)).fetchall()
print(json.dumps([[round(v, 4) for v in row] for row in rows]))`, file, String(osm_id)], { encoding: 'utf8', maxBuffer: 1 << 26 }));
const longest_way = (file) => +execFileSync('python3', ['-c', `
import sqlite3, sys
print(sqlite3.connect(sys.argv[1]).execute('select osm_id from nodes where part = 0 group by osm_id order by max(s_m) desc, osm_id').fetchone()[0])`, file], { encoding: 'utf8' });

// Where Kvarnbyn's terrain shows a bridge that the map has no tag for (findings elevate.assumed_bridge): decks are not in the
// 2 m grid either, so 45 m around them are left out of the comparison, as bridges are.
const untagged_bridges = [[12.0341532, 57.6570488], [12.0259758, 57.6592385]];
function bridge_polygons() {
  const file = join(out, 'kvarnbyn_bridges.geojson'), lat_m = 111320;
  const ring = ([lon, lat]) => Array.from({ length: 17 }, (_, i) => [lon + (45 * Math.cos((i % 16) * Math.PI / 8)) / (lat_m * Math.cos(lat * Math.PI / 180)), lat + (45 * Math.sin((i % 16) * Math.PI / 8)) / lat_m]);
  writeFileSync(file, JSON.stringify({ type: 'FeatureCollection', features: untagged_bridges.map((p) => ({ type: 'Feature', properties: {}, geometry: { type: 'Polygon', coordinates: [ring(p)] } })) }));
  return file;
}

function measure(name, roads, dtm, truths, way, ignore) {
  for (const sampling of samplings)
    for (const [method, [, options]] of Object.entries(methods)) {
      const file = join(out, `${name}.${sampling}.${method}.gpkg`.replaceAll(' ', '_'));
      const start = Date.now();
      orthodrive('elevate', '--roads', roads, '--dtm', dtm, '--sampling', sampling, ...options, '-o', file);
      const row = { name, sampling, method, seconds: (Date.now() - start) / 1000, commit, cores: cpus().length };
      for (const [kind, truth] of Object.entries(truths)) row[kind] = JSON.parse(orthodrive('evaluate', 'heights', file, truth, ...(ignore ? ['--ignore', ignore] : []), '--json'));
      numbers.rows[`${name} ${sampling} ${method}`] = row;
      if (way && sampling === 'bilinear' && ['none', 'ma35', 'reference', 'default'].includes(method)) (numbers.profiles[name] ??= { way })[method] = nodes_of(file, way);
      const t = row.truth;
      console.log(`${name} ${sampling} ${method}: E_RG ${(1e4 * t.gradient_energy).toFixed(2)} E_h ${t.height_error_energy.toFixed(4)} z ${t.z_m.mean_abs.toFixed(3)} / ${t.z_m.p95.toFixed(3)}`
        + ` kink ${t.largest_kink.size.toExponential(1)} ${t.largest_junction_kink.size.toExponential(1)} sigma ${t.sigma_coverage['1']} clearance ${t.min_clearance_m} ${row.seconds.toFixed(1)} s`);
      save();
    }
}

if (!process.argv.includes('--table')) {
  if (only.includes('kvarnbyn')) {
    const dtm = join(data, 'kvarnbyn/dtm_10m_utm33.tif');
    measure('kvarnbyn 10 m', refined, dtm, { dtm, truth: join(data, 'kvarnbyn/dtm_2m_west.tif') }, longest_way(refined), bridge_polygons());
  }
  const synthetic = { village: ['village-99', '--preset', 'village', '--seed', '99'], circuit: ['circuit', '--preset', 'circuit'], junction: ['junction', '--preset', 'junction'] };
  for (const [name, [folder, ...options]] of Object.entries(synthetic)) {
    if (!only.includes(name)) continue;
    const site = join(sites, folder), truth = join(site, 'truth/roads.gpkg');
    if (!existsSync(truth)) orthodrive('synth', ...options, '-o', site);
    const way = longest_way(truth);
    for (const grid of ['10 m', '1 m']) {
      const dtm = join(site, `dtm_${grid.replace(' ', '')}.tif`);
      measure(`${name} ${grid}`, truth, dtm, { dtm, truth }, grid === '10 m' ? way : 0);
    }
    numbers.profiles[`${name} 10 m`].truth = nodes_of(truth, way);
    save();
  }
  if (only.includes('speed')) {
    const lines = execFileSync(join(root, 'build/release/bench/speed/bench_heights'), { encoding: 'utf8' }).trim().split('\n');
    numbers.speed = { commit, cores: cpus().length, lines };
    save();
  }
}

// ---- pictures, as the reference's figures 3.9 and 3.10
const colors = { none: '#8a8f98', ma11: '#c7a008', ma35: '#d9820f', ma67: '#b34a1f', reference: '#2f6fde', default: '#0f9d58', truth: '#111111' };
const titles = { none: 'terrain as sampled', ma11: 'moving average (11)', ma35: 'moving average (35)', ma67: 'moving average (67)', reference: 'NLO (reference)', default: 'default', truth: 'true road' };
const ticks = (low, high, count) => {
  const raw = (high - low) / count || 1, power = 10 ** Math.floor(Math.log10(raw)), step = power * [1, 2, 5, 10].find((m) => m * power >= raw);
  const all = [];
  for (let v = Math.ceil(low / step - 1e-9) * step; v <= high + 1e-9 * step; v += step) all.push(+v.toPrecision(12));
  return all;
};
function plot({ x, y, w, h, x_range, y_range, x_label, y_label, body }) {
  const px = (v) => x + ((v - x_range[0]) / (x_range[1] - x_range[0])) * w, py = (v) => y + h - ((v - y_range[0]) / (y_range[1] - y_range[0])) * h;
  let svg = `<rect x="${x}" y="${y}" width="${w}" height="${h}" fill="none" stroke="#999"/>`;
  for (const v of ticks(...x_range, 6)) svg += `<path d="M${px(v).toFixed(1)} ${y + h}v4" stroke="#999"/><text x="${px(v).toFixed(1)}" y="${y + h + 16}" text-anchor="middle">${v}</text>`;
  for (const v of ticks(...y_range, 5)) svg += `<path d="M${x - 4} ${py(v).toFixed(1)}h${w + 4}" stroke="#ddd"/><text x="${x - 7}" y="${(py(v) + 4).toFixed(1)}" text-anchor="end">${v}</text>`;
  svg += `<text x="${x + w / 2}" y="${y + h + 33}" text-anchor="middle">${x_label}</text><text transform="translate(${x - 48} ${y + h / 2}) rotate(-90)" text-anchor="middle">${y_label}</text>`;
  return svg + body(px, py);
}
const page_svg = (w, h, body) => `<svg xmlns="http://www.w3.org/2000/svg" width="${w}" height="${h}" viewBox="0 0 ${w} ${h}" font-family="sans-serif" font-size="12"><rect width="100%" height="100%" fill="white"/>${body}</svg>\n`;
const range = (values, share = 0.06) => {
  const low = Math.min(...values), high = Math.max(...values), more = (high - low || 1) * share;
  return [low - more, high + more];
};
const row = (name, sampling, method) => numbers.rows[`${name} ${sampling} ${method}`];

// E_RG against E_h to the truth, a panel a site (10 m grid), bilinear as rings and cubic as discs.
function energies() {
  const sites_shown = ['kvarnbyn 10 m', 'village 10 m', 'circuit 10 m', 'junction 10 m'].filter((name) => row(name, 'cubic', 'default'));
  let body = '';
  sites_shown.forEach((name, i) => {
    const points = samplings.flatMap((sampling) => Object.keys(methods).map((method) => ({ sampling, method, r: row(name, sampling, method) }))).filter((p) => p.r);
    const xs = points.map((p) => 1e4 * p.r.truth.gradient_energy), ys = points.map((p) => p.r.truth.height_error_energy);
    const truth = 1e4 * points[0].r.truth.true_gradient_energy;
    body += `<text x="${70 + (i % 2) * 440}" y="${24 + Math.floor(i / 2) * 330}" font-weight="bold">${name.replace(' 10 m', '')}, 10 m grid</text>`
      + plot({ x: 70 + (i % 2) * 440, y: 34 + Math.floor(i / 2) * 330, w: 340, h: 230, x_range: range([...xs, truth]), y_range: [0, 1.08 * Math.max(...ys)], x_label: 'E_RG, 1e-4 (dashed: of the truth)', y_label: 'E_h against the truth, m2',
        body: (px, py) => `<path d="M${px(truth).toFixed(1)} ${py(0).toFixed(1)}V${py(1.08 * Math.max(...ys)).toFixed(1)}" stroke="#111" stroke-dasharray="4 3"/>`
          + points.map((p, k) => `<circle cx="${px(xs[k]).toFixed(1)}" cy="${py(ys[k]).toFixed(1)}" r="5" stroke="${colors[p.method]}" stroke-width="2" fill="${p.sampling === 'cubic' ? colors[p.method] : 'white'}"/>`).join('') });
  });
  const legend = Object.keys(methods).map((m, k) => `<circle cx="${70 + k * 140}" cy="690" r="5" fill="${colors[m]}"/><text x="${80 + k * 140}" y="694">${titles[m]}</text>`).join('');
  return page_svg(900, 710, body + legend);
}
// Height and gradient over the distance along one way.
function profile(name) {
  const p = numbers.profiles[name], kinds = ['none', 'ma35', 'reference', 'default', 'truth'].filter((k) => p[k]);
  const line = (kind, column, px, py) => `<polyline fill="none" stroke="${colors[kind]}" stroke-width="${kind === 'truth' ? 1 : 1.6}"${kind === 'truth' ? ' stroke-dasharray="5 3"' : ''} points="${p[kind].map((v) => `${px(v[0]).toFixed(1)},${py(column === 2 ? 100 * v[2] : v[column]).toFixed(1)}`).join(' ')}"/>`;
  const all = kinds.flatMap((k) => p[k]), length = Math.max(...all.map((v) => v[0]));
  const steep = range(kinds.filter((k) => k !== 'none').flatMap((k) => p[k].map((v) => 100 * v[2])), 0.3);
  const body = `<text x="70" y="22" font-weight="bold">${name}: way ${p.way}, bilinear sampling</text>`
    + plot({ x: 70, y: 34, w: 800, h: 220, x_range: [0, length], y_range: range(all.map((v) => v[1])), x_label: '', y_label: 'height, m', body: (px, py) => kinds.map((k) => line(k, 1, px, py)).join('') })
    + `<clipPath id="c"><rect x="70" y="300" width="800" height="220"/></clipPath>`
    + plot({ x: 70, y: 300, w: 800, h: 220, x_range: [0, length], y_range: steep, x_label: 'distance along the way, m', y_label: 'gradient, %', body: (px, py) => `<g clip-path="url(#c)">${kinds.map((k) => line(k, 2, px, py)).join('')}</g>` })
    + kinds.map((k, i) => `<path d="M${70 + i * 160} 572h24" stroke="${colors[k]}" stroke-width="2"/><text x="${100 + i * 160}" y="576">${titles[k]}</text>`).join('');
  return page_svg(900, 590, body);
}
const images = join(root, 'docs/images');
const pictures = [];
if (Object.keys(numbers.rows).length) writeFileSync(join(images, 'heights_energies.svg'), energies());
for (const name of Object.keys(numbers.profiles)) {
  const file = `heights_profile_${name.split(' ')[0]}.svg`;
  writeFileSync(join(images, file), profile(name));
  pictures.push(`![Height and gradient along a way of ${name.split(' ')[0]}](images/${file})\n`);
}

// ---- the page: tables between the markers of docs/heights.md
const header = (cells) => `| ${cells.join(' | ')} |\n|${cells.map(() => '---').join('|')}|\n`;
const fixed = (x, digits) => (x === null || x === undefined ? '-' : x.toFixed(digits));
const percent = (x, digits = 1) => (x === null || x === undefined ? '-' : (100 * x).toFixed(digits));
function table(name) {
  return header(['sampling', 'smoothing', 'E_RG 1e-4', 'E_h to the DTM m2', 'E_h to the truth m2', 'squared error of the gradient 1e-4', 'z bias / mean / p95 m', 'gradient mean / p95 %', 'largest kink along, at junctions %', 'within 1 / 2 sigma %', 's'])
    + samplings.flatMap((sampling) => Object.keys(methods).map((method) => row(name, sampling, method)).filter(Boolean)).map((r) => {
      const t = r.truth, sigma = t.sigma_coverage['1'] === null ? '-' : `${percent(t.sigma_coverage['1'], 0)} / ${percent(t.sigma_coverage['2'], 0)}`;
      return `| ${r.sampling} | ${methods[r.method][0]} | ${fixed(1e4 * t.gradient_energy, 2)} | ${fixed(r.dtm.height_error_energy, 4)} | ${fixed(t.height_error_energy, 4)} | ${fixed(1e4 * t.gradient_error_energy, 3)}`
        + ` | ${fixed(t.z_m.bias, 3)} / ${fixed(t.z_m.mean_abs, 3)} / ${fixed(t.z_m.p95, 3)} | ${percent(t.gradient.mean_abs, 2)} / ${percent(t.gradient.p95, 2)} | ${percent(t.largest_kink.size, 3)}, ${percent(t.largest_junction_kink.size, 3)} | ${sigma} | ${r.seconds.toFixed(1)} |\n`;
    }).join('');
}
function summary() {
  const lines = [];
  const add = (what, asked, value, good) => lines.push(`| ${what} | ${asked} | ${value}${good ? '' : ' **missed**'} |\n`);
  for (const name of ['kvarnbyn 10 m', 'village 10 m', 'circuit 10 m', 'junction 10 m'])
    for (const sampling of samplings) {
      const d = row(name, sampling, 'default')?.truth, n = row(name, sampling, 'reference')?.truth, averages = ['ma11', 'ma35', 'ma67'].map((m) => row(name, sampling, m)?.truth);
      if (!d || !n || averages.some((a) => !a)) continue;
      const truth = d.true_gradient_energy;
      for (const [what, value, scale, digits] of [
        ['E_RG', (r) => r.gradient_energy, 1e4, 2], ['distance of E_RG to that of the truth', (r) => Math.abs(r.gradient_energy - truth), 1e4, 2],
        ['squared error of the gradient', (r) => r.gradient_error_energy, 1e4, 3], ['E_h to the truth', (r) => r.height_error_energy, 1, 4]]) {
        const best = Math.min(...averages.map(value)), shown = (r) => fixed(scale * value(r), digits);
        add(`${name}, ${sampling}: ${what}, NLO below every moving average`, `< ${fixed(scale * best, digits)}`, shown(n), value(n) < best);
        if (what !== 'E_RG') add(`${name}, ${sampling}: ${what}, default below NLO`, `< ${shown(n)}`, shown(d), value(d) < value(n));
      }
    }
  const k = row('kvarnbyn 10 m', 'cubic', 'default')?.truth, v = row('village 1 m', 'cubic', 'default')?.truth;
  if (k) add('Kvarnbyn, 10 m grid against the 2 m grid, bridges left out: z mean, p95', '<= 0.30, 1.0 m', `${fixed(k.z_m.mean_abs, 3)}, ${fixed(k.z_m.p95, 3)} m`, k.z_m.mean_abs <= 0.3 && k.z_m.p95 <= 1);
  if (v) add('village, 1 m grid: z mean', '<= 0.05 m', `${fixed(v.z_m.mean_abs, 3)} m`, v.z_m.mean_abs <= 0.05);
  for (const r of Object.values(numbers.rows)) {
    if (r.method !== 'default' || r.sampling !== 'cubic') continue;
    const t = r.truth;
    add(`${r.name}: largest jump of the gradient along roads, at junctions; step`, '<= 0.1 %, 1 mm', `${percent(t.largest_kink.size, 3)}, ${percent(t.largest_junction_kink.size, 4)} %; ${fixed(1000 * t.largest_step_m.size, 3)} mm`, t.largest_kink.size <= 1e-3 && t.largest_junction_kink.size <= 1e-3 && t.largest_step_m.size <= 1e-3);
    if (t.crossings) add(`${r.name}: least clearance at ${t.crossings} crossings of two levels`, '>= 4.7 m', `${fixed(t.min_clearance_m, 2)} m`, t.min_clearance_m >= 4.7);
    add(`${r.name}: heights within one sigma`, 'about 68 %', `${percent(t.sigma_coverage['1'], 0)} %`, t.sigma_coverage['1'] > 0.55 && t.sigma_coverage['1'] < 0.8);
  }
  const large = numbers.speed?.lines.at(-1)?.match(/^([\d.]+) km.*elevate ([\d.]+) s \(([\d.]+) s CPU\).*network ([\d.]+) s \(([\d.]+) s CPU\).*peak ([\d.]+) GB/);
  if (large) add(`${large[1]} km of road: heights and network`, '<= 60 s, 2 GB', `${large[2]} s and ${large[4]} s (processor: ${large[3]} s and ${large[5]} s), ${large[6]} GB`, +large[3] + +large[5] <= 60 && +large[6] <= 2);
  return header(['number', 'asked', 'reached']) + lines.join('');
}
const page = join(root, 'docs/heights.md');
const commits = [...new Set(Object.values(numbers.rows).map((r) => r.commit))].join(', ');
let text = `Written by \`tools/heights_numbers.mjs\` from \`bench/results/heights.json\` (measured on ${commits}; two shared cores).\n\n### Asked and reached\n\n${summary()}`;
for (const name of ['kvarnbyn 10 m', 'village 10 m', 'village 1 m', 'circuit 10 m', 'circuit 1 m', 'junction 10 m', 'junction 1 m'])
  if (row(name, 'cubic', 'default')) text += `\n### ${name[0].toUpperCase()}${name.slice(1)} grid\n\n${table(name)}`;
if (numbers.speed) text += `\n### Cost against road length (${numbers.speed.commit}, \`bench_heights\`)\n\n${numbers.speed.lines.map((l) => `    ${l}\n`).join('')}`;
text += `\n### Pictures\n\n![E_RG against E_h of all methods](images/heights_energies.svg)\n\n${pictures.join('\n')}`;
const [before, after] = ['<!-- numbers -->', '<!-- end of numbers -->'];
const old = readFileSync(page, 'utf8');
writeFileSync(page, `${old.slice(0, old.indexOf(before) + before.length)}\n\n${text}\n${old.slice(old.indexOf(after))}`);
