"use strict";
// Charts: classes as bars, properties as histograms stacked by class. Clicking filters the pictures.

const make = (tag, attributes = {}, ...children) => {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value !== null && value !== false) element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children);
  return element;
};

const shape = (tag, attributes, ...children) => {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
};

const short = value => Math.abs(value) >= 1000 ? value.toLocaleString("en") : String(+value.toPrecision(3));

const classChart = (data, choose) => {
  const most = Math.max(1, ...data.classes.map(each => each.objects));
  const rows = data.classes.map((each, index) => make("button", {
    style: `--c:${each.color}`, title: `Only pictures with ${each.name}`,
    onclick: () => choose({ text: `pictures with ${each.name}`, keep: object => object.class === index }),
  }, make("span", {}, each.name), make("i", { style: `width:${100 * each.objects / most}%` }),
    make("b", {}, each.objects.toLocaleString("en"), make("small", {}, `in ${each.frames.toLocaleString("en")}`))));
  const empty = make("p", { class: "none" }, "No objects in any label file.");
  return make("section", { class: "card" }, make("h2", {}, "Objects per class"),
    make("p", { class: "unit" }, "objects, and pictures that show any"),
    make("div", { class: "classes" }, ...(rows.length ? rows : [empty])));
};

const histogramChart = (data, histogram, choose) => {
  const width = 420, height = 170, left = 34, bottom = 22;
  const edges = histogram.edges, bins = edges.length - 1;
  const stacks = Object.entries(histogram.counts);
  const totals = Array.from({ length: bins }, (_, bin) => stacks.reduce((sum, [, counts]) => sum + counts[bin], 0));
  const most = Math.max(1, ...totals);
  const x = bin => left + (width - left) * bin / bins;
  const y = count => (height - bottom) * (1 - count / most) + 6;
  const svg = shape("svg", { viewBox: `0 0 ${width} ${height + 8}`, role: "img", "aria-label": histogram.title });
  for (const count of [0, most / 2, most]) {
    svg.append(shape("line", { class: "grid", x1: left, x2: width, y1: y(count), y2: y(count) }));
    if (Number.isInteger(count)) svg.append(shape("text", { x: left - 6, y: y(count) + 4, "text-anchor": "end" }, short(count)));
  }
  const groups = [];
  totals.forEach((total, bin) => {
    const group = shape("g", { class: "bin" });
    const range = histogram.key === "objects" && edges[bin + 1] - edges[bin] === 1
      ? short(edges[bin]) : `${short(edges[bin])} – ${short(edges[bin + 1])}`;
    const parts = stacks.filter(([name, counts]) => name && counts[bin]).map(([name, counts]) => `${name}: ${counts[bin]}`);
    group.append(shape("title", {}, [`${range}: ${total}`, ...parts].join("\n")));
    group.append(shape("rect", { class: "hit", x: x(bin), y: 0, width: x(bin + 1) - x(bin), height: height - bottom + 6 }));
    let below = 0;
    for (const [name, counts] of stacks) {
      if (!counts[bin]) continue;
      const color = data.classes.find(each => each.name === name)?.color ?? "var(--accent)";
      const top = y(below + counts[bin]);
      group.append(shape("rect", { x: x(bin) + .8, y: top, width: Math.max(1, x(bin + 1) - x(bin) - 1.6), height: Math.max(.6, y(below) - top), fill: color, rx: 1 }));
      below += counts[bin];
    }
    const low = edges[bin], high = edges[bin + 1], last = bin === bins - 1;
    const inside = value => value !== undefined && value >= low && (value < high || last && value <= high + 1e-9);
    group.addEventListener("click", () => {
      groups.forEach(each => each.removeAttribute("data-on"));
      group.setAttribute("data-on", "");
      choose({
        text: `${histogram.title.toLowerCase()} ${range}`, group,
        ...(histogram.key === "objects" ? { keepFrame: frame => frame.labeled && inside(frame.objects.length) }
          : { keep: object => inside(object[histogram.key]) }),
      });
    });
    if (!total) group.style.pointerEvents = "none";
    groups.push(group);
    svg.append(group);
  });
  // Whole numbers stand below the middle of their bar, other edges below the gap between two.
  const whole = histogram.key === "objects" && edges[1] - edges[0] === 1;
  const ticks = Math.min(bins, 5);
  for (let tick = 0; tick <= ticks - whole; tick++) {
    const bin = Math.round((bins - whole) * tick / Math.max(1, ticks - whole));
    const anchor = whole ? "middle" : tick === 0 ? "start" : tick === ticks ? "end" : "middle";
    svg.append(shape("text", { x: x(bin + (whole ? 0.5 : 0)), y: height + 6, "text-anchor": anchor }, short(edges[bin])));
  }
  return make("section", { class: "card" }, make("h2", {}, histogram.title),
    make("p", { class: "unit" }, `${histogram.unit} · median ${short(histogram.median)} · ${histogram.objects.toLocaleString("en")} ${histogram.key === "objects" ? "pictures" : "objects"}`), svg);
};
