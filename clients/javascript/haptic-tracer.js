/**
 * Haptic tracing by itself: the graph of what touches, best paths, mix. What touches and what hits is told by the engine. ES module without
 * dependencies, for browsers and Node; a step allocates nothing once it has run. The tables are those of NAME.tracer.json (docs/tracer.md),
 * or are made in code. Vectors have x, y, z. The same in C#: clients/csharp/HapticTracer.cs.
 *
 * const tracer = Tracer.read(await (await fetch("bench.tracer.json")).text());
 * tracer.setContacts([{one: 0, other: 1, at: {x: 1, y: 0, z: 0}, normal: {x: 0, y: 1, z: 0}}]);
 * tracer.step(1 / 60);
 * console.log(tracer.level(0), tracer.sources[0].paths[0], tracer.listeners[0].samples.subarray(0, tracer.count));
 */

/** The cost at which a search ends: -120 dB. */
const LIMIT = 13.815510557964274;
const BANDS = 6, CHAIN = 4, MOST_BLOWS = 32;
const UNKNOWN = Array(BANDS).fill(Infinity);

const vector = ([x, y, z]) => ({x, y, z});

function between(a, b) {
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
  /** `form`: as in the tables; `grid`: where its costs are sampled. */
  constructor(form, grid) {
    Object.assign(this, {over: "distance", range: Infinity, costs: null, slowness: 0, spring: null}, form);
    [this.exponent, this.reference, this.extent, this.width, this.most, this.point] = form.spreading ?? [0, 1, Infinity, 1, Infinity, Infinity];
    this.grid = grid;
    /** Of another form than a metric plus a constant, so that an object may be entered again at any cost. */
    this.isSpecial = this.range < Infinity || this.costs !== null;
  }

  static plain(loss, decay, lanes = 1) {
    return new TracedFunction({loss: Array(lanes).fill(loss), decay: Array(lanes).fill(decay)});
  }

  /** K exp(-max(K, epsilon) d) with K = (1 - kappa) rho. */
  static paper(kappa, rho, epsilon = 0.1, lanes = 1) {
    const k = (1 - kappa) * rho;
    return TracedFunction.plain(-Math.log(k), Math.max(k, epsilon), lanes);
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

/** An object that vibration runs through. `class`: in the tables of contacts and blows; `mass`: 0 if nothing moves it. */
export class TracedObject {
  constructor(form) {
    Object.assign(this, {name: "", function: null, class: 0, mass: 0, centre: null, size: null, body: null}, form);
    Object.assign(this, {nodes: [], count: 0, contacts: 0, isCarried: false});
    this.move(...(form.pose ?? [0, 0, 0, 1, 0, 0, 0]));
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
    return this.turned({x: world.x - this.x, y: world.y - this.y, z: world.z - this.z}, {}, -this.qw);
  }

  add(node) {
    this.nodes[this.count++] = node;
  }
}

/** A signal as rows of samples, each heard with a mix of the gains of the lanes. */
export class Signal {
  constructor(form) {
    Object.assign(this, {loops: false, lane: 0, mix: [[1]], power: [[1]]}, form);
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

/** What vibrates: always, or, where it plays once, whenever it is asked to. `object`: number of its object; `position`: there. */
export class Source {
  constructor(form) {
    Object.assign(this, {name: "", amplitude: 1, once: false, second: null, secondPosition: null}, form);
    Object.assign(this, {nodes: this.second === null ? [new Node()] : [new Node(), new Node()], voices: 0, began: false});
    /** By listener: the numbers of the objects on the best path, from here on. */
    this.paths = [];
    // By listener: gains of lanes, and before and now those of rows with all factors, and delays in samples.
    this.gains = this.before = this.now = this.late = this.later = new Float64Array();
  }

  /** The gain of its signal on the best path to a listener. */
  gain(listener) {
    const {power} = this.signal, gains = this.gains.subarray(listener * power.length);
    return Math.sqrt(Math.max(power.reduce((sum, row, i) => row.reduce((sum, value, j) => sum + gains[i] * value * gains[j], sum), 0), 0)) || 0;
  }
}

/** Where it is felt: a ball on an object. `samples`: of the last step; there may be room for more behind them. */
export class Listener {
  constructor(form) {
    Object.assign(this, {name: "", body_part: "", radius: 0, gain: 1, s_max: 1, node: new Node(), samples: new Float32Array(), recent: null}, form);
  }
}

/** Where an object is entered, left, or listened to. */
class Node {
  constructor() {
    Object.assign(this, {item: null, contact: null, partner: null, x: 0.5, y: 0.5, z: 0.5, reach: 0.5, run: 0.5, half: 0.5});
    // In a search: the least costs of arriving here inside the object, and of entering it here; where it was entered before.
    Object.assign(this, {arrival: 0.5, entering: 0.5, entry: null});
    // By band: impedance of its own, mobility as it drives others, that of what stands behind, flexibility, also with the contact's, gain of leaving.
    for (const key of ["own", "mobility", "behind", "flexibility", "between", "gains"]) this[key] = new Float64Array(BANDS);
    this.impedance = this.own;
  }
}

class Contact {
  constructor() {
    this.nodes = [new Node(), new Node()];
    [this.nodes[0].partner, this.nodes[1].partner] = [this.nodes[1], this.nodes[0]];
    for (const node of this.nodes) node.contact = this;
    this.normal = vector([0.5, 0.5, 0.5]);
    // Of one that stays: positions and normal in the spaces of the objects.
    Object.assign(this, {one: 0, other: 0, positions: null, local: null, function: null, area: 0.5, depth: 0.5, force: 0.5, weight: 0.5});
    Object.assign(this, {distance: 0.5, angle: 0.5, rest: 0.5, byBodies: false});
  }
}

/** The tracer. Tell what moves, touches and hits, then step; then listeners have samples and levels. */
export class Tracer {
  constructor(lanes = 1, sample_rate = 8000, frequencies = []) {
    Object.assign(this, {lanes, sample_rate, objects: [], sources: [], listeners: []});
    /** The number of samples of the last step. */
    this.count = 0;
    /** The blows that sound; the last ones have begun last. */
    this.blows = [];
    /** By the classes of two objects: what contacts pass on, and what blows play. */
    this.between = [[TracedFunction.plain(0, 0, lanes)]];
    this.impacts = [[{least_energy: 0.05, full_energy: 100, gain: [0, 1], signals: [Signal.tone(150, 0.03, sample_rate)]}]];
    this._omega = frequencies.map(frequency => 2 * Math.PI * frequency);
    this._costs = new Float64Array(lanes);
    [this._best, this._second] = [new Float64Array(BANDS), new Float64Array(BANDS)];
    this._vector = vector([0.5, 0.5, 0.5]);
    Object.assign(this, {_contacts: [], _touching: 0, _staying: new Set(), _voices: [], _part: 0, _isSpecial: false});
    Object.assign(this, {_keys: [], _values: [], _size: 0, _recentPlace: 0, _recentCount: 0});
  }

  /** A tracer of the tables in NAME.tracer.json. */
  static read(json) {
    const file = JSON.parse(json, (key, value) => value ?? Infinity);
    if (file.format !== "haptic-tracer" || file.version !== 1) throw new Error("no tables of a haptic tracer 1");
    const tracer = new Tracer(file.lanes, file.sample_rate, file.frequencies), signals = file.signals.map(Signal.read);
    const functions = file.functions.map(form => new TracedFunction(form, file.grid));
    const impacts = file.impacts.map(form => ({...form, signals: form.signals.map(number => signals[number])}));
    const placed = form => ({...form, position: vector(form.position), signal: signals[form.signal]});
    tracer.objects = file.objects.map(form => new TracedObject({...form, function: functions[form.function], centre: form.centre && vector(form.centre)}));
    tracer.sources = file.sources.map(form => new Source(placed(form)));
    tracer.listeners = file.listeners.map(form => new Listener(placed(form)));
    tracer.between = file.between.map(row => row.map(number => functions[number]));
    tracer.impacts = file.blows.map(row => row.map(number => impacts[number]));
    for (const {objects: [one, other], positions, normal, ...form} of file.contacts) {
      const local = {positions: positions.map(vector), local: vector(normal), function: functions[form.function]};
      tracer._contacts.push(Object.assign(new Contact(), form, {one, other}, local));
      tracer._staying.add(tracer._key(one, other));
    }
    tracer.partAll();
    return tracer;
  }

  /** Two objects touch. What is not known is left out: no area is a point. */
  touch(one, other, at, otherAt = at, normal = null, area = 0, force = NaN, depth = 0, weight = 1) {
    if (this._staying.size && this._staying.has(this._key(one, other))) return;
    const {_contacts: contacts, objects} = this, contact = (contacts[this._touching] ??= new Contact());
    this._touching++;
    contact.one = one;
    contact.other = other;
    put(contact.nodes[0], at);
    put(contact.nodes[1], otherAt);
    put(contact.normal, normal ?? NOWHERE);
    contact.area = area;
    contact.force = force;
    contact.depth = depth;
    contact.weight = weight;
    contact.function = this.between[objects[one].class][objects[other].class];
  }

  /** Nothing touches but what stays. */
  partAll() {
    this._touching = this._staying.size;
  }

  /** All that touches now: a list of objects with what `touch` takes. */
  setContacts(contacts) {
    this.partAll();
    for (const {one, other, at, otherAt, normal, area, force, depth, weight} of contacts) this.touch(one, other, at, otherAt, normal, area, force, depth, weight);
  }

  /** The energy in joules of a blow at a speed along the normal. */
  energy(one, other, speed) {
    const inverse = [one, other].reduce((sum, number) => sum + (this.objects[number].mass && 1 / this.objects[number].mass), 0);
    return inverse && (speed * speed) / (2 * inverse);
  }

  /** Two objects hit each other, some seconds after the next step's beginning. Whether it sounds: the blow is the last of `blows` then. */
  blow(one, other, at, energy, after = 0) {
    const {objects, blows} = this, impact = this.impacts[objects[one].class][objects[other].class];
    if (!impact || energy < impact.least_energy) return false;
    const strength = Math.min(energy / impact.full_energy, 1), [weak, full] = impact.gain;
    const blow = new Source({
      object: one,
      second: other,
      position: objects[one].toLocal(at),
      secondPosition: objects[other].toLocal(at),
      amplitude: weak + (full - weak) * strength,
      once: true,
      signal: impact.signals[Math.round(strength * (impact.signals.length - 1))],
    });
    if (blows.push(blow) > MOST_BLOWS) this._voices = this._voices.filter(voice => voice.source !== blows[0]);
    if (blows.length > MOST_BLOWS) blows.shift();
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
    this._isSpecial = this.objects.some(item => item.function.isSpecial);
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
    const {recent} = this.listeners[listener];
    for (const value of recent) {
      sum += value;
      energy += value * value;
    }
    const rest = energy - (sum * sum) / recent.length;
    return rest > 1e-12 * energy ? 10 * Math.log10(rest / this._recentCount) : null;
  }

  _key(one, other) {
    return Math.min(one, other) * 2 ** 26 + Math.max(one, other);
  }

  // The graph.

  /** Put nodes onto their objects, those of contacts first. */
  _number() {
    const {objects, _contacts: contacts} = this;
    for (const item of objects) item.count = 0;
    for (let k = 0; k < this._touching; k++) {
      const contact = contacts[k], {nodes: [one, other], positions} = contact;
      one.item = objects[contact.one];
      other.item = objects[contact.other];
      if (positions) {
        one.item.toWorld(positions[0], one);
        other.item.toWorld(positions[1], other);
        one.item.turned(contact.local, contact.normal);
      }
      one.item.add(one);
      other.item.add(other);
      this._front(contact);
    }
    for (const item of objects) item.contacts = item.count;
    for (const source of [this.sources, this.blows].flat()) {
      this._put(source.nodes[0], source.object, source.position);
      if (source.second !== null) this._put(source.nodes[1], source.second, source.secondPosition);
    }
    for (const {node, object, position, radius} of this.listeners) {
      this._put(node, object, position);
      node.reach = radius;
      node.item.add(node);
    }
  }

  _put(node, number, position) {
    node.item = this.objects[number];
    node.item.toWorld(position, node);
    node.reach = node.run = node.half = 0;
  }

  /** The fronts of waves that begin with the size of a patch. */
  _front({nodes, normal, area}) {
    let wide = 0, most = Infinity;
    for (const {item} of nodes) {
      if (!item.size || !area) continue;
      const [a, b, c] = item.size, {x, y, z} = item.turned(normal, this._vector, -item.qw);
      const across = (x * x) / Math.max(Math.min(b, c), 0.01) + (y * y) / Math.max(Math.min(a, c), 0.01) + (z * z) / Math.max(Math.min(a, b), 0.01);
      wide = Math.max(wide, across || 0);
      most = Math.min(most, 2 * Math.max(Math.min(a, b), Math.min(Math.max(a, b), c)));
    }
    const patch = Math.min(Math.max(Math.sqrt(area), area * wide), most);
    for (const node of nodes) {
      const own = node.item.function;
      node.reach = 0;
      node.run = Math.max(patch - own.point, 0);
      node.half = node.run && own.spread(node.run) / 2;
    }
  }

  // What contacts pass on.

  _passOn() {
    let byBodies = false;
    for (let k = 0; k < this._touching; k++) {
      const contact = this._contacts[k], {nodes: [one, other], function: own} = contact, a = one.item.body, b = other.item.body;
      contact.distance = between(one, other);
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
    this._isCarried = true;
    for (let round = 0; round < CHAIN && this._isCarried; round++) {
      this._isCarried = false;
      for (const item of this.objects) if (item.isCarried) this._standBehind(item);
      for (const item of this.objects) if (item.isCarried) this._carry(item);
    }
    for (let k = 0; k < this._touching; k++) if (this._contacts[k].byBodies) this._contacts[k].nodes.forEach(this._pass, this);
  }

  /** The impedances of a body, its mobilities if nothing stands behind it, and how flexible it is. */
  _impede(item) {
    const {body, contacts} = item, {bending, spring, half_space} = body ?? {}, middle = item.centre && item.toWorld(item.centre, this._vector);
    item.isCarried = contacts > 1 && Boolean(bending || spring);
    for (let k = 0; k < contacts; k++) {
      const node = item.nodes[k], {mobility, flexibility, between, contact} = node, inside = contact.function.spring;
      node.impedance = body ? body.impedance : UNKNOWN;
      if (half_space) this._drive(node, half_space);
      const aside = item.isCarried && middle ? beside(node, middle, contact.normal) : Infinity;
      for (let band = 0; band < BANDS; band++) {
        const omega = this._omega[band];
        mobility[band] = item.isCarried && spring ? Infinity : 1 / node.impedance[band];
        flexibility[band] = spring ? omega / (2 * spring[0]) : bending ? aside / bending[band] : 0;
        between[band] = flexibility[band] + (inside ? omega / inside[0] : 0);
      }
    }
  }

  /** The impedance of a half-space at a patch. */
  _drive(node, [square, stiffness, damper]) {
    const driven = square + node.contact.area / Math.PI;
    node.impedance = node.own;
    for (let band = 0; band < BANDS; band++) node.own[band] = Math.sqrt((damper * driven) ** 2 + (stiffness / this._omega[band]) ** 2 * driven);
  }

  _standBehind({nodes, contacts}) {
    for (let k = 0; k < contacts; k++) {
      const {behind, between, partner: {mobility}, contact: {weight}} = nodes[k], opening = 1 / Math.max(weight, 1e-12);
      for (let band = 0; band < BANDS; band++) behind[band] = opening * (mobility[band] + between[band]);
    }
  }

  /** The mobilities with which a small body drives others: those of what stands behind it. */
  _carry({nodes, contacts, body}) {
    const {_best: best, _second: second} = this;
    best.fill(Infinity);
    second.fill(Infinity);
    for (let k = 0; k < contacts; k++) {
      for (let band = 0; band < BANDS; band++) {
        const behind = nodes[k].behind[band];
        if (behind < best[band]) {
          second[band] = best[band];
          best[band] = behind;
        } else if (behind < second[band]) second[band] = behind;
      }
    }
    for (let k = 0; k < contacts; k++) {
      const {mobility, impedance, flexibility, behind} = nodes[k];
      for (let band = 0; band < BANDS; band++) {
        const others = flexibility[band] + (behind[band] === best[band] ? second[band] : best[band]);
        const least = body.spring ? Infinity : 1 / impedance[band], driven = others < least ? others : least;
        if (driven !== mobility[band]) this._isCarried = true;
        mobility[band] = driven;
      }
    }
  }

  /** What passes from a node over its contact. */
  _pass({contact, item, partner, mobility, gains}) {
    const [stiffness, own] = contact.function.spring, soft = stiffness < Infinity || item.body.spring;
    const loss = stiffness < Infinity ? own : soft?.[1];
    for (let band = 0; band < BANDS; band++) {
      const load = partner.impedance[band];
      if (soft) {
        const above = Math.max(load * (mobility[band] + this._omega[band] / stiffness), 2) - 1;
        gains[band] = Math.sqrt((1 + loss * loss) / (above * above + loss * loss));
      } else gains[band] = Math.min(2 / (1 + load * mobility[band]), 1);
    }
  }

  /** The cost of leaving an object through a node over its contact. */
  _crossing({contact, gains}, lane) {
    const {loss, decay} = contact.function, own = loss[lane] + decay[lane] * contact.distance + contact.rest;
    return contact.byBodies ? own - Math.log(lane ? gains[lane - 1] : Math.max(...gains)) : own;
  }

  // Best paths.

  _propagate(source) {
    const {lanes, listeners} = this, {signal} = source;
    if (source.paths.length !== listeners.length || source.gains.length !== listeners.length * lanes) {
      source.paths = listeners.map(() => []);
      source.gains = new Float64Array(listeners.length * lanes);
      for (const key of ["before", "now"]) source[key] = new Float64Array(listeners.length * BANDS);
      for (const key of ["late", "later"]) source[key] = new Float64Array(listeners.length);
    }
    source.gains.fill(0);
    source.before.set(source.now);
    source.late.set(source.later);
    for (const path of source.paths) path.length = 0;
    if (source.amplitude > 0 && source.voices) {
      this._search(source, signal.lane);
      if (!this._collect(source) && signal.lane) {
        this._search(source, 0);
        this._collect(source);
      }
    }
    for (let k = 0; k < listeners.length; k++) {
      for (let row = 0; row < signal.rows.length; row++) {
        let gain = 0;
        for (let lane = 0; lane < lanes; lane++) gain += signal.mix[row][lane] * source.gains[k * lanes + lane];
        source.now[k * BANDS + row] = gain * source.amplitude * listeners[k].gain;
      }
    }
    if (!source.began) return;
    source.began = false;
    source.before.set(source.now);
    source.late.set(source.later);
  }

  _distance(a, b) {
    return Math.max(between(a, b) - a.reach - b.reach, 0);
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
    let limit = LIMIT;
    this._size = 0;
    for (const node of source.nodes) {
      node.arrival = Infinity;
      this._push((node.entering = 0), node);
    }
    while (this._size && this._keys[0] <= limit) {
      let near = this._keys[0], isNearer = false;
      const begin = this._pop(), {nodes, count, function: own} = begin.item;
      if (near > begin.entering) continue;
      near += own.loss[lane];
      if (begin.arrival <= near && !this._isSpecial) continue;
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
        const over = end.partner;
        if (far > limit || far >= over.entering || (far + over.item.function.loss[lane] >= over.arrival && !this._isSpecial)) continue;
        over.entering = far;
        this._push(far, over);
      }
      // No more than what each listener costs now is of interest.
      if (isNearer) limit = Math.min(limit, this.listeners.reduce((dearest, {node}) => Math.max(dearest, node.arrival), 0));
    }
  }

  /** Take gains and paths to the listeners without any from the last search. Whether all have one then. */
  _collect(source) {
    const {lanes, listeners, _costs: costs} = this;
    let all = true;
    for (let k = 0; k < listeners.length; k++) {
      const path = source.paths[k];
      let {node} = listeners[k], late = 0;
      if (path.length) continue;
      all &&= node.entry !== null;
      if (!node.entry) continue;
      costs.fill(0);
      while (node) {
        const begin = node.entry, {function: own} = node.item, distance = this._distance(begin, node), shape = own.shape(distance, begin, node);
        const number = this.objects.indexOf(node.item);
        if (number !== path.at(-1)) path.push(number);
        late += own.slowness * distance;
        node = begin.partner;
        if (node) late += begin.contact.function.slowness * begin.contact.distance;
        for (let lane = 0; lane < lanes; lane++) costs[lane] += own.loss[lane] + own.decay[lane] * distance + shape + (node ? this._crossing(node, lane) : 0);
      }
      path.reverse();
      for (let lane = 0; lane < lanes; lane++) source.gains[k * lanes + lane] = Math.exp(-costs[lane]);
      source.later[k] = late * this.sample_rate;
    }
    return all;
  }

  _push(key, value) {
    const {_keys: keys, _values: values} = this;
    let place = this._size++, above;
    for (; place > 0 && keys[(above = (place - 1) >> 1)] > key; place = above) {
      keys[place] = keys[above];
      values[place] = values[above];
    }
    keys[place] = key;
    values[place] = value;
  }

  _pop() {
    const {_keys: keys, _values: values} = this, first = values[0], size = --this._size, key = keys[size];
    let place = 0, below;
    for (; (below = 2 * place + 1) < size; place = below) {
      if (below + 1 < size && keys[below + 1] < keys[below]) below++;
      if (keys[below] >= key) break;
      keys[place] = keys[below];
      values[place] = values[below];
    }
    keys[place] = key;
    values[place] = values[size];
    return first;
  }

  // Samples.

  _mix() {
    const {count, listeners, _voices: voices} = this, window = this.sample_rate / 4;
    for (const listener of listeners) {
      if (listener.samples.length < count) listener.samples = new Float32Array(2 * count);
      listener.recent ??= new Float32Array(window);
      listener.samples.fill(0);
    }
    for (let k = voices.length - 1; k >= 0; k--) {
      const voice = voices[k], {source, source: {signal}} = voice;
      let longest = 0;
      for (let number = 0; number < listeners.length; number++) {
        this._hear(voice, number);
        longest = Math.max(longest, source.later[number]);
      }
      voice.place += count;
      if (signal.loops && voice.place > 2 * signal.length + longest) voice.place -= signal.length;
      if (signal.loops || voice.place < signal.length + longest) continue;
      voices.splice(k, 1);
      if (--source.voices === 0 && source.second !== null) this.blows.splice(this.blows.indexOf(source), 1);
    }
    for (const {samples, recent, s_max} of listeners) {
      for (let k = 0; k < count; k++) {
        samples[k] = Math.max(-s_max, Math.min(samples[k], s_max));
        recent[(this._recentPlace + k) % window] = samples[k];
      }
    }
    this._recentPlace = (this._recentPlace + count) % window;
    this._recentCount = Math.min(this._recentCount + count, window);
  }

  /** Add a voice to the samples of a listener; its gains go in straight lines over the step. */
  _hear({source, place}, number) {
    const {count} = this, {samples} = this.listeners[number], {signal: {rows, loops, length}, late, later} = source;
    const drift = (later[number] - late[number]) / count;
    for (let r = 0; r < rows.length; r++) {
      const row = rows[r], gain = source.before[number * BANDS + r], slope = (source.now[number * BANDS + r] - gain) / count;
      if (gain === 0 && slope === 0) continue;
      for (let k = 0; k < count; k++) {
        const at = place + k - late[number] - drift * k, whole = Math.floor(at), share = at - whole;
        if (whole < 0 || (whole >= length && !loops)) continue;
        const value = row[whole % length];
        samples[k] += (gain + slope * k) * (share ? value + share * (row[(whole + 1) % length] - value) : value);
      }
    }
  }
}

/** The normal of a contact of which an engine tells none. */
const NOWHERE = vector([NaN, NaN, NaN]);

function put(to, {x, y, z}) {
  to.x = x;
  to.y = y;
  to.z = z;
}
