/**
 * Haptic tracing by itself: the graph of what touches, best paths, mix. What touches and what hits is told by the engine. ES module without
 * dependencies, for browsers and Node; a step makes no lists or objects once it has run, only what the engine of JavaScript boxes (60 kB with 1,000
 * bodies). The tables are those of NAME.tracer.json (docs/tracer.md), or are made in code. Vectors have x, y, z; positions in the space of an object
 * are lists, as in the tables. The same in C#: clients/csharp/HapticTracer.cs.
 *
 * const tracer = Tracer.read(await (await fetch("bench.tracer.json")).text());
 * tracer.setContacts([{one: 0, other: 1, at: {x: 1, y: 0, z: 0}, normal: {x: 0, y: 1, z: 0}}]);
 * tracer.step(1 / 60);
 * console.log(tracer.level(0), tracer.sources[0].heard[0].path, tracer.listeners[0].samples.subarray(0, tracer.count));
 */

/** The cost at which a search ends: -120 dB. */
const LIMIT = 13.815510557964274;
const BANDS = 6, CHAIN = 4, MOST_BLOWS = 32;
/** Entries whose costs differ by less are examined in any order. */
const STEP = LIMIT / 512;

const vector = ([x, y, z]) => ({x, y, z});
/** The normal of a contact of which an engine tells none. */
const NOWHERE = vector([NaN, NaN, NaN]);

function apart(a, b) {
  const x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
  return Math.sqrt(x * x + y * y + z * z);
}

/** The square of the distance beside a body's middle at which it is driven along a normal, infinite if that is unknown. */
function beside({x, y, z}, middle, n) {
  const a = x - middle.x, b = y - middle.y, c = z - middle.z;
  const square = (b * n.z - c * n.y) ** 2 + (c * n.x - a * n.z) ** 2 + (a * n.y - b * n.x) ** 2;
  return square >= 0 ? Math.max(square, 1e-12) : Infinity;
}

/** What a connection costs, -log of its gain, in each lane: without bands, then by band if there are any. */
export class TracedFunction {
  loss = [0];
  decay = [0];
  over = "distance";
  range = Infinity;
  costs = null;
  slowness = 0;
  spring = null;

  /** `form`: as in the tables, all of it optional; `grid`: where its costs are sampled. */
  constructor(form = {}, grid = []) {
    Object.assign(this, form, {grid});
    [this.exponent, this.reference, this.extent, this.width, this.most, this.point] = form.spreading ?? [0, 1, Infinity, 1, Infinity, Infinity];
    /** Of another form than a metric plus a constant, so that an object may be entered again at any cost. */
    this.isSpecial = this.range < Infinity || this.costs !== null;
  }

  /** K exp(-max(K, epsilon) d) with K = (1 - kappa) rho. */
  static paper(kappa, rho, epsilon = 0.1) {
    const k = (1 - kappa) * rho;
    return new TracedFunction({loss: [-Math.log(k)], decay: [Math.max(k, epsilon)]});
  }

  spread(run) {
    const near = this.exponent * Math.log(1 + Math.min(run, this.extent) / this.reference);
    return run > this.extent ? near + 0.5 * Math.log(1 + (run - this.extent) / this.width) : near;
  }

  /** What is alike in all lanes over a distance between two nodes, whose fronts of waves have run some way before. */
  shape(distance, one, other) {
    let cost = this.special(distance, distance);
    if (this.exponent === 0) return cost;
    if (one.run === 0 && other.run === 0) return cost + this.spread(Math.min(distance, this.most));
    const run = Math.max(one.run, other.run, Math.min(distance + (one.run + other.run) / 2, this.most));
    return cost + Math.max(this.spread(run) - one.half - other.half, 0);
  }

  /** What a function of another form costs over a distance, and where its variable has a value. */
  special(distance, value) {
    if (!this.isSpecial) return 0;
    const {grid, costs} = this, cost = distance < this.range ? -Math.log(1 - distance / this.range) : Infinity;
    if (!costs) return cost;
    let place = 1;
    while (place < grid.length - 1 && grid[place] < value) place++;
    const share = Math.min((value - grid[place - 1]) / (grid[place] - grid[place - 1]), 1);
    const sampled = costs[place - 1] + share * (costs[place] - costs[place - 1]);
    return sampled < 14 ? cost + sampled : Infinity;
  }
}

