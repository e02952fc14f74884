// SPDX-License-Identifier: Apache-2.0
// A layer whose data are fetched when it is shown for the first time.

import {Group, type Object3D} from 'three';

import * as panel from '../panel';

export class LateLayer {
  readonly object = new Group();
  onChange: () => void = () => {};
  private loading?: Promise<void>;
  private isPending = false;

  /** `load` throws what is wrong; its text is shown. */
  constructor(private readonly load: () => Promise<Object3D>) {
    this.object.visible = false;
  }

  /** Data that are wanted are on their way. */
  get pending(): boolean {
    return this.isPending && this.object.visible;
  }

  set visible(on: boolean) {
    this.object.visible = on;
    if (on) this.loading ??= this.fetch();
  }

  private async fetch(): Promise<void> {
    this.isPending = true;
    try {
      this.object.add(await this.load());
    } catch (error) {
      panel.showMessage((error as Error).message, true);
    }
    this.isPending = false;
    this.onChange();
  }
}
