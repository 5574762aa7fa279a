// Plays the body maps of all modes. `ride` holds the shade of every actuator in every frame, [frame][mode][listener], as bytes.
const byId = (id) => document.getElementById(id);
const shades = Uint8Array.from(atob(ride.levels), (c) => c.charCodeAt(0));
const maps = [...document.querySelectorAll("#player .map")].map((map) => [...map.querySelectorAll(".disc")]);
const pictures = Object.keys(ride.pictures).map(Number);
const slider = byId("time");
const view = byId("view");
let playing = false;
let began = 0;

function show(k) {
  maps.forEach((discs, mode) =>
    discs.forEach((disc, listener) => disc.setAttribute("stroke", ride.shades[shades[(k * maps.length + mode) * ride.listeners + listener]])),
  );
  const frame = ride.first + k;
  const picture = pictures.filter((p) => p <= frame).pop() ?? pictures[0];
  if (picture !== undefined && view.dataset.frame !== String(picture)) {
    view.src = ride.pictures[picture];
    view.dataset.frame = picture;
  }
  const section = ride.sections.filter(([, first]) => first <= frame).pop();
  byId("where").textContent = `${((frame - 1) / ride.rate).toFixed(1)} s, frame ${frame}${section ? ", " + section[0] : ""}`;
}

function stop() {
  playing = false;
  byId("play").textContent = "Play";
}

function step(now) {
  if (!playing) return;
  const k = Math.floor(((now - began) * ride.rate) / 1000);
  if (k >= ride.count) return stop();
  slider.value = k;
  show(k);
  requestAnimationFrame(step);
}

byId("play").onclick = () => {
  if (playing) return stop();
  if (Number(slider.value) >= ride.count - 1) slider.value = 0;
  playing = true;
  byId("play").textContent = "Pause";
  began = performance.now() - (slider.value * 1000) / ride.rate;
  requestAnimationFrame(step);
};
slider.oninput = () => {
  stop();
  show(Number(slider.value));
};
if (!pictures.length) view.remove();
show(0);