/** Where an object is entered, left or listened to. */
class Node {
  item = null;
  contact = null;
  partner = null;
  x = 0.5;
  y = 0.5;
  z = 0.5;
  reach = 0.5;
  // Of a front of waves: how far it has run, and half the cost of that.
  run = 0.5;
  half = 0.5;
  // In a search: the least costs of arriving inside the object and of entering it here, and where it was entered before.
  arrival = 0.5;
  entering = 0.5;
  isPending = false;
  entry = null;
  // By band: mobility by itself; as it drives others, in turns in a round and in the one before; flexibility, alone and with that of the
  // contact. By lane: gain of leaving.
  own = new Float64Array(BANDS);
  mobilities = [new Float64Array(BANDS), new Float64Array(BANDS)];
  flexibility = new Float64Array(BANDS);
  across = new Float64Array(BANDS);
  gains = new Float64Array(1 + BANDS);

  /** The number of its object, and where it stays there. */
  constructor(object = 0, position = null) {
    this.object = object;
    this.position = position && vector(position);
  }
}

/** Nodes in a list that keeps its room. */
class Nodes {
  nodes = [];
  count = 0;

  add(node) {
    this.nodes[this.count++] = node;
  }
}

/** An object that vibration runs through. `class`: in the tables of contacts and blows; `mass`: 0 if nothing moves it. */
export class TracedObject extends Nodes {
  function = new TracedFunction();
  class = 0;
  mass = 0;
  centre = null;
  size = null;
  body = null;
  pose = [0, 0, 0, 1, 0, 0, 0];
  isCarried = false;
  // The last round in which what stands behind it may have changed.
  due = 0;
  // The numbers of objects that it touches as long as there are contacts.
  staying = new Set();

  constructor(form) {
    super();
    Object.assign(this, form);
    this.centre &&= vector(this.centre);
    this.move(...this.pose);
  }

  /** Where it is: position and rotation. */
  move(x, y, z, qw, qx, qy, qz) {
    this.x = x;
    this.y = y;
    this.z = z;
    this.qw = qw;
    this.qx = qx;
    this.qy = qy;
    this.qz = qz;
  }

  /** Turn a vector as the object is, or, with the negative angle, back. */
  turned({x, y, z}, to, qw = this.qw) {
    const {qx, qy, qz} = this, a = 2 * (qy * z - qz * y), b = 2 * (qz * x - qx * z), c = 2 * (qx * y - qy * x);
    to.x = x + qw * a + qy * c - qz * b;
    to.y = y + qw * b + qz * a - qx * c;
    to.z = z + qw * c + qx * b - qy * a;
    return to;
  }

  toWorld(local, to) {
    this.turned(local, to);
    to.x += this.x;
    to.y += this.y;
    to.z += this.z;
    return to;
  }

  toLocal(world) {
    const {x, y, z} = this.turned({x: world.x - this.x, y: world.y - this.y, z: world.z - this.z}, {}, -this.qw);
    return [x, y, z];
  }
}

/** A signal as rows of samples, each heard with a mix of the gains of the lanes. */
export class Signal {
  loops = false;
  lane = 0;
  mix = [[1]];
  power = [[1]];

  constructor(form) {
    Object.assign(this, form);
    this.length = this.rows[0].length;
  }

  /** A tone of whole hertz: endless, or fading within some seconds. */
  static tone(frequency, decay = Infinity, rate = 8000) {
    const row = Float32Array.from({length: rate}, (_, k) => Math.sin((2 * Math.PI * frequency * k) / rate) * Math.exp(-k / rate / decay));
    return new Signal({rows: [row], loops: decay === Infinity});
  }

  static read(form) {
    const rows = form.rows.map(text => {
      const bytes = new DataView(Uint8Array.from(atob(text), letter => letter.charCodeAt(0)).buffer);
      return Float32Array.from({length: bytes.byteLength / 2}, (_, k) => (bytes.getInt16(2 * k, true) * form.peak) / 32767);
    });
    return new Signal({...form, rows});
  }
}

/** What of a source is felt by a listener. */
class Heard {
  /** The numbers of the objects on the best path, from the source on. */
  path = [];
  // Before and now: gains of rows with all factors, and delays in samples.
  before = new Float64Array(BANDS);
  now = new Float64Array(BANDS);
  late = 0;
  later = 0;
  /** By lane. */
  gains = new Float64Array(1 + BANDS);
}

