// Plays a script of steps to the tracer and prints what comes back, a line of JSON for each step.
//     node judge.mjs < script

import {readFileSync} from "node:fs";
import {Tracer} from "../../clients/javascript/haptic-tracer.js";

let tracer = null, contacts = [];
const at = (numbers, place) => ({x: numbers[place], y: numbers[place + 1], z: numbers[place + 2]});
const placed = (node, numbers) => {
  const [x, y, z] = tracer.objects[node.object].toLocal(at(numbers, 1));
  node.position = {x, y, z};
};
const heard = source => ({
  amplitude: source.amplitude,
  gains: tracer.listeners.map((_, k) => source.gain(k)),
  delays: source.heard.map(({later}) => later),
  lanes: source.heard.flatMap(({gains}) => [...gains.slice(0, tracer.lanes)]),
  paths: source.heard.map(({path}) => path),
});
const words = {
  move: ([number, ...pose]) => tracer.objects[number].move(...pose),
  touch: n => contacts.push({
    one: n[0], other: n[1], at: at(n, 2), otherAt: at(n, 5), normal: at(n, 8), area: n[11], force: n[12], depth: n[13], weight: n[14],
  }),
  part: () => { contacts = []; },
  amplitude: ([number, amplitude]) => { tracer.sources[number].amplitude = amplitude; },
  source: n => placed(tracer.sources[n[0]].nodes[0], n),
  listener: n => placed(tracer.listeners[n[0]].node, n),
  play: ([number]) => tracer.play(tracer.sources[number]),
  blow: n => tracer.blow(n[0], n[1], at(n, 2), n[5], n[6]),
  step: ([seconds]) => {
    tracer.setContacts(contacts);
    tracer.step(seconds);
    const levels = tracer.listeners.map((_, k) => tracer.level(k));
    console.log(JSON.stringify({levels, count: tracer.count, sources: tracer.sources.map(heard), blows: tracer.blows.map(heard)}));
  },
};
for (const line of readFileSync(0, "utf8").split("\n")) {
  const [word, ...numbers] = line.split(" ");
  if (word === "read") {
    tracer = Tracer.read(readFileSync(line.slice(5), "utf8"));
    contacts = [];
  } else words[word](numbers.map(Number));
}
