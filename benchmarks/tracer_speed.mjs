// The time of a step of the tracer: the file of its tables, and the contacts, a line of numbers each, of standard input.

import {readFileSync} from "node:fs";
import {Tracer} from "../clients/javascript/haptic-tracer.js";

const WARM = 200, STEPS = 400;
const tracer = Tracer.read(readFileSync(process.argv[2], "utf8"));
const rows = readFileSync(0, "utf8").trim().split("\n").map(line => line.split(" ").map(Number));
const contacts = rows.map(([one, other, x, y, z, a, b, c, area]) => ({one, other, at: {x, y, z}, normal: {x: a, y: b, z: c}, area}));
const times = [];
let processor = null;
for (let step = 0; step < WARM + STEPS; step++) {
  if (step === WARM) processor = process.cpuUsage();
  const begun = performance.now();
  rows.forEach((row, k) => { contacts[k].at.z = row[4] + 1e-4 * (step % 8); });
  tracer.setContacts(contacts);
  tracer.step(1 / 60);
  tracer.listeners.forEach((_, k) => tracer.level(k));
  if (step >= WARM) times.push(performance.now() - begun);
}
processor = process.cpuUsage(processor);
times.sort((a, b) => a - b);
const heard = tracer.sources.flatMap(source => source.heard).filter(({path}) => path.length).length;
const milliseconds = [times[0], times[STEPS / 2], (processor.user + processor.system) / 1000 / STEPS].map(value => value.toFixed(3));
console.log(tracer.objects.length, contacts.length, heard, ...milliseconds);