/** What vibrates: always, or, where it plays `once`, whenever it is asked to. `object`: number of its object; `position`: there. */
export class Source {
  amplitude = 1;
  once = false;
  voices = 0;
  began = false;
  /** By listener. */
  heard = [];

  constructor({object, position, ...form}) {
    this.nodes = [new Node(object, position)];
    Object.assign(this, form);
  }

  /** The gain of its signal on the best path to a listener. */
  gain(listener) {
    const {gains} = this.heard[listener] ?? {gains: []};
    return Math.sqrt(Math.max(this.signal.power.reduce((sum, row, i) => row.reduce((sum, value, j) => sum + gains[i] * value * gains[j], sum), 0), 0)) || 0;
  }
}

/** Where it is felt: a ball on an object. `samples`: of the last step; there may be room for more behind them. */
export class Listener {
  radius = 0;
  gain = 1;
  s_max = 1;
  samples = new Float32Array();
  recent = null;

  constructor({object, position, ...form}) {
    this.node = new Node(object, position);
    Object.assign(this, form);
  }
}

class Contact {
  nodes = [new Node(), new Node()];
  normal = {...NOWHERE};
  /** Of one that stays: the normal in the space of the first object. */
  local = null;
  // From the beginning, so that all contacts have one form, which is faster.
  area = 0.5;
  force = 0.5;
  depth = 0.5;
  weight = 0.5;
  distance = 0.5;
  rest = 0.5;

  constructor() {
    const [one, other] = this.nodes;
    one.contact = other.contact = this;
    one.partner = other;
    other.partner = one;
  }
}

/** The tracer. Tell what moves, touches and hits, then step; then listeners have samples and levels. */
export class Tracer {
  objects = [];
  sources = [];
  listeners = [];
  /** The blows that sound; the last ones have begun last. */
  blows = [];
  /** The number of samples of the last step. */
  count = 0;
  _contacts = [];
  _touching = 0;
  _staying = 0;
  _voices = [];
  _part = 0;
  _isSpecial = false;
  _best = new Float64Array(BANDS);
  _second = new Float64Array(BANDS);
  _vector = {...NOWHERE};
  _pending = Array.from({length: 513}, () => new Nodes());
  _recentCount = 0;

  constructor({lanes = 1, sample_rate = 8000, frequencies = []} = {}) {
    Object.assign(this, {lanes, sample_rate, _omega: frequencies.map(frequency => 2 * Math.PI * frequency)});
    /** By the classes of two objects: what contacts pass on, and what blows play. */
    this.between = [[new TracedFunction()]];
    this.impacts = [[{least_energy: 0.05, full_energy: 100, gain: [0, 1], signals: [Signal.tone(150, 0.03, sample_rate)]}]];
  }

  /** A tracer of the tables in NAME.tracer.json. */
  static read(json) {
    const file = JSON.parse(json, (key, value) => value ?? Infinity);
    if (file.format !== "haptic-tracer" || file.version !== 1) throw new Error("no tables of a haptic tracer 1");
    const tracer = new Tracer(file), signals = file.signals.map(Signal.read);
    const functions = file.functions.map(form => new TracedFunction(form, file.grid));
    const impacts = file.impacts.map(form => ({...form, signals: form.signals.map(number => signals[number])}));
    tracer.objects = file.objects.map(form => new TracedObject({...form, function: functions[form.function]}));
    tracer.sources = file.sources.map(form => new Source({...form, signal: signals[form.signal]}));
    tracer.listeners = file.listeners.map(form => new Listener(form));
    tracer.between = file.between.map(row => row.map(number => functions[number]));
    tracer.impacts = file.blows.map(row => row.map(number => impacts[number]));
    for (const {objects, positions, normal, ...form} of file.contacts) {
      const contact = Object.assign(new Contact(), form, {local: vector(normal), function: functions[form.function]});
      contact.nodes.forEach((node, side) => Object.assign(node, {object: objects[side], position: vector(positions[side])}));
      objects.forEach((number, side) => tracer.objects[number].staying.add(objects[1 - side]));
      tracer._touching = tracer._staying = tracer._contacts.push(contact);
    }
    return tracer;
  }

