// SPDX-License-Identifier: Apache-2.0
// The roads of the site in the tool's own code, as WebAssembly (viewer/driving): loaded once, for who drives and who looks at lanes.

import wasmUrl from '../../build/driving/driving.wasm?url';

const roadsUrl = 'site/roads.xodr';
const chunkBytes = 1 << 20;

export interface Exports {
  memory: WebAssembly.Memory;
  _initialize(): void;
  allocate(bytes: number): number;
  add_elements(at: number, count: number): void;
  finish_roads(): void;
  make_strips(x_m: number, y_m: number, z_m: number): number;
  strips_at(): number;
  set_car(at: number, count: number): void;
  place(x_m: number, y_m: number, heading_rad: number, speed_mps: number, z_m: number): number;
  set_beside(z0_m: number, gradient_x: number, gradient_y: number): void;
  advance(elapsed_s: number, steering_rad: number, throttle: number, brake: number, gear: number): void;
}

/** Hands texts over in large pieces. */
class ElementWriter {
  private readonly start: number;
  private readonly encoder = new TextEncoder();
  private bytes: Uint8Array;
  private count = 0;

  constructor(private readonly module: Exports) {
    this.start = module.allocate(chunkBytes);
    this.bytes = new Uint8Array(module.memory.buffer, this.start, chunkBytes);
  }

  add(element: Element): void {
    let text = `S${element.tagName}\0`;
    for (const {name, value} of element.attributes) text += `${name}\0${value}\0`;
    this.write(`${text}\0`);
    for (const child of element.childNodes) {
      if (child instanceof Element) this.add(child);
      else if (
        child.nodeType === Node.CDATA_SECTION_NODE ||
        (child.nodeType === Node.TEXT_NODE && child.nodeValue!.trim() !== '')
      )
        this.write(`T${child.nodeValue}\0`);
    }
    this.write(`E${element.tagName}\0`);
  }

  flush(): void {
    this.module.add_elements(this.start, this.count);
    this.count = 0;
    this.bytes = new Uint8Array(this.module.memory.buffer, this.start, chunkBytes); // the memory may have grown
  }

  private write(text: string): void {
    if (this.count + 3 * text.length > chunkBytes) this.flush();
    const {read, written} = this.encoder.encodeInto(text, this.bytes.subarray(this.count));
    if (read < text.length) throw new Error('an element of the roads is longer than 1 MB');
    this.count += written;
  }
}

async function load(): Promise<Exports> {
  const [wasm, roads] = await Promise.all([fetch(wasmUrl), fetch(roadsUrl)]);
  for (const response of [wasm, roads])
    if (!response.ok)
      throw new Error(`${response.url}: the server answers ${response.status}, so the roads are not known`);
  const fail = (at: number, count: number) => {
    throw new Error(
      `The roads cannot be read: ${new TextDecoder().decode(new Uint8Array(module.memory.buffer, at, count))}`,
    );
  };
  const {instance} = await WebAssembly.instantiate(await wasm.arrayBuffer(), {page: {fail}});
  const module = instance.exports as unknown as Exports;
  module._initialize();
  const document = new DOMParser().parseFromString(await roads.text(), 'text/xml');
  if (document.querySelector('parsererror')) throw new Error('The roads cannot be read: roads.xodr is no XML');
  const writer = new ElementWriter(module);
  writer.add(document.documentElement);
  writer.flush();
  module.finish_roads();
  return module;
}

let loading: Promise<Exports> | undefined;

/** Throws what is wrong with the roads. */
export function roadsModule(): Promise<Exports> {
  loading ??= load();
  return loading;
}
