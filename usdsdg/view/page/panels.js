// The panels beside the picture. Every name is set as text, never as HTML.

export const byId = (id) => document.getElementById(id);

export function element(tag, values = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(values)) {
    if (name in made) made[name] = value;
    else made.setAttribute(name, value);
  }
  made.append(...children);
  return made;
}

export const counted = (count, noun) => `${count} ${noun}${count === 1 ? "" : "s"}`;

const PATHS = new Set(["path", "gprim", "material", "body"]);
const UNITS = {
  position: "m", point: "m", size: "m", distance: "m", velocity: "m/s", "angular velocity": "°/s", rotation: "(w x y z)",
};
const number = (value) => String(Number(value.toFixed(4)));

export function showSelection(facts, ask) {
  const panel = byId("selection");
  if (!facts) {
    panel.replaceChildren(element("p", { className: "soft", textContent: "Click a thing in the picture." }));
    return;
  }
  const list = element("dl");
  for (const [name, value] of Object.entries(facts)) {
    if (value === null || value === undefined) continue;
    if (name === "labels") {
      for (const [kind, labels] of Object.entries(value)) row(list, kind, labels, "label");
    } else {
      const text = Array.isArray(value) ? value.map(number).join("  ") : typeof value === "number" ? number(value) : value;
      row(list, name, UNITS[name] ? `${text} ${UNITS[name]}` : String(text), PATHS.has(name) ? "path" : "");
    }
  }
  const frame = element("button", { textContent: "look at it", title: "F" });
  frame.onclick = () => ask({ do: "frame", what: "selection" });
  const drop = element("button", { textContent: "deselect" });
  drop.onclick = () => ask({ do: "pick", at: null });
  panel.replaceChildren(list, element("div", { className: "row" }, frame, drop));
}

function row(list, name, value, kind) {
  list.append(element("dt", { textContent: name }), element("dd", { textContent: value, className: kind }));
}

export function showCameras(cameras, ask) {
  const panel = byId("cameras");
  const same = cameras.length === panel.children.length && cameras.every((each, i) => panel.children[i].dataset?.path === each.path);
  if (same && cameras.length) return;
  panel.replaceChildren(
    ...cameras.map(({ path, size }) => {
      const shape = size[0] > 0 ? ` (${size[0]} × ${size[1]})` : "";
      const button = element("button", { title: `${path}${shape}` },
        element("canvas", { width: 160, height: 120 }), element("span", { textContent: path.split("/").pop() }));
      button.dataset.path = path;
      button.onclick = () => ask({ do: "through", camera: button.getAttribute("aria-pressed") === "true" ? null : path });
      return button;
    }),
  );
  if (!cameras.length) panel.append(element("p", { className: "soft", textContent: "The stage has none." }));
}

export function markCamera(path) {
  for (const button of byId("cameras").querySelectorAll("button")) {
    button.setAttribute("aria-pressed", String(button.dataset.path === path));
  }
}

export function drawCamera(path, bitmap) {
  for (const button of byId("cameras").querySelectorAll("button")) {
    if (button.dataset.path === path) paint(button.querySelector("canvas"), bitmap);
  }
}

export function paint(canvas, bitmap) {
  if (canvas.width !== bitmap.width || canvas.height !== bitmap.height) {
    canvas.width = bitmap.width;
    canvas.height = bitmap.height;
  }
  canvas.getContext("2d").drawImage(bitmap, 0, 0);
}

export function showClasses(classes) {
  byId("classes-card").hidden = !classes;
  byId("classes").replaceChildren(
    ...(classes ?? []).map(([name, [red, green, blue]]) => {
      // An attribute of SVG, which the policy of the page lets pass where it refuses styles.
      const dot = document.createElementNS("http://www.w3.org/2000/svg", "svg");
      const square = document.createElementNS("http://www.w3.org/2000/svg", "rect");
      for (const [key, value] of Object.entries({ width: 10, height: 10, rx: 3, fill: `rgb(${red},${green},${blue})` })) {
        square.setAttribute(key, value);
      }
      dot.append(square);
      return element("span", {}, dot, name || "(no name)");
    }),
  );
}
