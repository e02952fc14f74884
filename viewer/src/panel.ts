// SPDX-License-Identifier: Apache-2.0
// The page around the picture: switches, dashboard, timeline.

import type {CarState, Lap} from './lap';
import {speedColor} from './layers/route_line';

function element<T extends HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

/** One of several, as a row of buttons. Returns a function that shows which one is chosen. */
export function segments<T extends string>(
  id: string,
  labels: Partial<Record<T, string>>,
  choose: (value: T) => void,
): (value: T) => void {
  const buttons = Object.entries<string>(labels as Record<string, string>).map(([value, label]) => {
    const button = document.createElement('button');
    button.type = 'button';
    button.textContent = label;
    button.dataset.value = value;
    button.onclick = () => choose(value as T);
    return button;
  });
  element(id).replaceChildren(...buttons);
  return (value) => buttons.forEach((button) => button.classList.toggle('on', button.dataset.value === value));
}

/** A labelled switch; returns its input. `color`: of the lines that it shows. */
export function addSwitch(
  name: string,
  label: string,
  on: boolean,
  change: (on: boolean) => void,
  color?: string,
): HTMLInputElement {
  const row = document.createElement('label');
  row.className = 'switch';
  if (color) row.style.setProperty('--color', color);
  const input = document.createElement('input');
  input.type = 'checkbox';
  input.name = name;
  input.checked = on;
  input.onchange = () => change(input.checked);
  row.append(label, input, document.createElement('i'));
  element('layers').append(row);
  return input;
}

export interface SunActions {
  setDay(date: string, hour: number): void;
}

/** Date and hour of the sun; returns a function that shows them. */
export function setUpSun(zoneHours: number, actions: SunActions): (date: string, hour: number) => void {
  const day = element<HTMLInputElement>('date'),
    clock = element<HTMLInputElement>('hour');
  day.onchange = clock.oninput = () => {
    if (day.value !== '') actions.setDay(day.value, Number(clock.value));
  };
  element('zone').textContent = `UTC${zoneHours < 0 ? '−' : '+'}${Math.abs(zoneHours)}`;
  return (date, hour) => {
    day.value = date;
    clock.value = String(hour);
    const minutes = Math.round(60 * hour);
    element('clock').textContent = `${Math.floor(minutes / 60)}:${String(minutes % 60).padStart(2, '0')}`;
  };
}

/** On narrow pages the panel opens and closes; `copy` puts the address of the view into the clipboard. */
export function setUpButtons(copy: () => Promise<void>): void {
  const fold = element('fold'),
    panel = element('panel');
  fold.onclick = () => fold.setAttribute('aria-expanded', String(panel.classList.toggle('open')));
  const link = element('link');
  link.onclick = async () => {
    await copy();
    link.textContent = 'Link copied';
    setTimeout(() => (link.textContent = 'Copy link'), 1500);
  };
}

export function showTexts(siteName: string, attribution: string[], keys: string): void {
  element('site-name').textContent = siteName;
  element('attribution').textContent = attribution.join(' · ');
  element('keys').textContent = keys;
  if (siteName) document.title = `${siteName} · Orthodrive`;
}

export function showMessage(text: string, isError: boolean): void {
  const box = element('message');
  box.textContent = text;
  box.classList.toggle('error', isError);
  box.hidden = text === '';
}

export function formatLapTime(t_s: number): string {
  const minutes = Math.floor(t_s / 60);
  return `${minutes}:${(t_s - 60 * minutes).toFixed(1).padStart(4, '0')}`;
}

