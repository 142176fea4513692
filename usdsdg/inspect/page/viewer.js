// Viewer: one picture with its layers, the strip of all pictures, what is in them, and the keys.
(() => {
  const data = JSON.parse(document.getElementById("dataset").textContent);
  const at = id => document.getElementById(id);
  const EDGES = [[1, 2], [2, 4], [4, 3], [3, 1], [5, 6], [6, 8], [8, 7], [7, 5], [1, 5], [2, 6], [3, 7], [4, 8]];
  const AXES = ["#ff4d4d", "#3ddc62", "#4d8dff"];
  const NAMES = {
    picture: "Picture", normals: "Normals", distance_to_camera: "Distance to camera", distance_to_image_plane: "Distance to image plane",
    semantic_segmentation: "Semantic mask", instance_segmentation: "Instance mask", instance_id_segmentation: "Prim mask",
    panoptic: "Panoptic", ids: "Class ids", colors: "Class colors", instances: "Object numbers", "instance colors": "Object colors",
    depth: "Gray depth", edges: "Edges", shaded_seg: "Shaded segments", bounding_box_2d_tight_fast: "Drawn visible boxes",
    bounding_box_2d_loose_fast: "Drawn whole boxes", bounding_box_3d_fast: "Drawn cuboids",
    box: "Visible boxes", loose: "Whole boxes", outline: "Outlines", keypoints: "Keypoints", cuboid: "Cuboids", axes: "Axes", names: "Names",
  };
  const KEYS = {
    picture: "p", box: "b", loose: "w", outline: "o", keypoints: "k", cuboid: "c", axes: "a", names: "n", semantic_segmentation: "m", instance_segmentation: "i",
    instance_id_segmentation: "j", distance_to_camera: "d", distance_to_image_plane: "e", normals: "u",
  };
  const PICTURES = data.layers;
  const named = name => NAMES[name] ?? name.replaceAll("_", " ").replace(/^./, first => first.toUpperCase());
  const keyed = name => (KEYS[name] ?? "").toUpperCase();

  const odd = new Set(data.problems.flatMap(group => group.list.map(([, frame]) => frame)).filter(Boolean));
  const has = part => data.frames.some(frame => frame.objects.some(object => part === "cuboid" ? object.cuboid || object.edges : object[part]));
  const available = [
    ...(data.frames.some(frame => frame.picture !== null) ? ["picture"] : []),
    ...PICTURES.filter(kind => data.frames.some(frame => frame.layers[kind])),
    ...["box", "loose", "outline", "keypoints", "cuboid", "axes"].filter(has), ...(data.classes.length ? ["names"] : []),
  ];
  const state = {
    index: 0, order: data.frames.map((_, index) => index), filter: null, view: null, hidden: new Set(), chosen: null, hovered: null,
    on: new Set(["picture", "names", "box", "outline", "keypoints", "cuboid", "axes"].filter(name => available.includes(name))),
    opacity: 0.6, zoom: 1, pan: [0, 0],
  };
  if (!available.includes("picture")) state.on.add(available.find(name => PICTURES.includes(name)) ?? "box");

  const frame = () => data.frames[state.order[state.index]];
  const visible = each => each ? each.objects.filter(object => !state.hidden.has(object.class)) : [];

  // Pictures are decoded when they are looked at; the last few are kept.
  const decoded = new Map();
  const image = number => {
    if (number === null || number === undefined) return null;
    let made = decoded.get(number);
    if (!made) {
      made = new Image();
      made.onload = draw;
      made.src = at(`i${number}`).textContent;
      decoded.set(number, made);
      if (decoded.size > 60) decoded.delete(decoded.keys().next().value);
    }
    return made.complete && made.naturalWidth ? made : null;
  };

  // --- drawing ---
  const canvas = at("canvas"), context = canvas.getContext("2d");
  const placing = () => {
    const size = frame()?.size ?? [640, 480], box = canvas.getBoundingClientRect();
    const scale = Math.min(box.width / size[0], box.height / size[1]) * state.zoom;
    return { size, scale, x: (box.width - size[0] * scale) / 2 + state.pan[0], y: (box.height - size[1] * scale) / 2 + state.pan[1] };
  };
  const path = (points, place, closed) => {
    context.beginPath();
    points.forEach(([x, y], index) => context[index ? "lineTo" : "moveTo"](place.x + x * place.scale, place.y + y * place.scale));
    if (closed) context.closePath();
  };
  const stroke = (color, width) => {
    context.lineWidth = width + 2; context.strokeStyle = "rgba(0,0,0,.45)"; context.stroke();
    context.lineWidth = width; context.strokeStyle = color; context.stroke();
  };
  const drawBox = (box, place, color, dashed, filled) => {
    path([[box[0], box[1]], [box[2], box[1]], [box[2], box[3]], [box[0], box[3]]], place, true);
    if (filled) { context.fillStyle = color + "38"; context.fill(); }
    context.setLineDash(dashed ? [6, 4] : []);
    stroke(color, 2);
    context.setLineDash([]);
  };
  const drawCuboid = (object, place, color) => {
    const segments = object.edges ?? (object.cuboid ? EDGES.map(([a, b]) => [...object.cuboid[a], ...object.cuboid[b]]) : []);
    segments.forEach((segment, index) => {
      path([[segment[0], segment[1]], [segment[2], segment[3]]], place, false);
      stroke(color, index < 4 && !object.edges ? 2.6 : 1.4);
    });
  };
  const drawAxes = (axes, place) => {
    for (let axis = 0; axis < 3; axis++) { path([axes[0], axes[axis + 1]], place, false); stroke(AXES[axis], 2.4); }
  };
  const drawOutline = (polygons, place, color, filled) => polygons.filter(Boolean).forEach(points => {
    path(points, place, true);
    if (filled) { context.fillStyle = color + "38"; context.fill(); }
    stroke(color, 1.6);
  });
  const drawKeypoints = (points, place, color) => points.filter(([, , seen]) => seen > 0).forEach(([x, y, seen]) => {
    context.beginPath(); context.arc(place.x + x * place.scale, place.y + y * place.scale, 3.5, 0, 2 * Math.PI);
    context.fillStyle = seen > 1 ? color : "transparent"; context.fill(); stroke(seen > 1 ? "#fff" : color, 1.2);
  });
  const anchor = object => {
    const box = object.box ?? object.loose;
    if (box) return [box[0], box[1]];
    return object.cuboid ? [Math.min(...object.cuboid.map(p => p[0])), Math.min(...object.cuboid.map(p => p[1]))] : null;
  };
  const drawName = (object, place, color) => {
    const corner = anchor(object);
    if (!corner) return;
    const text = data.classes[object.class].name;
    context.font = "600 12px ui-sans-serif, system-ui, sans-serif";
    const width = context.measureText(text).width + 12, limit = canvas.getBoundingClientRect();
    const x = Math.min(Math.max(2, place.x + corner[0] * place.scale), limit.width - width - 2);
    const y = Math.min(Math.max(2, place.y + corner[1] * place.scale - 21), limit.height - 22);
    context.fillStyle = color; context.beginPath(); context.roundRect(x, y, width, 19, 5); context.fill();
    context.fillStyle = "#fff"; context.shadowColor = "rgba(0,0,0,.6)"; context.shadowBlur = 3;
    context.fillText(text, x + 6, y + 13.5); context.shadowBlur = 0;
  };
  const draw = () => {
    const box = canvas.getBoundingClientRect(), ratio = window.devicePixelRatio || 1;
    canvas.width = Math.max(1, Math.round(box.width * ratio)); canvas.height = Math.max(1, Math.round(box.height * ratio));
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const shown = frame();
    if (!shown) return;
    const place = placing(), [width, height] = [place.size[0] * place.scale, place.size[1] * place.scale];
    const put = (number, opacity, smooth) => {
      const picture = image(number);
      if (!picture) return;
      context.globalAlpha = opacity; context.imageSmoothingEnabled = smooth; context.imageSmoothingQuality = "high";
      context.drawImage(picture, place.x, place.y, width, height); context.globalAlpha = 1;
    };
    const base = state.on.has("picture") && shown.picture !== null;
    if (base) put(shown.picture, 1, state.zoom < 4);
    const chosen = PICTURES.filter(kind => state.on.has(kind) && shown.layers[kind]);
    // A frame without a picture shows its first layer where no other is chosen.
    const over = chosen.length || shown.picture !== null || !state.on.has("picture") ? chosen : PICTURES.filter(kind => shown.layers[kind]).slice(0, 1);
    for (const kind of over) {
      put(shown.layers[kind].image, base ? state.opacity : 1, !shown.layers[kind].sharp);
    }
    const depth = over.filter(kind => kind.startsWith("distance")).pop();
    at("depth-scale").style.display = depth ? "block" : "none";
    if (depth) {
      const [near, far] = shown.layers[depth].values;
      at("depth-scale").replaceChildren(make("i"), make("span", {}, make("b", {}, `${short(near)} m`), make("b", {}, `${short(far)} m`)));
    }
    const focus = state.hovered ?? state.chosen;
    for (const object of visible(shown)) {
      const color = data.classes[object.class].color;
      context.globalAlpha = focus && focus !== object ? 0.25 : 1;
      if (state.on.has("loose") && object.loose) drawBox(object.loose, place, color, true, focus === object && !object.box);
      if (state.on.has("box") && object.box && !(state.on.has("outline") && object.outline)) drawBox(object.box, place, color, false, focus === object);
      if (state.on.has("outline") && object.outline) drawOutline(object.outline, place, color, focus === object);
      if (state.on.has("keypoints") && object.keypoints) drawKeypoints(object.keypoints, place, color);
      if (state.on.has("cuboid")) drawCuboid(object, place, color);
      if (state.on.has("axes") && object.axes) drawAxes(object.axes, place);
    }
    if (state.on.has("names")) for (const object of visible(shown)) {
      context.globalAlpha = focus && focus !== object ? 0.25 : 1;
      drawName(object, place, data.classes[object.class].color);
    }
    context.globalAlpha = 1;
    if (!base && !over.length && !visible(shown).length) {
      context.fillStyle = "#8d95a1"; context.font = "14px system-ui, sans-serif"; context.textAlign = "center";
      context.fillText(shown.picture === null ? "no picture" : "nothing to show: all layers are off", box.width / 2, box.height / 2);
      context.textAlign = "start";
    }
  };

  // --- what is told about objects ---
  const described = object => [
    object.distance !== undefined ? `${short(object.distance)} m` : null,
    object.visibility !== undefined ? `${Math.round(100 * object.visibility)} % visible` : null,
    object.truncation ? `${Math.round(100 * object.truncation)} % outside` : null,
    object.size !== undefined ? `${Math.round(object.size)} px` : null,
  ].filter(Boolean).join(" · ");
  const showObjects = () => {
    const list = visible(frame()).map(object => make("button", {
      style: `--c:${data.classes[object.class].color}`, title: object.path ?? "", "data-on": state.chosen === object,
      onmouseenter: () => { state.hovered = object; draw(); }, onmouseleave: () => { state.hovered = null; draw(); },
      onclick: () => { state.chosen = state.chosen === object ? null : object; showObjects(); draw(); },
    }, make("i", { class: "dot" }), make("span", {}, data.classes[object.class].name), make("em", {}, described(object)),
      ...(object.path ? [make("small", {}, `\u200e${object.path}`)] : [])));
    const none = frame()?.labeled === false ? "No labels." : "No objects.";
    at("objects").replaceChildren(...(list.length ? list : [make("p", { class: "none" }, none)]));
  };

  // --- choosing pictures ---
  const strip = at("strip");
  const watcher = new IntersectionObserver(entries => entries.forEach(entry => {
    if (!entry.isIntersecting) return;
    const picture = entry.target.querySelector("img"), each = data.frames[+entry.target.dataset.index];
    const number = each.picture ?? Object.values(each.layers)[0]?.image;
    if (number !== undefined && !picture.src) picture.src = at(`i${number}`).textContent;
    watcher.unobserve(entry.target);
  }), { root: strip, rootMargin: "0px 400px" });
  const showStrip = () => {
    watcher.disconnect();
    strip.replaceChildren(...state.order.map((index, place) => {
      const each = data.frames[index];
      const thumb = make("button", { title: each.name, "data-index": index, class: odd.has(each.name) ? "odd" : null, onclick: () => go(place) },
        make("img", { alt: "" }));
      watcher.observe(thumb);
      return thumb;
    }));
    at("slider").max = Math.max(0, state.order.length - 1);
  };
  const go = index => {
    if (!state.order.length) { draw(); showObjects(); at("position").textContent = "no picture"; return; }
    state.index = Math.min(Math.max(0, index), state.order.length - 1);
    state.chosen = state.hovered = null;
    strip.querySelector("[aria-current]")?.removeAttribute("aria-current");
    const thumb = strip.children[state.index];
    thumb?.setAttribute("aria-current", "true");
    if (thumb) strip.scrollTo({ left: thumb.offsetLeft - strip.offsetLeft - strip.clientWidth / 2 + 46 });
    at("slider").value = state.index;
    at("position").replaceChildren(make("b", {}, frame().name), ` ${state.index + 1} / ${state.order.length}`);
    try { history.replaceState(null, "", `#${encodeURIComponent(frame().name)}`); } catch { /* some browsers forbid it for files */ }
    draw(); showObjects();
    for (const ahead of [1, 2]) image(data.frames[state.order[state.index + ahead]]?.picture);
  };
  const refilter = () => {
    const name = frame()?.name;
    state.order = data.frames.map((_, index) => index).filter(index => {
      const each = data.frames[index];
      if (state.view !== null && each.view !== state.view) return false;
      if (state.filter?.keepFrame) return state.filter.keepFrame(each);
      return !state.filter || visible(each).some(state.filter.keep);
    });
    at("filter").hidden = !state.filter;
    if (state.filter) at("filter").firstChild.textContent = `${state.order.length} of ${data.frames.length}: ${state.filter.text}`;
    else document.querySelectorAll("g.bin[data-on]").forEach(each => each.removeAttribute("data-on"));
    showStrip();
    go(Math.max(0, state.order.findIndex(index => data.frames[index].name === name)));
  };
  const choose = filter => {
    document.querySelectorAll("g.bin[data-on]").forEach(each => { if (each !== filter?.group) each.removeAttribute("data-on"); });
    state.filter = filter;
    refilter();
  };
  const jump = name => {
    if (!data.frames.some(each => each.name === name)) return;
    state.filter = null; state.view = null;
    if (at("view")) at("view").value = "";
    refilter();
    go(state.order.findIndex(index => data.frames[index].name === name));
    window.scrollTo({ top: 0, behavior: "smooth" });
  };

  // --- panels ---
  const flip = name => {
    if (!available.includes(name)) return;
    state.on[state.on.has(name) ? "delete" : "add"](name);
    showLayers(); draw();
  };
  const showLayers = () => {
    const rows = available.map(name => make("label", { class: "toggle" },
      make("input", { type: "checkbox", checked: state.on.has(name), onchange: () => flip(name) }), named(name), ...(keyed(name) ? [make("kbd", {}, keyed(name))] : [])));
    if (available.includes("picture") && available.some(name => PICTURES.includes(name))) {
      const last = available.findLastIndex(name => PICTURES.includes(name));
      rows.splice(last + 1, 0, make("label", { class: "amount" }, "over the picture",
        make("input", { type: "range", min: 0, max: 1, step: .05, value: state.opacity, oninput: event => { state.opacity = +event.target.value; draw(); } })));
    }
    const views = data.views.length > 1 ? [make("select", { id: "view", title: "Render product (V)", onchange: event => { state.view = event.target.value === "" ? null : +event.target.value; refilter(); } },
      make("option", { value: "" }, "all render products"), ...data.views.map((name, index) => make("option", { value: index, selected: state.view === index }, name || "(top folder)")))] : [];
    at("layers").replaceChildren(...views, ...rows);
  };
  const showLegend = () => {
    const chips = data.classes.map((each, index) => make("button", {
      style: `--c:${each.color}`, "aria-pressed": String(!state.hidden.has(index)), title: "Draw or hide",
      onclick: () => { state.hidden[state.hidden.has(index) ? "delete" : "add"](index); showLegend(); showObjects(); draw(); },
    }, make("i", { class: "dot" }), each.name));
    at("legend").replaceChildren(...(chips.length ? chips : [make("p", { class: "none" }, "None.")]));
  };
  const showHead = () => {
    at("title").textContent = data.title;
    at("folder").textContent = data.folder;
    const seed = data.metadata["replicator_global_seed:"] ?? data.metadata.replicator_global_seed;
    const facts = { Writer: data.writers.join(", ") || "unknown", Pictures: data.totals.frames.toLocaleString("en"), Objects: data.totals.objects.toLocaleString("en"), Classes: data.classes.length };
    if (data.views.length > 1) facts["Render products"] = data.views.length;
    if (seed !== undefined) facts.Seed = seed;
    at("facts").replaceChildren(...Object.entries(facts).map(([name, value]) => make("div", {}, make("dt", {}, name), make("dd", {}, String(value)))));
    const others = Object.entries(data.unshown).map(([kind, count]) => `${kind} (${count})`).join(", ");
    const notes = [...data.notes, ...(others ? [`Also there, but not drawn here: ${others}.`] : [])];
    at("notes").replaceChildren(...notes.map(note => make("p", {}, note)));
  };
  const showProblems = () => {
    const total = data.problems.reduce((sum, group) => sum + group.count, 0);
    at("problem-count").textContent = total ? total.toLocaleString("en") : "";
    const groups = data.problems.map(group => make("details", { open: data.problems.length < 4 && group.count < 12 },
      make("summary", {}, make("b", {}, group.count.toLocaleString("en")), group.kind),
      make("ul", {}, ...group.list.map(([text, name]) => make("li", {}, text, ...(data.frames.some(each => each.name === name)
        ? [" ", make("a", { tabindex: 0, role: "button", onclick: () => jump(name), onkeydown: event => { if (event.key === "Enter") jump(name); } }, "show")] : []))),
        ...(group.count > group.list.length ? [make("li", {}, `… and ${group.count - group.list.length} more`)] : []))));
    at("problems").replaceChildren(...(groups.length ? groups : [make("p", { class: "fine" }, "None found: every picture has labels and objects, every file could be read.")]));
  };

  // --- pointer ---
  const inside = (object, x, y) => {
    const box = object.box ?? object.loose;
    return box && x >= box[0] && x <= box[2] && y >= box[1] && y <= box[3];
  };
  const area = object => { const box = object.box ?? object.loose; return (box[2] - box[0]) * (box[3] - box[1]); };
  let dragged = null;
  canvas.addEventListener("pointermove", event => {
    const bounds = canvas.getBoundingClientRect(), place = placing();
    const [px, py] = [event.clientX - bounds.left, event.clientY - bounds.top];
    if (dragged) {
      state.pan = [dragged.pan[0] + event.clientX - dragged.x, dragged.pan[1] + event.clientY - dragged.y];
      draw(); return;
    }
    const [x, y] = [(px - place.x) / place.scale, (py - place.y) / place.scale];
    const under = visible(frame()).filter(object => inside(object, x, y)).sort((a, b) => area(a) - area(b))[0] ?? null;
    if (under !== state.hovered) { state.hovered = under; draw(); }
    const tip = at("tip");
    tip.style.display = under ? "block" : "none";
    if (!under) return;
    tip.replaceChildren(make("b", {}, data.classes[under.class].name), make("br"), described(under), ...(under.path ? [make("br"), under.path] : []));
    tip.style.left = `${Math.min(px + 14, bounds.width - tip.offsetWidth - 8)}px`;
    tip.style.top = `${Math.min(py + 14, bounds.height - tip.offsetHeight - 8)}px`;
  });
  canvas.addEventListener("pointerleave", () => { at("tip").style.display = "none"; if (state.hovered) { state.hovered = null; draw(); } });
  canvas.addEventListener("pointerdown", event => { dragged = { x: event.clientX, y: event.clientY, pan: state.pan }; canvas.setPointerCapture(event.pointerId); });
  canvas.addEventListener("pointerup", () => { dragged = null; });
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    const bounds = canvas.getBoundingClientRect(), before = placing();
    const [px, py] = [event.clientX - bounds.left, event.clientY - bounds.top];
    const [x, y] = [(px - before.x) / before.scale, (py - before.y) / before.scale];
    state.zoom = Math.min(24, Math.max(1, state.zoom * Math.exp(-event.deltaY / 400)));
    if (state.zoom === 1) state.pan = [0, 0];
    else { const after = placing(); state.pan = [state.pan[0] + px - (after.x + x * after.scale), state.pan[1] + py - (after.y + y * after.scale)]; }
    draw();
  }, { passive: false });
  const unzoom = () => { state.zoom = 1; state.pan = [0, 0]; draw(); };
  canvas.addEventListener("dblclick", unzoom);

  // --- keys ---
  const theme = () => {
    const next = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
    document.documentElement.dataset.theme = next;
    try { localStorage.setItem("usdsdg-theme", next); } catch { /* private windows keep nothing */ }
  };
  const commands = {
    ArrowRight: () => go(state.index + 1), ArrowLeft: () => go(state.index - 1), PageDown: () => go(state.index + 10), PageUp: () => go(state.index - 10),
    Home: () => go(0), End: () => go(state.order.length - 1), Escape: () => { state.chosen = null; choose(null); unzoom(); },
    f: () => choose(state.filter?.odd ? null : { text: "pictures with problems", odd: true, keepFrame: each => odd.has(each.name) }),
    v: () => { if (data.views.length > 1) { state.view = state.view === null ? 0 : state.view + 1 < data.views.length ? state.view + 1 : null; showLayers(); refilter(); } },
    t: theme, z: unzoom, "?": () => at("help").showModal(),
  };
  document.addEventListener("keydown", event => {
    if (event.ctrlKey || event.metaKey || event.altKey || at("help").open || event.target.tagName === "SELECT") return;
    if (event.target.type === "range" && event.key.startsWith("Arrow")) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const layer = Object.keys(KEYS).find(name => KEYS[name] === key);
    if (commands[key]) { event.preventDefault(); commands[key](); } else if (layer) flip(layer);
  });
  const table = [["← →", "previous, next picture"], ["PgUp PgDn", "ten back, ten on"], ["Home End", "first, last"], ...available.filter(keyed).map(name => [keyed(name), named(name)]),
    ["F", "only pictures with problems"], ...(data.views.length > 1 ? [["V", "next render product"]] : []), ["wheel, drag", "zoom, move"], ["Z", "whole picture"], ["Esc", "all pictures, no choice"], ["T", "light or dark"]];
  at("keys").replaceChildren(...table.map(([key, text]) => make("tr", {}, make("td", {}, make("kbd", {}, key)), make("td", {}, text))));

  let kept = null;
  try { kept = localStorage.getItem("usdsdg-theme"); } catch { /* private windows keep nothing */ }
  document.documentElement.dataset.theme = kept ?? (window.matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
  at("theme").onclick = theme;
  at("help-open").onclick = commands["?"];
  at("previous").onclick = commands.ArrowLeft;
  at("next").onclick = commands.ArrowRight;
  at("slider").oninput = event => go(+event.target.value);
  at("filter").querySelector("button").onclick = () => choose(null);
  window.addEventListener("resize", draw);
  showHead(); showLayers(); showLegend(); showProblems();
  at("statistics").replaceChildren(classChart(data, choose), ...data.histograms.map(each => histogramChart(data, each, choose)));
  showStrip();
  let first = "";
  try { first = decodeURIComponent(location.hash.slice(1)); } catch { /* not a name of ours */ }
  go(Math.max(0, data.frames.findIndex(each => each.name === first)));
})();