  /** All that touches now, objects by number. What is not known is left out: no area is a point. */
  setContacts(contacts) {
    const {objects} = this;
    this._touching = this._staying;
    for (const {one, other, at, otherAt = at, normal = NOWHERE, area = 0, force = NaN, depth = 0, weight = 1} of contacts) {
      if (objects[one].staying.has(other)) continue;
      const contact = (this._contacts[this._touching++] ??= new Contact()), [first, second] = contact.nodes;
      first.object = one;
      second.object = other;
      put(first, at);
      put(second, otherAt);
      put(contact.normal, normal);
      contact.area = area;
      contact.force = force;
      contact.depth = depth;
      contact.weight = weight;
      contact.function = this.between[objects[one].class][objects[other].class];
    }
  }

  /** The energy in joules of a blow at a speed along the normal. */
  energy(one, other, speed) {
    const [a, b] = [one, other].map(number => this.objects[number].mass || Infinity), inverse = 1 / a + 1 / b;
    return inverse && (speed * speed) / (2 * inverse);
  }

  /** Two objects hit each other, some seconds after the next step's beginning. Whether it sounds: the blow is the last of `blows` then. */
  blow(one, other, at, energy, after = 0) {
    const {objects, blows} = this, impact = this.impacts[objects[one].class][objects[other].class];
    if (!impact || energy < impact.least_energy) return false;
    const strength = Math.min(energy / impact.full_energy, 1), [weak, full] = impact.gain, {signals} = impact;
    const nodes = [one, other].map(number => new Node(number, objects[number].toLocal(at)));
    const blow = new Source({nodes, amplitude: weak + (full - weak) * strength, once: true, signal: signals[Math.round(strength * (signals.length - 1))]});
    if (blows.push(blow) > MOST_BLOWS) {
      const first = blows.shift();
      this._voices = this._voices.filter(({source}) => source !== first);
    }
    this.play(blow, after);
    return true;
  }

  /** Play the signal of a source, some seconds after the next step's beginning. */
  play(source, after = 0) {
    source.began = source.voices++ === 0;
    this._voices.push({source, place: -Math.round(after * this.sample_rate)});
  }

  /** Go on by some seconds. */
  step(seconds) {
    const end = this._part + seconds * this.sample_rate;
    this.count = Math.floor(end + 0.5);
    this._part = end - this.count;
    for (const source of this.sources) if (!source.once && source.voices === 0) this.play(source);
    this._number();
    this._passOn();
    for (const source of this.sources) this._propagate(source);
    for (const blow of this.blows) this._propagate(blow);
    this._mix();
  }

  /** The level of the last quarter second of a listener in decibels, null for silence. */
  level(listener) {
    let sum = 0, energy = 0;
    const recent = this.listeners[listener].recent ?? [];
    for (let k = 0; k < recent.length; k++) {
      sum += recent[k];
      energy += recent[k] * recent[k];
    }
    const rest = energy - (sum * sum) / recent.length;
    return rest > 1e-12 * energy ? 10 * Math.log10(rest / this._recentCount) : null;
  }

  // The graph.

  /** Put nodes onto their objects, those of contacts first. */
  _number() {
    this._isSpecial = false;
    for (const item of this.objects) {
      item.count = 0;
      this._isSpecial ||= item.function.isSpecial;
    }
    for (let k = 0; k < this._touching; k++) {
      const contact = this._contacts[k], [one, other] = contact.nodes;
      this._put(one).add(one);
      this._put(other).add(other);
      if (contact.local) one.item.turned(contact.local, contact.normal);
      if (contact.area) this._front(contact);
    }
    for (const item of this.objects) item.contacts = item.count;
    for (const source of this.sources) for (const node of source.nodes) this._put(node);
    for (const blow of this.blows) for (const node of blow.nodes) this._put(node);
    for (const {node, radius} of this.listeners) {
      this._put(node).add(node);
      node.reach = radius;
    }
  }

  _put(node) {
    const item = this.objects[node.object];
    node.item = item;
    if (node.position) item.toWorld(node.position, node);
    node.reach = node.run = node.half = 0;
    return item;
  }

