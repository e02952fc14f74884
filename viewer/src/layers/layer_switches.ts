// SPDX-License-Identifier: Apache-2.0
// The switches of the page: what is shown, and what is usually shown.

import * as panel from '../panel';

export type LayerName =
  | 'photo'
  | 'labels'
  | 'normals'
  | 'materials'
  | 'terrain'
  | 'roads'
  | 'buildings'
  | 'trees'
  | 'shadows'
  | 'wireframe'
  | 'lanes'
  | 'map-roads'
  | 'refined-roads'
  | 'error-bars'
  | 'route'
  | 'ghost'
  | 'findings';

interface Layer {
  usual: boolean;
  input: HTMLInputElement;
  apply(on: boolean): void;
}

export class LayerSwitches {
  onChange: () => void = () => {};
  private readonly layers = new Map<LayerName, Layer>();

  /** Names of layers as an address wants them; those that the site does not have are let through. */
  constructor(private readonly wanted: {on: string[]; off: string[]}) {}

  /** `color`: of its lines, as CSS has it. */
  add(name: LayerName, label: string, usual: boolean, apply: (on: boolean) => void, color?: string): void {
    const input = panel.addSwitch(name, label, usual, (on) => this.set(name, on), color);
    this.layers.set(name, {usual, input, apply});
    if (this.wanted.off.includes(name)) this.set(name, false);
    if (this.wanted.on.includes(name)) this.set(name, true);
  }

  /** Names of what the site does not have are let through: an address may be of another site. */
  set(name: string, on: boolean): void {
    const layer = this.layers.get(name as LayerName);
    if (!layer) return;
    layer.input.checked = on;
    layer.apply(on);
    this.onChange();
  }

  get shown(): Record<string, boolean> {
    return Object.fromEntries([...this.layers].map(([name, {input}]) => [name, input.checked]));
  }
  /** Those that are shown, or not, though usually it is the other way round. */
  changedTo(on: boolean): string[] {
    return [...this.layers].filter(([, {usual, input}]) => usual !== on && input.checked === on).map(([name]) => name);
  }
}
