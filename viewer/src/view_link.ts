// SPDX-License-Identifier: Apache-2.0
// The address of a view: what the page shows as text after the '?', and back.

import {type CameraMode, cameraModes, type View} from './cameras';

export interface ViewState {
  camera: CameraMode;
  view?: View; // of the cameras that the mouse moves
  t_s: number;
  date: string; // YYYY-MM-DD
  hour: number;
  off: string[]; // layers that are usually on
  on: string[]; // layers that are usually off
  ghost?: string; // another lap: a CSV file below the site's folder
}

/** Summer, in the afternoon: the sun stands in the south-west at about 45 degrees in Europe. */
export const usualDay = {date: '2026-06-21', hour: 15};

const numbers = (text: string | null) => (text ?? '').split(',').map(Number);
const names = (text: string | null) => (text ?? '').split(',').filter((name) => name !== '');

/** What is missing or no number keeps its usual value. */
export function parseView(search: string): ViewState {
  const parameters = new URLSearchParams(search);
  const number = (name: string, usual: number) => {
    const text = parameters.get(name);
    return text !== null && text !== '' && Number.isFinite(Number(text)) ? Number(text) : usual;
  };
  const camera = parameters.get('camera') as CameraMode;
  const date = parameters.get('date') ?? '';
  const six = [...numbers(parameters.get('eye')), ...numbers(parameters.get('target'))];
  const hasView = six.length === 6 && six.every(Number.isFinite) && parameters.has('eye');
  return {
    camera: cameraModes.includes(camera) ? camera : 'fly',
    view: hasView ? {eye: [six[0], six[1], six[2]], target: [six[3], six[4], six[5]]} : undefined,
    t_s: number('t', 0),
    date: /^\d{4}-\d\d-\d\d$/.test(date) && !Number.isNaN(Date.parse(date)) ? date : usualDay.date,
    hour: Math.min(24, Math.max(0, number('hour', usualDay.hour))),
    off: names(parameters.get('off')),
    on: names(parameters.get('on')),
    ghost: parameters.get('ghost') || undefined,
  };
}

export function writeView(state: ViewState): string {
  const parameters = new URLSearchParams({camera: state.camera, t: state.t_s.toFixed(2), play: '0'});
  const place = (at: number[]) => at.map((v) => v.toFixed(2)).join(',');
  if (state.view) {
    parameters.set('eye', place(state.view.eye));
    parameters.set('target', place(state.view.target));
  }
  if (state.date !== usualDay.date) parameters.set('date', state.date);
  if (state.hour !== usualDay.hour) parameters.set('hour', String(state.hour));
  if (state.off.length > 0) parameters.set('off', state.off.join(','));
  if (state.on.length > 0) parameters.set('on', state.on.join(','));
  if (state.ghost) parameters.set('ghost', state.ghost);
  return `?${parameters.toString().replaceAll('%2C', ',').replaceAll('%2F', '/')}`;
}