  /** The fronts of waves that begin with the size of a patch. */
  _front({nodes, normal, area}) {
    let wide = 0, most = Infinity;
    for (const {item} of nodes) {
      if (!item.size) continue;
      const [a, b, c] = item.size, {x, y, z} = item.turned(normal, this._vector, -item.qw);
      const across = (x * x) / Math.max(Math.min(b, c), 0.01) + (y * y) / Math.max(Math.min(a, c), 0.01) + (z * z) / Math.max(Math.min(a, b), 0.01);
      wide = Math.max(wide, across || 0);
      most = Math.min(most, 2 * Math.max(Math.min(a, b), Math.min(Math.max(a, b), c)));
    }
    const patch = Math.min(Math.max(Math.sqrt(area), area * wide), most);
    for (const node of nodes) {
      const own = node.item.function;
      node.run = Math.max(patch - own.point, 0);
      node.half = own.spread(node.run) / 2;
    }
  }

  // What contacts pass on.

  _passOn() {
    let byBodies = false;
    for (let k = 0; k < this._touching; k++) {
      const contact = this._contacts[k], {nodes: [one, other], function: own} = contact, a = one.item.body, b = other.item.body;
      contact.distance = apart(one, other);
      contact.rest = -Math.log(contact.weight);
      if (own.isSpecial) {
        contact.angle = Math.acos(Math.min(Math.abs(contact.normal.y), 1));
        contact.rest += own.special(contact.distance, contact[own.over] || 0);
      }
      contact.byBodies = own.spring !== null && a !== null && b !== null && (a.kind !== b.kind || own.spring[0] < Infinity);
      byBodies ||= contact.byBodies;
    }
    if (!byBodies) return;
    for (const item of this.objects) this._impede(item);
    for (let round = 0; round < CHAIN; round++) for (const item of this.objects) if (item.isCarried && item.due >= round - 1) this._carry(item, round);
    for (let k = 0; k < this._touching; k++) if (this._contacts[k].byBodies) for (const node of this._contacts[k].nodes) this._pass(node);
  }

  /** The impedances of a body, its mobilities if nothing stands behind it, and how flexible it is. */
  _impede(item) {
    const {contacts, nodes, body, centre} = item, {bending, spring, half_space} = body ?? {}, middle = centre && item.toWorld(centre, this._vector);
    item.isCarried = contacts > 1 && Boolean(bending || spring);
    item.due = 0;
    for (let k = 0; k < contacts; k++) {
      const {contact, own, mobilities: [mobility, next], flexibility, across} = nodes[k], inside = contact.function.spring, driven = half_space && half_space[0] + contact.area / Math.PI;
      const aside = item.isCarried && middle ? beside(nodes[k], middle, contact.normal) : Infinity;
      for (let band = 0; band < BANDS; band++) {
        const omega = this._omega[band];
        own[band] = half_space ? 1 / Math.sqrt((half_space[2] * driven) ** 2 + (half_space[1] / omega) ** 2 * driven) : body ? 1 / body.impedance[band] : 0;
        mobility[band] = next[band] = item.isCarried && spring ? Infinity : own[band];
        flexibility[band] = spring ? omega / (2 * spring[0]) : bending ? aside / bending[band] : 0;
        across[band] = flexibility[band] + (inside ? omega / inside[0] : 0);
      }
    }
  }

  /** The mobilities with which a small body drives others: those of what stands behind it in the round before. */
  _carry({nodes, contacts, body}, round) {
    const {_best: best, _second: second} = this, before = round % 2;
    best.fill(Infinity);
    second.fill(Infinity);
    for (let k = 0; k < contacts; k++) {
      const {mobilities, across, partner, contact} = nodes[k], opening = 1 / Math.max(contact.weight, 1e-12);
      const mobility = partner.mobilities[before], behind = mobilities[1 - before];
      for (let band = 0; band < BANDS; band++) {
        const value = opening * (mobility[band] + across[band]);
        behind[band] = value;
        if (value >= second[band]) continue;
        second[band] = Math.max(value, best[band]);
        best[band] = Math.min(value, best[band]);
      }
    }
    for (let k = 0; k < contacts; k++) {
      const {own, flexibility, mobilities, partner} = nodes[k], last = mobilities[before], behind = mobilities[1 - before];
      for (let band = 0; band < BANDS; band++) {
        const driven = flexibility[band] + (behind[band] === best[band] ? second[band] : best[band]);
        behind[band] = driven < own[band] || body.spring ? driven : own[band];
        if (behind[band] !== last[band]) partner.item.due = round + 1;
      }
    }
  }

