// Two crates of Rapier fall onto each other on a ground, in the folder of the sample with what npm installs, and are traced.
//     node rapier.mjs

import RAPIER from "@dimforge/rapier3d-compat";
import {contactsOfRapier, Listener, Signal, Source, TracedFunction, TracedObject, Tracer} from "./haptic-tracer.js";

await RAPIER.init();
const world = new RAPIER.World({x: 0, y: -9.81, z: 0});
const tracer = new Tracer(), numbers = new Map(), bodies = [];
for (const [size, description] of [
  [[10, 0.5, 10], RAPIER.RigidBodyDesc.fixed().setTranslation(0, -0.5, 0)],
  [[0.25, 0.25, 0.25], RAPIER.RigidBodyDesc.dynamic().setTranslation(1, 0.3, 0)],
  [[0.25, 0.25, 0.25], RAPIER.RigidBodyDesc.dynamic().setTranslation(1, 0.9, 0)],
]) {
  const body = world.createRigidBody(description);
  numbers.set(world.createCollider(RAPIER.ColliderDesc.cuboid(...size).setDensity(40), body).handle, bodies.push(body) - 1);
  tracer.objects.push(new TracedObject({function: new TracedFunction({decay: [0.2]})}));
}
tracer.sources.push(new Source({object: 0, position: [0, 0.5, 0], signal: Signal.tone(80)}));
tracer.listeners.push(new Listener({object: 2, position: [0, 0.25, 0]}));
let contacts = [];
for (let k = 0; k < 180; k++) {
  world.step();
  bodies.forEach((body, number) => {
    const place = body.translation(), turn = body.rotation();
    tracer.objects[number].move(place.x, place.y, place.z, turn.w, turn.x, turn.y, turn.z);
  });
  contacts = contactsOfRapier(world, numbers);
  tracer.setContacts(contacts);
  tracer.step(1 / 60);
}
const [source] = tracer.sources;
console.log(JSON.stringify({contacts, gain: source.gain(0), path: source.heard[0].path, level: tracer.level(0)}));
