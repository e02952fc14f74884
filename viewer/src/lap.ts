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
}

const columnNames = [
  't_s', 's_m', 'x_m', 'y_m', 'z_m', 'heading_rad', 'pitch_rad', 'roll_rad', 'speed_mps', 'a_lat_mps2', 'gradient',
] as const satisfies readonly (keyof CarState)[];
type Columns = Record<keyof CarState, Float64Array>;

export class Lap {
  private constructor(private readonly columns: Columns, readonly originHeight_m: number) {}

  /** Subtracts the site's origin, so that positions fit the scene. */
  static parse(csv: string, origin: readonly [number, number, number]): Lap {
    const lines = csv.split('\n').filter((line) => line.trim() !== '');
    const header = (lines[0] ?? '').split(',').map((name) => name.trim());
    const indices = columnNames.map((name) => {
      const index = header.indexOf(name);
      if (index < 0) throw new Error(`drive/lap.csv has no column ${name}`);
      return index;
    });
    const count = lines.length - 1;
    if (count < 2) throw new Error('drive/lap.csv has fewer than two rows');
    const columns = Object.fromEntries(columnNames.map((name) => [name, new Float64Array(count)])) as Columns;
    for (let row = 0; row < count; ++row) {
      const fields = lines[row + 1].split(',');
      columnNames.forEach((name, i) => (columns[name][row] = Number(fields[indices[i]])));
    }
    columns.x_m.forEach((x, i) => (columns.x_m[i] = x - origin[0]));
    columns.y_m.forEach((y, i) => (columns.y_m[i] = y - origin[1]));
    columns.z_m.forEach((z, i) => (columns.z_m[i] = z - origin[2]));
    return new Lap(columns, origin[2]);
  }

  get start_s(): number {
    return this.columns.t_s[0];
  }
  get duration_s(): number {
    return this.columns.t_s[this.columns.t_s.length - 1] - this.start_s;
  }

  /** Linear between rows; after the end the lap begins anew. */
  at(t_s: number): CarState {
    const times = this.columns.t_s;
    const elapsed = ((t_s % this.duration_s) + this.duration_s) % this.duration_s;
    const t = this.start_s + elapsed;
    let low = 0, high = times.length - 1; // times[low] <= t < times[high]
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= t) low = middle;
      else high = middle;
    }
    const share = (t - times[low]) / (times[high] - times[low]);
    const state = {} as CarState;
    for (const name of columnNames) {
      const a = this.columns[name][low], b = this.columns[name][high];
      const step = name === 'heading_rad' ? Math.atan2(Math.sin(b - a), Math.cos(b - a)) : b - a;
      state[name] = a + share * step;
    }
    state.t_s = elapsed;
    return state;
  }

  /** States about `step_s` apart over the whole lap, for lines and plots. */
  sampled(step_s: number): CarState[] {
    const count = Math.max(2, Math.ceil(this.duration_s / step_s));
    return Array.from({length: count}, (_, i) => this.at((i / count) * this.duration_s));
  }
}
