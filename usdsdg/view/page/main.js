// The page of `usdsdg view`: it sends what is wanted, and shows the pictures and values that come back.

import { Connection } from "./connection.js";
import { byId, counted, drawCamera, element, markCamera, paint, showCameras, showClasses, showSelection } from "./panels.js";
import { follow } from "./pointer.js";

const NAMES = { paths: "color", classes: "classes", instances: "instances", amodal: "amodal", depth: "depth", normals: "normals" };
const MOST_PIXELS = 640 * 480;
const canvas = byId("canvas");
let state = {};
let scene = { modes: [], triggers: [] };
let mode = "paths";
let pictures = 0;

const connection = new Connection({ told, shown, ended });
const ask = (wish) => connection.ask(wish);

function told(values) {
  if ("error" in values) say(values.error);
  if ("scene" in values) showScene(values.scene);
  if ("state" in values) showState(values.state);
  if ("selection" in values) showSelection(values.selection, ask);
  if ("through" in values) {
    markCamera(values.through);
    byId("free").hidden = !values.through;
  }
}

function showScene(values) {
  scene = values;
  document.title = `${scene.title} – usdsdg view`;
  byId("title").textContent = scene.title;
  byId("facts").textContent = `${counted(scene.gprims, "gprim")} · ${scene.device}`;
  byId("notes").replaceChildren(...scene.notes.map((text) => element("p", { textContent: text })));
  byId("triggers").textContent = scene.triggers.length ? scene.triggers.join(", ") : "The stage has no triggers.";
  byId("randomize").disabled = byId("seed").disabled = !scene.triggers.length;
  if (!byId("modes").children.length) {
    byId("modes").append(...scene.modes.map((name, index) => {
      const button = element("button", { textContent: NAMES[name] ?? name, role: "radio", title: `${index + 1}` });
      button.dataset.mode = name;
      button.onclick = () => choose(name);
      return button;
    }));
    choose(mode);
    fit();
  }
  showCameras(scene.cameras, ask);
}

function choose(name) {
  mode = name;
  for (const button of byId("modes").children) button.setAttribute("aria-checked", String(button.dataset.mode === name));
  ask({ do: "mode", name });
}

function showState(values) {
  state = values;
  byId("play").textContent = state.playing ? "❚❚ pause" : "▶ play";
  byId("time").textContent = `${state.time.toFixed(2)} s`;
  byId("frames").hidden = state.frame === null;
  if (state.frame !== null) byId("frame").textContent = `frame ${state.frame}`;
  byId("next").disabled = Boolean(state.busy);
  if (state.busy) byId("about").textContent = state.busy;
}

function shown(header, bitmap) {
  if ("camera" in header) {
    drawCamera(header.camera, bitmap);
    return;
  }
  paint(canvas, bitmap);
  pictures += 1;
  canvas.dataset.pictures = String(pictures);
  canvas.dataset.mode = header.mode;
  byId("wait").hidden = true;
  byId("error").hidden = true;
  const parts = [`${header.width} × ${header.height}`, `${header.milliseconds} ms`];
  if ("samples" in header) parts.push(counted(header.samples, "sample"));
  if ("objects" in header) parts.push(counted(header.objects, "object"));
  if ("hidden" in header) parts.push(`${header.hidden} partly hidden`);
  byId("about").textContent = parts.join(" · ");
  byId("depth-scale").hidden = !header.depth;
  if (header.depth) {
    const ends = header.depth.map((meters) => element("b", { textContent: `${meters.toPrecision(3)} m` }));
    byId("depth-scale").querySelector("span").replaceChildren(...ends);
  }
  showClasses(header.classes);
}

function ended(why) {
  say(why || "The viewer has ended. Start it again and open its new address.");
}

function say(text) {
  byId("error").textContent = text;
  byId("error").hidden = false;
}

// Where an event is: parts of the picture's width and height, null outside of it, and its height on the screen.
function place(event) {
  const box = canvas.getBoundingClientRect();
  const scale = Math.min(box.width / canvas.width, box.height / canvas.height);
  const [width, height] = [canvas.width * scale, canvas.height * scale];
  const x = (event.clientX - box.left - (box.width - width) / 2) / width;
  const y = (event.clientY - box.top - (box.height - height) / 2) / height;
  return { at: x >= 0 && x < 1 && y >= 0 && y < 1 ? [x, y] : null, height };
}

