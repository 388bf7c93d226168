// The browser's side of rgviz, beside viser's page: straight-down view, labels, scale bar, and what viser has no widget for.
// Python speaks through rg.receive(message); we answer through one hidden text field of this browser alone (rg.send).
"use strict";
(() => {
  const FLAT_FOV = 5.73, SOLID_FOV = 45;          // degrees; flat = so narrow that nothing leans
  const TRUCK = 2, ROTATE = 1;                    // camera-controls actions
  const state = {
    channel: null, mode: "2d", extent: null, fitted: null, labels: [], labelsShown: true, labelStrength: 1, selected: new Set(), touched: false,
    pointer: null, serial: 0, focus: null,
  };
  const viser = () => window.__viserMutable;
  const ready = () => { const v = viser(); return v && v.scene && v.camera && v.cameraControl && v.nodeRefFromName[""]; };

  // ---- to Python -----------------------------------------------------------------------------------------------------
  function send(message) {
    const v = viser();
    if (!v || !state.channel) return;
    const value = JSON.stringify({ ...message, n: ++state.serial });
    v.sendMessage({ type: "GuiUpdateMessage", uuid: state.channel, updates: { value } });
  }

  // ---- the camera ----------------------------------------------------------------------------------------------------
  const root = () => viser().nodeRefFromName[""];
  const vector = (x, y, z) => new (viser().camera.position.constructor)(x, y, z);
  const toThree = (x, y, z) => vector(x, y, z).applyMatrix4(root().matrixWorld);
  function north() {                              // azimuth that puts the map's +y up on the screen
    const n = toThree(0, 1, 0).sub(toThree(0, 0, 0));
    return Math.atan2(-n.x, -n.z);
  }
  function setMode(mode) {
    const v = viser(), c = v.cameraControl;
    state.mode = mode;
    c.dollyToCursor = true;
    if (mode === "2d") {
      const a = north();
      c.minPolarAngle = c.maxPolarAngle = 0;
      c.minAzimuthAngle = c.maxAzimuthAngle = a;
      c.mouseButtons.left = c.mouseButtons.right = TRUCK;
    } else {
      c.minPolarAngle = 0; c.maxPolarAngle = 0.49 * Math.PI;
      c.minAzimuthAngle = -Infinity; c.maxAzimuthAngle = Infinity;
      c.mouseButtons.left = ROTATE; c.mouseButtons.right = TRUCK;
    }
    v.camera.fov = mode === "2d" ? FLAT_FOV : SOLID_FOV;
    v.camera.updateProjectionMatrix();
  }
  function fit(extent) {
    if (!ready() || !extent) return;
    const v = viser(), c = v.cameraControl, r = v.canvas.getBoundingClientRect();
    if (!r.width || !r.height) return;
    const [[x0, y0], [x1, y1]] = extent, half = Math.tan((v.camera.fov * Math.PI) / 360);
    const flat = state.mode === "2d", w = x1 - x0, h = y1 - y0;
    const usable = [r.width - 48, r.height - 72];  // px left around the map: scale bar below, a rim elsewhere
    const perPixel = Math.max(w / usable[0], h / usable[1]);
    const distance = ((flat ? 1 : 1.15) * perPixel * r.height) / 2 / half;
    const target = toThree((x0 + x1) / 2, (y0 + y1) / 2 - (flat ? 12 * perPixel : 0), 0);
    c.rotateTo(north(), flat ? 0 : 0.27 * Math.PI, false);
    c.dollyTo(distance, false);
    c.moveTo(target.x, target.y, target.z, false);   // setTarget would turn the camera
    state.fitted = `${r.width} x ${r.height}`;    // the size of the picture that it was fitted to
    v.requestRender();
  }
  function view(mode) {                           // change between straight down and solid without losing the place
    const v = viser(), c = v.cameraControl;
    const wide = c.distance * Math.tan((v.camera.fov * Math.PI) / 360);
    setMode(mode);
    c.rotateTo(mode === "2d" ? north() : c.azimuthAngle, mode === "2d" ? 0 : 0.27 * Math.PI, false);
    c.dollyTo(wide / Math.tan((v.camera.fov * Math.PI) / 360), false);
    if (!state.touched) fit(state.extent);
    v.requestRender();
  }

  // ---- drawing ---------------------------------------------------------------------------------------------------------
  // Colours as given (no film-like tone curve), and a depth range that follows the distance, so that layers a centimetre
  // apart stay apart from a kilometre above.
  function hook() {
    const v = viser();
    if (v.scene.userData.rgviz) return;
    v.scene.userData.rgviz = true;
    v.scene.onBeforeRender = (renderer, _scene, camera) => {
      renderer.toneMapping = 0;
      for (const before of beforeRender) before();
      if (camera !== v.camera) return;
      const d = v.cameraControl.distance, flat = state.mode === "2d";
      const near = flat ? 0.5 * d : Math.max(0.02, 0.02 * d), far = flat ? 1.5 * d : 30 * d + 50;
      if (Math.abs(camera.near / near - 1) > 0.01 || Math.abs(camera.far / far - 1) > 0.01) {
        camera.near = near; camera.far = far;
        camera.updateProjectionMatrix();
      }
    };
    v.scene.onAfterRender = (_renderer, _scene, camera) => { if (camera === v.camera) paint(); };
    // viser applies what arrives in the next frame and shows it in the one after. Applied at once, it shows in the next:
    // half the wait where a frame takes long.
    const ask = v.requestRender;
    let applying = false;
    v.requestRender = () => {
      let words = false;                          // scripts alone draw nothing in the scene: no frame for them
      if (!applying && v.messageQueue.length && v.drainMessageQueue && v.getRenderRequestState === "ready") {
        words = v.messageQueue.every((m) => m.type === "RunJavascriptMessage");
        applying = true;
        try { v.drainMessageQueue(); } finally { applying = false; }
      }
      if (!words) ask();
    };
    // a picture that grows step by step beside a panel is drawn anew at each step: let it take its place at once
    for (let e = v.canvas; e; e = e.parentElement) if (getComputedStyle(e).transitionDuration !== "0s") e.style.transition = "none";
    new ResizeObserver(() => { if (!state.touched) fit(state.extent); }).observe(v.canvas);
    for (const kind of ["pointerdown", "wheel"]) v.canvas.addEventListener(kind, () => { state.touched = true; }, { passive: true, capture: true });
    v.canvas.addEventListener("pointermove", (e) => { state.pointer = [e.clientX, e.clientY]; paint(); });
    v.canvas.addEventListener("pointerleave", () => { state.pointer = null; paint(); });
    setMode("2d");
    fit(state.extent);
  }

  const sheet = document.createElement("canvas");
  sheet.id = "rgviz-overlay";
  sheet.style.cssText = "position:fixed;pointer-events:none;z-index:1";
  const widths = new Map();
  function widthOf(g, text) {
    const key = g.font + text;
    let w = widths.get(key);
    if (w === undefined) { if (widths.size > 20000) widths.clear(); w = g.measureText(text).width; widths.set(key, w); }
    return w;
  }
  const FONT = '-apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif';

  function paint() {
    const v = viser();
    if (!v || !v.canvas || !v.camera) return;
    const r = v.canvas.getBoundingClientRect(), dpr = window.devicePixelRatio || 1;
    if (!sheet.isConnected) v.canvas.parentElement.appendChild(sheet);
    const w = Math.round(r.width * dpr), h = Math.round(r.height * dpr);
    if (sheet.width !== w || sheet.height !== h) { sheet.width = w; sheet.height = h; }
    Object.assign(sheet.style, { left: "0", top: "0", position: "absolute", width: `${r.width}px`, height: `${r.height}px` });
    const g = sheet.getContext("2d");
    g.setTransform(dpr, 0, 0, dpr, 0, 0);
    g.clearRect(0, 0, r.width, r.height);
    const project = projector(r);
    g.globalAlpha = state.labelStrength;
    if (state.labelsShown) paintLabels(g, r, project);
    g.globalAlpha = 1;
    for (const draw of painters) draw(g, r, project);
    paintScale(g, r, project);
    paintNorth(g, r, project);
  }
  function projector(r) {
    const cam = viser().camera;
    cam.updateMatrixWorld();
    return (x, y, z) => {
      const p = toThree(x, y, z).project(cam);
      return p.z > 1 || p.z < -1 ? null : [((p.x + 1) / 2) * r.width, ((1 - p.y) / 2) * r.height];
    };
  }
  // The first label takes its place, later ones only where there is room: they thin out with zoom and never pile up.
  function paintLabels(g, r, project) {
    const taken = [];
    const scale = pixelsPerMetre(r, project);
    const wanted = [...state.labels].sort((a, b) => (state.selected.has(b.id) - state.selected.has(a.id)) || b.weight - a.weight);
    g.textAlign = "center"; g.textBaseline = "middle"; g.lineJoin = "round";
    for (const label of wanted) {
      const chosen = state.selected.has(label.id);
      if (!chosen && label.room * scale < label.least) continue;
      const p = project(label.x, label.y, label.z || 0);
      if (p && label.kind === "gateway") p[1] += Math.max(18, 0.16 * scale + 9);   // beside its marks, not on them
      if (!p || p[0] < 0 || p[1] < 0 || p[0] > r.width || p[1] > r.height) continue;
      g.font = `${label.kind === "region" ? 600 : 500} ${label.kind === "region" ? 12 : 11}px ${FONT}`;
      const wide = widthOf(g, label.text) + 8;
      if (!chosen && label.kind === "region" && wide > label.room * scale * 2) continue;
      const second = label.note && label.room * scale > 90;
      const box = [p[0] - wide / 2, p[1] - 8, p[0] + wide / 2, p[1] + (second ? 22 : 8)];
      if (taken.some((b) => box[0] < b[2] && box[2] > b[0] && box[1] < b[3] && box[3] > b[1])) continue;
      taken.push(box);
      write(g, label.text, p[0], p[1], chosen ? "#a80056" : label.color);
      if (second) { g.font = `400 10.5px ${FONT}`; write(g, label.note, p[0], p[1] + 14, "#4a4f57"); }
    }
  }
  function write(g, text, x, y, color) {
    g.strokeStyle = "rgba(255,255,255,0.92)"; g.lineWidth = 3.5; g.strokeText(text, x, y);
    g.fillStyle = color; g.fillText(text, x, y);
  }
  function floorUnder(x, y, r) {                  // map coordinates under a point of the canvas
    const v = viser(), inverse = root().matrixWorld.clone().invert();
    const far = vector((x / r.width) * 2 - 1, 1 - (y / r.height) * 2, 0.5).unproject(v.camera).applyMatrix4(inverse);
    const eye = v.camera.position.clone().applyMatrix4(inverse), d = far.sub(eye);
    const t = -eye.z / d.z;
    return Math.abs(d.z) < 1e-9 || t < 0 ? null : [eye.x + t * d.x, eye.y + t * d.y];
  }
  function pixelsPerMetre(r, project) {
    const c = floorUnder(r.width / 2, r.height / 2, r);
    if (!c) return 0;
    const a = project(c[0], c[1], 0), b = project(c[0] + 1, c[1], 0);
    return a && b ? Math.hypot(a[0] - b[0], a[1] - b[1]) : 0;
  }
  function paintScale(g, r, project) {
    const scale = pixelsPerMetre(r, project);
    if (!scale) return;
    const target = 110 / scale, ten = 10 ** Math.floor(Math.log10(target));
    const metres = [5, 2, 1].map((k) => k * ten).find((m) => m <= target) || ten;
    const long = metres * scale, x = 16, y = r.height - 16;
    const text = metres >= 1 ? `${metres} m` : `${Math.round(metres * 100)} cm`;
    for (const [color, width] of [["rgba(255,255,255,0.9)", 5], ["#30343a", 2]]) {
      g.strokeStyle = color; g.lineWidth = width; g.lineCap = "butt";
      g.beginPath(); g.moveTo(x, y - 6); g.lineTo(x, y); g.lineTo(x + long, y); g.lineTo(x + long, y - 6); g.stroke();
    }
    g.textAlign = "left"; g.textBaseline = "bottom"; g.font = `500 11px ${FONT}`;
    write(g, text, x + 5, y - 3, "#30343a");
    const under = state.pointer && floorUnder(state.pointer[0] - r.left, state.pointer[1] - r.top, r);
    if (under) { g.font = `400 11px ${FONT}`; write(g, `x ${under[0].toFixed(2)}  y ${under[1].toFixed(2)} m`, x + long + 16, y + 2, "#5a606a"); }
  }
  function paintNorth(g, r, project) {
    const c = floorUnder(r.width / 2, r.height / 2, r);
    const a = c && project(c[0], c[1], 0), b = c && project(c[0], c[1] + 0.5, 0);
    if (!a || !b) return;
    const turn = Math.atan2(b[0] - a[0], a[1] - b[1]);
    g.save();
    g.translate(r.width - 26, r.height - 30); g.rotate(turn);
    g.fillStyle = "#30343a"; g.strokeStyle = "rgba(255,255,255,0.9)"; g.lineWidth = 3;
    g.beginPath(); g.moveTo(0, -13); g.lineTo(6, 7); g.lineTo(0, 3); g.lineTo(-6, 7); g.closePath(); g.stroke(); g.fill();
    g.restore();
    g.textAlign = "center"; g.textBaseline = "middle"; g.font = `600 10px ${FONT}`;
    write(g, "y", r.width - 26 + 20 * Math.sin(turn), r.height - 30 - 20 * Math.cos(turn), "#30343a");
  }

  // ---- text fields: a value counts when it is finished (Enter, or leaving the field), not at every key -----------------
  function fieldOf(input) {
    if (!(input instanceof HTMLInputElement) || input.type === "checkbox" || input.getAttribute("role") === "combobox") return null;
    for (let e = input.parentElement; e && e !== document.body; e = e.parentElement) {
      const labels = e.querySelectorAll("label[for]");
      if (labels.length > 1) return null;
      if (labels.length === 1) return labels[0].htmlFor;
    }
    return null;
  }
  function commit(input) {
    const field = fieldOf(input);
    if (field && state.focus && state.focus.input === input && state.focus.value !== input.value) {
      state.focus.value = input.value;
      send({ type: "commit", field, value: input.value });
    }
  }
  document.addEventListener("focusin", (e) => { if (fieldOf(e.target)) state.focus = { input: e.target, value: e.target.value }; });
  document.addEventListener("focusout", (e) => commit(e.target));
  document.addEventListener("keydown", (e) => {
    if (!fieldOf(e.target)) return;
    if (e.key === "Enter") { commit(e.target); e.target.blur(); }
    if (e.key === "Escape") { const field = fieldOf(e.target); state.focus = null; send({ type: "revert", field }); e.target.blur(); }
  }, true);

  // viser flies the camera on W A S D Q E and arrows even while Ctrl is held. Its listener sits on `document`, its hotkeys
  // on <html>: what stops at <html> still fires the hotkey.
  const FLY = new Set(["KeyW", "KeyA", "KeyS", "KeyD", "KeyQ", "KeyE", "ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight"]);
  document.documentElement.addEventListener("keydown", (e) => {
    if (FLY.has(e.code) && (e.ctrlKey || e.metaKey || e.altKey || (state.mode === "2d" && e.code.startsWith("Key")))) e.stopPropagation();
  });

  // ---- from Python -------------------------------------------------------------------------------------------------------
  const beforeRender = [];                        // what other scripts do before each frame of the scene
  const painters = [];                            // what other scripts draw over the picture: (g, rectangle, project)
  const handlers = {
    hello: (m) => { state.channel = m.channel; },
    extent: (m) => { state.extent = m.extent; if (!state.touched) fit(m.extent); },
    labels: (m) => {
      const key = (l) => `${l.kind}:${l.id}`, known = new Map(state.labels.map((l) => [key(l), l]));
      for (const k of m.gone) known.delete(k);
      for (const l of m.put) known.set(key(l), l);
      state.labels = [...known.values()];
    },
    "labels-shown": (m) => { state.labelsShown = m.shown; },
    selected: (m) => { state.selected = new Set(m.ids); },
    look: (m) => { const t = toThree(m.x, m.y, 0); state.touched = true; viser().cameraControl.moveTo(t.x, t.y, t.z, false); viser().requestRender(); },
    fit: (m) => { state.touched = Boolean(m.extent); fit(m.extent || state.extent); },
    view: (m) => { view(m.mode); },
    focus: (m, tries = 20) => {
      const label = document.querySelector(`label[for="${CSS.escape(m.field)}"]`);
      let box = label && label.parentElement;
      while (box && !box.querySelector("input")) box = box.parentElement;
      if (box) { box.querySelector("input").focus(); box.querySelector("input").select(); }
      else if (tries) setTimeout(() => handlers.focus(m, tries - 1), 25);   // the field may not be on the page yet
    },
    title: (m) => { document.title = m.text; },
  };
  function receive(message) {
    if (!ready()) { setTimeout(() => receive(message), 30); return; }
    hook();
    handlers[message.type](message);
    paint();                                      // the overlay alone: a frame of the scene costs far more
  }

  const inbox = window.rgInbox || [];
  window.rg = { receive, state, send, fit, handlers, painters, beforeRender, viser, ready, floorUnder, projector, pixelsPerMetre, paint, write, FONT };
  window.rgInbox = { push: receive };
  inbox.forEach(receive);
})();