  /** What passes from a node over its contact. */
  _pass({contact, item, partner, mobilities: [mobility], gains}) {
    const {spring} = contact.function, soft = spring[0] < Infinity ? spring : item.body.spring;
    gains[0] = 0;
    for (let band = 0; band < BANDS; band++) {
      const load = (mobility[band] + this._omega[band] / spring[0]) / partner.own[band];
      let gain = Math.min(2 / (1 + load), 1);
      if (soft) {
        const above = Math.max(load, 2) - 1, loss = soft[1] ** 2;
        gain = Math.sqrt((1 + loss) / (above * above + loss));
      }
      gains[band + 1] = gain;
      gains[0] = Math.max(gains[0], gain);
    }
  }

  /** The cost of leaving an object through a node over its contact. */
  _crossing({contact, gains}, lane) {
    const {loss, decay} = contact.function, own = loss[lane] + decay[lane] * contact.distance + contact.rest;
    return contact.byBodies ? own - Math.log(gains[lane]) : own;
  }

  // Best paths.

  _propagate(source) {
    const {lanes, listeners} = this, {signal} = source;
    if (source.heard.length !== listeners.length) source.heard = listeners.map(() => new Heard());
    for (const heard of source.heard) {
      heard.path.length = 0;
      heard.gains.fill(0);
      heard.before.set(heard.now);
      heard.late = heard.later;
    }
    if (source.amplitude > 0 && source.voices) {
      this._search(source, signal.lane);
      if (!this._collect(source) && signal.lane) {
        this._search(source, 0);
        this._collect(source);
      }
    }
    for (let k = 0; k < listeners.length; k++) {
      const heard = source.heard[k];
      for (let row = 0; row < signal.mix.length; row++) {
        let gain = 0;
        for (let lane = 0; lane < lanes; lane++) gain += signal.mix[row][lane] * heard.gains[lane];
        heard.now[row] = gain * source.amplitude * listeners[k].gain;
      }
      if (!source.began) continue;
      heard.before.set(heard.now);
      heard.late = heard.later;
    }
    source.began = false;
  }

  _distance(a, b) {
    return Math.max(apart(a, b) - a.reach - b.reach, 0);
  }

  /** Dijkstra's algorithm; one step is through an object and over a contact. */
  _search(source, lane) {
    for (const {nodes, count} of this.objects) {
      for (let k = 0; k < count; k++) {
        nodes[k].arrival = LIMIT * (1 + 1e-15);
        nodes[k].entering = Infinity;
        nodes[k].entry = null;
      }
    }
    for (const pending of this._pending) pending.count = 0;
    for (const node of source.nodes) {
      node.arrival = Infinity;
      this._enter(node, 0);
    }
    let limit = LIMIT;
    for (let step = 0; step * STEP <= limit; step++) {
      const pending = this._pending[step];
      for (let place = 0; place < pending.count; place++) {
        const begin = pending.nodes[place], {nodes, count, function: own} = begin.item, near = begin.entering + own.loss[lane];
        if (!begin.isPending || (begin.arrival <= near && !this._isSpecial)) continue;
        begin.isPending = false;
        let isNearer = false;
        for (let k = 0; k < count; k++) {
          const end = nodes[k], distance = this._distance(begin, end);
          let far = near + own.decay[lane] * distance;
          if (far >= end.arrival || end === begin) continue;
          far += own.shape(distance, begin, end);
          if (far >= end.arrival) continue;
          end.arrival = far;
          end.entry = begin;
          if (!end.partner) {
            isNearer = true;
            continue;
          }
          far += this._crossing(end, lane);
          if (far <= limit && far < end.partner.entering) this._enter(end.partner, far);
        }
        // No more than what each listener costs now is of interest.
        if (isNearer) limit = Math.min(limit, this.listeners.reduce((dearest, {node}) => Math.max(dearest, node.arrival), 0));
      }
    }
  }

  _enter(node, cost) {
    node.entering = cost;
    node.isPending = true;
    this._pending[Math.floor(cost / STEP)].add(node);
  }