// Pictures have the shape of their place on the page, and about as many pixels as 640 x 480.
function fit() {
  const { clientWidth: width, clientHeight: height } = canvas;
  if (!width || !height) return;
  const scale = Math.min(1, Math.sqrt(MOST_PIXELS / (width * height)));
  ask({ do: "size", width: Math.max(16, Math.round(width * scale)), height: Math.max(16, Math.round(height * scale)) });
}

let fitting = 0;
new ResizeObserver(() => {
  clearTimeout(fitting);
  fitting = setTimeout(fit, 120);
}).observe(canvas);

const seed = () => {
  const value = Math.floor(Number(byId("seed").value));
  return Number.isFinite(value) && value >= 0 && value < 2 ** 53 ? value : 0;
};
const actions = {
  play: () => ask({ do: state.playing ? "pause" : "play" }),
  step: () => ask({ do: "step" }),
  reset: () => ask({ do: "reset" }),
  next: () => ask({ do: "next" }),
  all: () => ask({ do: "frame", what: "all" }),
  free: () => ask({ do: "through", camera: null }),
  look: () => ask({ do: "frame", what: "selection" }),
  randomize: () => {
    ask({ do: "randomize", seed: seed() });
    byId("seed").value = String(seed() + 1);
  },
  theme: () => {
    const root = document.documentElement;
    root.dataset.theme = root.dataset.theme === "dark" ? "light" : "dark";
  },
  help: () => byId("help").showModal(),
};
const BUTTONS = {
  play: "play", step: "step", reset: "reset", next: "next", randomize: "randomize",
  "frame-all": "all", free: "free", theme: "theme", "help-open": "help",
};
for (const [id, name] of Object.entries(BUTTONS)) byId(id).onclick = actions[name];

const KEYS = [
  [" ", "Space", "play or pause the physics", "play"],
  [".", ".", "one time code", "step"],
  ["r", "R", "physics back to the beginning", "reset"],
  ["x", "X", "run the triggers with the next seed", "randomize"],
  ["n", "N", "the script's next frame", "next"],
  ["h", "H", "see everything", "all"],
  ["f", "F", "look at what is selected", "look"],
  ["Escape", "Esc", "orbit freely from the camera", "free"],
  ["t", "T", "light or dark", "theme"],
  ["?", "?", "this list", "help"],
];
const ARROWS = { ArrowLeft: [-0.04, 0], ArrowRight: [0.04, 0], ArrowUp: [0, 0.04], ArrowDown: [0, -0.04] };
byId("keys").append(
  ...[...KEYS, ["", "1 … 6", "color, classes, instances, amodal, depth, normals"], ["", "arrows, + −", "orbit, zoom"],
    ["", "drag", "orbit; with Shift or the right button pan; wheel zooms; click selects"]]
    .map(([, shownKey, what]) => element("tr", {}, element("td", {}, element("kbd", { textContent: shownKey })), element("td", { textContent: what }))),
);
addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || byId("help").open) return;
  if (event.target instanceof HTMLInputElement) return;
  if (event.key === " " && event.target instanceof HTMLButtonElement) return;
  const key = KEYS.find(([name]) => name === event.key || name === event.key.toLowerCase());
  if (key) {
    const button = Object.entries(BUTTONS).find(([, name]) => name === key[3]);
    if (!button || !byId(button[0]).disabled) actions[key[3]]();
  } else if (event.key in ARROWS) ask({ do: "turn", by: ARROWS[event.key] });
  else if (event.key === "+" || event.key === "=") ask({ do: "zoom", by: 0.9 });
  else if (event.key === "-") ask({ do: "zoom", by: 1.1 });
  else if (event.key >= "1" && event.key <= String(scene.modes.length)) choose(scene.modes[Number(event.key) - 1]);
  else return;
  event.preventDefault();
});

document.documentElement.dataset.theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
showSelection(null, ask);
follow(canvas, ask, place);