export function showDashboard(car: CarState, originHeight_m: number): void {
  element('speed').textContent = (car.speed_mps * 3.6).toFixed(0);
  element('lap-time').textContent = formatLapTime(car.t_s);
  element('distance').textContent = `${car.s_m.toFixed(0)} m`;
  element('height').textContent = `${(car.z_m + originHeight_m).toFixed(1)} m`;
  const gradient = Math.abs(100 * car.gradient).toFixed(1);
  const sign = gradient === '0.0' ? '' : car.gradient > 0 ? '+' : '−';
  element('gradient').textContent = `${sign}${gradient} %`;
  element('lateral').textContent = `${Math.abs(car.a_lat_mps2 / 9.81).toFixed(2)} g`;
  const slider = element<HTMLInputElement>('time');
  slider.value = String(car.t_s);
  slider.style.setProperty('--share', String(car.t_s / Number(slider.max)));
}

export interface GhostActions {
  open(name: string, csv: string): void;
  remove(): void;
}

/** A second lap out of a file: chosen, or dropped on the page. */
export function setUpGhost(actions: GhostActions): void {
  element('ghost-line').hidden = false;
  const open = async (file: File | undefined) => {
    try {
      if (file) actions.open(file.name, await file.text());
    } catch (error) {
      showMessage((error as Error).message, true);
    }
  };
  const input = element<HTMLInputElement>('ghost-file');
  input.onchange = async () => {
    await open(input.files?.[0]);
    input.value = ''; // the same file may be chosen again
  };
  element('ghost-remove').onclick = () => actions.remove();
  window.addEventListener('dragover', (event) => event.preventDefault());
  window.addEventListener('drop', (event) => {
    event.preventDefault();
    void open(event.dataTransfer?.files[0]);
  });
}

/** Empty: there is no other lap. */
export function showGhostName(name: string): void {
  element('ghost-name').textContent = name || 'Open another lap (CSV)';
  element('ghost-remove').hidden = name === '';
}

/** Positive: the car passed here later than the ghost. */
export function showGap(hasGhost: boolean, gap_s: number | undefined): void {
  element('gap-row').hidden = !hasGhost;
  const sign = gap_s === undefined ? '' : gap_s < 0 ? '−' : '+';
  element('gap').textContent = gap_s === undefined ? '–' : `${sign}${Math.abs(gap_s).toFixed(2)} s`;
}

export interface TimelineActions {
  seek(t_s: number): void;
  togglePlay(): void;
  setRate(rate: number): void;
}

export function setUpTimeline(lap: Lap, actions: TimelineActions): void {
  element('hud').hidden = element('timeline').hidden = false;
  const slider = element<HTMLInputElement>('time');
  slider.max = String(lap.duration_s);
  slider.oninput = () => actions.seek(Number(slider.value));
  element('play').onclick = () => actions.togglePlay();
  const rate = element<HTMLSelectElement>('rate');
  for (const factor of [0.25, 0.5, 1, 2, 5, 10])
    rate.add(new Option(`${factor}×`, String(factor), factor === 1, factor === 1));
  rate.onchange = () => actions.setRate(Number(rate.value));
  drawSpeedProfile(lap);
}

export function setUpDriving(toggle: () => void): void {
  const button = element('drive');
  button.hidden = false;
  button.onclick = () => {
    button.blur(); // the keys are the car's
    toggle();
  };
}

export function showDriving(driving: boolean): void {
  element('drive').textContent = driving ? 'Back to the lap' : 'Drive it yourself';
  element('drive').classList.toggle('on', driving);
  element('pads').hidden = !driving;
}

export function showPlaying(playing: boolean): void {
  element('play').classList.toggle('playing', playing);
}

/** Speed over time behind the slider. */
function drawSpeedProfile(lap: Lap): void {
  const canvas = element<HTMLCanvasElement>('profile');
  const columns = 600,
    height = 48;
  [canvas.width, canvas.height] = [columns, height];
  const states = lap.sampled(lap.duration_s / columns);
  const top_mps = Math.max(...states.map((state) => state.speed_mps));
  const context = canvas.getContext('2d')!;
  states.forEach((state, i) => {
    const share = state.speed_mps / top_mps;
    context.fillStyle = `#${speedColor(share).getHexString()}`;
    const bar = Math.max(1, share * height);
    context.fillRect((i * columns) / states.length, height - bar, columns / states.length + 0.5, bar);
  });
}
