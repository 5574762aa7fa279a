/**
 * A client of `haptic-tracing serve`: sends poses, receives what each listener feels. ES module, no dependencies; for browsers and Node 22.
 *
 * const haptics = new HapticTracing("ws://127.0.0.1:7710", {up: "y"});
 * await haptics.open();
 * haptics.addEventListener("levels", event => console.log(event.detail));
 * haptics.step(time, {Crate: [x, y, z, qw, qx, qy, qz]});
 *
 * Events: "scene" (what the run has), "levels" (by listener: level, margin, gains), "impact", "samples" (Float32Array per listener),
 * "fault" (where, message), "close".
 */
export class HapticTracing extends EventTarget {
  /**
   * @param {string} url of the server
   * @param {{token?: string, scene?: object, up?: "y"|"z", handedness?: "right"|"left", metres_per_unit?: number, sample_rate?: number,
   *   samples?: boolean}} options those of `hello`; samples: whether each step asks for its samples
   */
  constructor(url, options = {}) {
    super();
    const {samples = false, ...hello} = options;
    this.url = url;
    this.scene = null;
    this._hello = hello;
    this._samples = samples;
    this._sent = new Map();
    this._frame = null;
    this._waiting = null;
    this._next = null;
  }

  /** Connect; resolves with the scene: its objects, sources and listeners. */
  open() {
    return new Promise((resolve, reject) => {
      this._socket = new WebSocket(this.url);
      this._socket.binaryType = "arraybuffer";
      this._socket.onopen = () => this._send({type: "hello", version: 1, ...this._hello});
      this._socket.onerror = () => reject(new Error(`${this.url} does not answer`));
      this._socket.onclose = () => {
        reject(new Error(`${this.url} has closed the connection`));
        this._tell("close", null);
      };
      this._socket.onmessage = event => this._receive(event.data);
      this.addEventListener("scene", event => resolve(event.detail), {once: true});
      this.addEventListener("fault", event => reject(new Error(`${event.detail.where}: ${event.detail.message}`)), {once: true});
    });
  }

  /** End the connection; devices fall silent. */
  close() {
    this._socket.close();
  }

  /**
   * Send where things are. Only poses that have changed go over the wire, and no step while one is unanswered: the newest waits.
   * @param {number} time in seconds
   * @param {Object<string, number[]>} poses by object: x, y, z, qw, qx, qy, qz
   * @param {object} more sources, contacts, impacts, source_positions, listener_positions
   */
  step(time, poses = {}, more = {}) {
    const now = this._next ?? {poses: new Map(), impacts: [], more: {}};
    for (const [name, pose] of Object.entries(poses)) now.poses.set(name, pose);
    const {impacts = null, ...rest} = more;
    if (impacts) now.impacts.push(...impacts);
    now.given = now.given || impacts !== null;
    Object.assign(now.more, rest);
    now.time = time;
    this._next = now;
    this._flush();
  }

  /** Play the signal of a source with triggers once. */
  play(source) {
    this._send({type: "play", source});
  }

  /** Fall silent and forget contacts. */
  stop() {
    this._sent.clear();
    this._send({type: "stop"});
  }

  /** Add what is given as in a scene file: object, source, listener. */
  add(parts) {
    this._send({type: "add", ...parts});
  }

  /** Replace what has the same name. */
  replace(parts) {
    this._send({type: "replace", ...parts});
  }

  /** Remove by name: {object}, {source} or {listener}. */
  remove(parts) {
    if (parts.object) this._sent.delete(parts.object);
    this._send({type: "remove", ...parts});
  }

  /**
   * Shake a gamepad, or a controller of WebXR (`inputSource.gamepad`), with the level of a listener in decibels, null for silence, for the
   * given milliseconds.
   */
  static rumble(gamepad, level, milliseconds = 60) {
    const magnitude = level === null ? 0 : Math.min(Math.max(Math.SQRT2 * 10 ** (level / 20), 0), 1);
    const actuator = gamepad?.vibrationActuator ?? gamepad?.hapticActuators?.[0];
    return actuator?.playEffect
      ? actuator.playEffect("dual-rumble", {duration: milliseconds, strongMagnitude: magnitude, weakMagnitude: magnitude})
      : actuator?.pulse?.(magnitude, milliseconds);
  }

  _flush() {
    const now = this._next;
    if (!now || this._waiting || this.scene === null) return;
    const poses = {};
    for (const [name, pose] of now.poses) {
      const key = pose.join();
      if (this._sent.get(name) !== key) {
        this._sent.set(name, key);
        poses[name] = Array.from(pose);
      }
    }
    this._next = null;
    this._waiting = true;
    const impacts = now.given ? {impacts: now.impacts} : {};
    this._send({type: "step", time: now.time, poses, samples: this._samples, ...impacts, ...now.more});
  }

  _send(message) {
    if (this._socket?.readyState === WebSocket.OPEN) this._socket.send(JSON.stringify(message));
  }

  _receive(data) {
    if (typeof data !== "string") {
      const samples = new Float32Array(data);
      const {n, listeners} = this._frame;
      this._tell("samples", Object.fromEntries(listeners.map((name, row) => [name, samples.subarray(row * n, (row + 1) * n)])));
      return;
    }
    const message = JSON.parse(data);
    if (message.type === "scene") {
      this.scene = message;
      this._tell("scene", message);
    } else if (message.type === "frame") {
      this._frame = message;
      this._waiting = null;
      this._tell("levels", message.levels);
      for (const impact of message.impacts) this._tell("impact", impact);
    } else if (message.type === "error") {
      this._waiting = null;
      this._tell("fault", message);
    }
    this._flush();
  }

  _tell(name, detail) {
    this.dispatchEvent(new CustomEvent(name, {detail}));
  }
}

/** A body seen from the front, in an SVG element, whose parts are as red as they are felt. */
export class BodyMap {
  /**
   * @param {SVGElement} svg the element, in which the figure is 2 high
   * @param {object} table that of `body-map.json`
   */
  constructor(svg, table) {
    this._limbs = new Map();
    const {midline, left} = table.front;
    // The table is as seen from behind: from the front, the wearer's left is to the right.
    const rows = [...midline.map(row => [row.part, row, -1]), ...left.flatMap(row => [[`${row.part}.L`, row, -1], [`${row.part}.R`, row, 1]])];
    for (const [part, {start, end, width}, mirror] of rows) {
      const line = document.createElementNS("http://www.w3.org/2000/svg", "line");
      const values = {x1: mirror * start[0], y1: 2 - start[1], x2: mirror * end[0], y2: 2 - end[1], "stroke-width": width, "data-part": part};
      for (const [key, value] of Object.entries(values)) line.setAttribute(key, value);
      svg.append(line);
      this._limbs.set(part, line);
    }
    this.show({}, {});
  }

  /** Show levels, by listener, at their body parts, by listener: grey for silence, red from -60 to 0 dB. */
  show(levels, parts) {
    for (const limb of this._limbs.values()) limb.setAttribute("stroke", "#bbb");
    for (const [listener, {level}] of Object.entries(levels)) {
      const strength = level === null ? 0 : Math.min(Math.max(1 + level / 60, 0), 1);
      if (strength) this._limbs.get(parts[listener])?.setAttribute("stroke", `hsl(0, ${100 * strength}%, ${75 - 25 * strength}%)`);
    }
  }
}
