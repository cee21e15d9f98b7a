/** Shapes of what the modules pass on, for the type check. The service's own are described in docs/openapi.yaml. */

interface View { t0: number; t1: number; v0: number; v1: number }

interface Axis { start: number; stop: number; cells: number }

interface Harmonic { order: number; amplitude: number; phase?: number }

interface Oscillator {
  model?: string;
  damping?: number;
  eccentricity?: number;
  half_backlash?: number;
  stiffness?: number;
  restitution?: number;
  contact_damping?: number;
  harmonics?: Harmonic[];
  permanent_contact?: string;
  allow_no_quiet_solution?: boolean;
}

/** Bound of a number of the oscillator: which values the service refuses, and why. */
interface Bound { field: string; above: number | null; below: number | null; between: [number, number | null] | null; loose_from: number | null; why: string }

/** One unit of the model in SI: s, m/s and W. */
interface Scales { time: number; speed: number; power: number }

interface Swept { parameter: string; values?: number[]; start?: number; stop?: number; count?: number }

interface Design { name: string; units?: string; values: number[]; parameters: { [parameter: string]: number[] } }

interface BasinRequest {
  kind?: string;
  oscillator: Oscillator;
  grid?: { time: Axis; velocity: Axis };
  iterations?: number;
  vary?: Swept[];
  design?: Design;
  sample?: object;
  /** What is asked for beside the labels, by the names of additions. */
  [addition: string]: any;
}

interface Progress {
  stage: string;
  tiles_done: number;
  tiles_total: number;
  cells_per_second: number;
  seconds_left: number;
  basins_done: number;
  basins_total: number;
}

interface Job {
  id: string;
  kind: string;
  state: string;
  request: BasinRequest;
  created: string;
  started: string | null;
  finished: string | null;
  progress: Progress | null;
  error?: { detail: string } | null;
  links: { self: string; cancel: string; events: string; result: string; zarr: string; picture: string };
}

/** How loud a motion is, or a basin on average over its window. */
interface Loudness {
  impacts_per_period: number | null;
  largest_impact_speed: number | null;
  impact_power: number | null;
  time_in_contact: number | null;
}

interface Expected extends Loudness { undecided_share: number }

interface Solution extends Loudness {
  number: number;
  name: string;
  kind: string;
  share: number | null;
  lyapunov_exponent: number | null;
  mean_life: number | null;
  mean_life_error: number | null;
  colours: { [palette: string]: string };
  textures: { [palette: string]: number };
  points: [number, number][];
}

/** A colour, and the number of the texture that marks its cells: 0 for none. */
interface Paint { colour: string; texture: number }

interface Polyline { time: number[]; velocity: number[]; box?: View }

/** Tiles of a basin, or of one of its levels, of rows by columns of their own cells. */
interface Tiling { rows: number; columns: number; down: number; across: number; first: number }

interface Level extends Tiling { level: number; every: number }

interface Outline {
  parameters: { [name: string]: number };
  time: Axis;
  velocity: Axis;
  tiles: Tiling & { states: number[] };
  levels: Level[];
  complete: boolean;
  /** Whether there is a mask, by the fields of additions. */
  [addition: string]: any;
  solutions: Solution[];
  expected: Expected | null;
  /** Between which bounds shares lie, by the numbers of solutions. */
  share_bounds?: [number, number][];
  speckle: number[];
  missing_colour: string;
  grazing: Polyline;
}

interface PreviewAnswer {
  time: Axis;
  velocity: Axis;
  iterations: number;
  solutions: Solution[];
  expected: Expected;
  missing_colour: string;
  grazing: Polyline;
  labels: string;
}

interface Departure { t: number; v: number }

/** A departure, and whether it is in the basin that was kept. */
interface Place extends Departure { kept: boolean }

/** A layer over cells: how many parts a cell has, and its words. Braces stand for what is said of a cell. */
interface Mask {
  name: string; label: string; sign: string; colour: string; note: string; parts: number;
  words: { clear: string; veiled: string; whole: string; partly: string; none: string; untried: string };
  ends: { [kind: string]: string };
  reasons: { [reason: string]: string };
}

/** What a package adds to basins: its field of requests and of outlines, its box in the form, its words in addresses, its stages. */
interface Addition {
  name: string; outline: string; mask: Mask;
  box: { label: string; title: string; model: string };
  address: { number: string; pairs: string; pair: string };
  stages: { [stage: string]: string };
}

/** How many parts of a cell are clear of a mask, and why not all; a reason of null where it was not tried yet. */
interface Clear { parts: number; reason: number | null }

/** What is known of a place: the motion it ends in, where a motion from there starts, Hsu's numbers, and what a mask leaves clear. */
interface Known extends Departure { solution: Solution; step?: number; group?: number; period?: number; clear?: Clear; mask?: Mask }

interface TimeHistory {
  time: number[];
  displacement: number[];
  velocity: number[];
  contacts: { time: number; wall: number; direction: string; speed: number }[];
  permanent_from: number | null;
}

/** What one followed motion does in the end; `first` is what it nearly repeats before. */
interface MotionEnd { kind: string; name: string | null; periods: number; impacts: number; first: { name: string; periods: number } | null }

interface Motion { start: Departure; shown: TimeHistory; departures: Departure[]; end: MotionEnd; ends: string; kept?: { oscillator: Oscillator } | null }

interface Look { layer: string; palette: string; highlight: string | null; ground: string }

/** What an address holds of a chart: the ranges that are seen, null for the whole, over which parameter (two by a comma), and its job. */
interface SeenChart { parameter?: string; x: number[] | null; y: number[] | null; job?: string | null }

interface SeenCharts { diagram: SeenChart | null; orbits: SeenChart | null; parameters: SeenChart | null; shares: SeenChart | null; power: SeenChart | null }