  /** Take gains and paths to the listeners without any from the last search. Whether all have one then. */
  _collect(source) {
    const {lanes, listeners} = this;
    let all = true;
    for (let k = 0; k < listeners.length; k++) {
      const {path, gains} = source.heard[k];
      let {node} = listeners[k], late = 0;
      if (path.length) continue;
      all &&= node.entry !== null;
      if (!node.entry) continue;
      while (node) {
        const begin = node.entry, {function: own} = node.item, distance = this._distance(begin, node), shape = own.shape(distance, begin, node);
        if (node.object !== path.at(-1)) path.push(node.object);
        late += own.slowness * distance;
        node = begin.partner;
        if (node) late += begin.contact.function.slowness * begin.contact.distance;
        for (let lane = 0; lane < lanes; lane++) gains[lane] += own.loss[lane] + own.decay[lane] * distance + shape + (node ? this._crossing(node, lane) : 0);
      }
      path.reverse();
      for (let lane = 0; lane < lanes; lane++) gains[lane] = Math.exp(-gains[lane]);
      source.heard[k].later = late * this.sample_rate;
    }
    return all;
  }

  // Samples.

  _mix() {
    const {count, listeners, _voices: voices} = this, window = this.sample_rate / 4;
    for (const listener of listeners) {
      if (listener.samples.length < count) listener.samples = new Float32Array(2 * count);
      listener.recent ??= new Float32Array(window);
      listener.samples.fill(0);
    }
    for (let v = voices.length - 1; v >= 0; v--) {
      const voice = voices[v], {source, source: {signal, heard}} = voice;
      let longest = 0;
      for (let k = 0; k < listeners.length; k++) {
        this._hear(voice, heard[k], listeners[k].samples);
        longest = Math.max(longest, heard[k].later);
      }
      voice.place += count;
      if (signal.loops && voice.place > 2 * signal.length + longest) voice.place -= signal.length;
      if (signal.loops || voice.place < signal.length + longest) continue;
      voices.splice(v, 1);
      source.voices--;
      this.blows = this.blows.filter(blow => blow.voices);
    }
    for (const {samples, recent, s_max} of listeners) {
      recent.copyWithin(0, count);
      for (let k = 0; k < count; k++) {
        samples[k] = Math.max(-s_max, Math.min(samples[k], s_max));
        recent[window - count + k] = samples[k];
      }
    }
    this._recentCount = Math.min(this._recentCount + count, window);
  }

  /** Add a voice to the samples of a listener; its gains go in straight lines over the step. */
  _hear({source: {signal: {rows, loops, length}}, place}, {before, now, late, later}, samples) {
    const {count} = this, drift = (later - late) / count;
    for (let r = 0; r < rows.length; r++) {
      const row = rows[r], gain = before[r], slope = (now[r] - gain) / count;
      if (gain === 0 && slope === 0) continue;
      for (let k = 0; k < count; k++) {
        const at = place + k - late - drift * k, whole = Math.floor(at), share = at - whole;
        if (whole < 0 || (whole >= length && !loops)) continue;
        const value = row[whole % length];
        samples[k] += (gain + slope * k) * (share ? value + share * (row[(whole + 1) % length] - value) : value);
      }
    }
  }
}

function put(to, {x, y, z}) {
  to.x = x;
  to.y = y;
  to.z = z;
}

/** All that touches in a world of Rapier, for `setContacts`. `numbers`: of objects, in a map by the handles of their colliders. */
export function contactsOfRapier(world, numbers) {
  const found = {};
  for (const [handle, one] of numbers) {
    const collider = world.getCollider(handle);
    world.contactPairsWith(collider, second => {
      const other = numbers.get(second.handle);
      if (one < other) world.contactPair(collider, second, manifold => {
        for (let k = 0; k < manifold.numSolverContacts(); k++) {
          // The mean of all points between two objects.
          const contact = (found[[one, other]] ??= {one, other, at: vector([0, 0, 0]), normal: manifold.normal(), force: 0, points: 0});
          const {at} = contact, {x, y, z} = manifold.solverContactPoint(k), share = 1 / ++contact.points;
          put(at, {x: at.x + share * (x - at.x), y: at.y + share * (y - at.y), z: at.z + share * (z - at.z)});
          contact.force += manifold.contactImpulse(k) / world.timestep;
        }
      });
    });
  }
  return Object.values(found);
}
