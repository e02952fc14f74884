// SPDX-License-Identifier: Apache-2.0
// The driven lap: rows of lap.csv and the state between them.

/** State of the car; x east, y north, z up in metres from the site's origin; angles in radians. */
export interface CarState {
  t_s: number;
  s_m: number;
  x_m: number;
  y_m: number;
  z_m: number;
  heading_rad: number; // counter-clockwise from east
  pitch_rad: number;
  roll_rad: number;
  speed_mps: number;
  a_lat_mps2: number;
  gradient: number;
  a_lon_mps2?: number;
  throttle?: number; // 0 to 1
  brake?: number; // 0 to 1
  gear?: number;
  engine_rpm?: number;
  steering_rad?: number; // of the front wheels, positive to the left
  z_fl_m?: number; // the road under each wheel
  z_fr_m?: number;
  z_rl_m?: number;
  z_rr_m?: number;
  load_fl_n?: number; // of each tyre
  load_fr_n?: number;
  load_rl_n?: number;
  load_rr_n?: number;
}
type Column = keyof CarState;

const neededColumns = [
  't_s',
  's_m',
  'x_m',
  'y_m',
  'z_m',
  'heading_rad',
  'pitch_rad',
  'roll_rad',
  'speed_mps',
  'a_lat_mps2',
  'gradient',
] as const satisfies readonly Column[];
const furtherColumns = [
  'a_lon_mps2',
  'throttle',
  'brake',
  'gear',
  'engine_rpm',
  'steering_rad',
  'z_fl_m',
  'z_fr_m',
  'z_rl_m',
  'z_rr_m',
  'load_fl_n',
  'load_fr_n',
  'load_rl_n',
  'load_rr_n',
] as const satisfies readonly Column[];
const stepped: readonly Column[] = ['gear'];
const heights: readonly Column[] = ['z_m', 'z_fl_m', 'z_fr_m', 'z_rl_m', 'z_rr_m'];

export class Lap {
  private readonly names: Column[];

  private constructor(
    private readonly columns: Map<Column, Float64Array>,
    readonly originHeight_m: number,
  ) {
    this.names = [...columns.keys()];
  }

  /** Subtracts the site's origin, so that positions fit the scene. `file`: its name, for complaints. */
  static parse(csv: string, origin: readonly [number, number, number], file: string): Lap {
    const lines = csv.split('\n').filter((line) => line.trim() !== '');
    const header = (lines[0] ?? '').split(',').map((name) => name.trim());
    for (const name of neededColumns) if (!header.includes(name)) throw new Error(`${file} has no column ${name}`);
    const count = lines.length - 1;
    if (count < 2) throw new Error(`${file} has fewer than two rows`);
    const columns = new Map<Column, Float64Array>();
    for (const name of [...neededColumns, ...furtherColumns])
      if (header.includes(name)) columns.set(name, new Float64Array(count));
    // Half of the fields are not wanted: 10 km have a million of them.
    const wanted = header.map((name) => columns.get(name as Column));
    for (let row = 0; row < count; ++row) {
      const line = lines[row + 1];
      let at = 0;
      for (const column of wanted) {
        const comma = line.indexOf(',', at),
          end = comma < 0 ? line.length : comma;
        if (column) column[row] = at <= line.length ? Number(line.slice(at, end)) : NaN;
        at = end + 1;
      }
    }
    for (const name of neededColumns)
      if (!columns.get(name)!.every(Number.isFinite))
        throw new Error(`${file} has something else than numbers in the column ${name}`);
    if (!(columns.get('t_s')![count - 1] > columns.get('t_s')![0])) throw new Error(`${file} ends before it begins`);
    const subtract = (name: Column, by: number) =>
      columns.get(name)?.forEach((value, i, column) => (column[i] = value - by));
    subtract('x_m', origin[0]);
    subtract('y_m', origin[1]);
    for (const name of heights) subtract(name, origin[2]);
    return new Lap(columns, origin[2]);
  }

  private get times(): Float64Array {
    return this.columns.get('t_s')!;
  }
  get start_s(): number {
    return this.times[0];
  }
  get duration_s(): number {
    return this.times[this.times.length - 1] - this.start_s;
  }

  /** Linear between rows; after the end the lap begins anew. */
  at(t_s: number): CarState {
    const {times} = this;
    const elapsed = ((t_s % this.duration_s) + this.duration_s) % this.duration_s;
    const t = this.start_s + elapsed;
    let low = 0,
      high = times.length - 1; // times[low] <= t < times[high]
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= t) low = middle;
      else high = middle;
    }
    const share = (t - times[low]) / (times[high] - times[low]);
    const state = {} as CarState;
    for (const name of this.names) {
      const column = this.columns.get(name)!;
      const a = column[low],
        b = stepped.includes(name) ? a : column[high];
      const step = name === 'heading_rad' ? Math.atan2(Math.sin(b - a), Math.cos(b - a)) : b - a;
      state[name] = a + share * step;
    }
    state.t_s = elapsed;
    return state;
  }

  get length_m(): number {
    const s = this.columns.get('s_m')!;
    return s[s.length - 1] - s[0];
  }
  /** How much of the way is driven, 0 to 1. */
  shareOf(car: CarState): number {
    return (car.s_m - this.columns.get('s_m')![0]) / this.length_m;
  }

  /** States about `step_s` apart over the whole lap, for lines and plots. */
  sampled(step_s: number): CarState[] {
    const count = Math.max(2, Math.ceil(this.duration_s / step_s));
    return Array.from({length: count}, (_, i) => this.at((i / count) * this.duration_s));
  }
}
