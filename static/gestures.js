// The hand on the map: what a tool of rgviz/tools is fed with (presses, moves, releases in metres of the floor), and what it
// shows meanwhile (the sketch), painted over the picture by us: no frame of the scene is needed for it.
"use strict";
(() => {
  const rg = window.rg, { handlers, painters, viser } = rg;
  const REACH = 10;                               // px around a handle that count as on it
  const NEAR = 48;                                // px around the pointer in which all corners show
  const WAIT = 300;                               // ms after which a move is sent though the last was not answered
  const INK = {
    draft: ["#30343a", "rgba(48,52,58,0.10)"], good: ["#0072b2", "rgba(0,114,178,0.22)"],
    other: ["#c2410c", "rgba(230,120,0,0.22)"], bad: ["#c81e1e", "rgba(200,30,30,0.12)"],
  };
  const gone = { strokes: [], handles: [], marks: [], title: "", hint: "", note: "", refused: false, grab: false };
  const state = { sketch: gone, held: false, hover: null, pointer: null, move: null, asked: 0, said: "", pressed: null };

  // ---- where the hand is -----------------------------------------------------------------------------------------------
  function place(e) {
    const v = viser(), r = v.canvas.getBoundingClientRect();
    const floor = rg.floorUnder(e.clientX - r.left, e.clientY - r.top, r);
    const scale = floor && rg.pixelsPerMetre(r, rg.projector(r));
    return scale ? { x: floor[0], y: floor[1], pixel: 1 / scale, shift: e.shiftKey, ctrl: e.ctrlKey || e.metaKey } : null;
  }
  function handleAt(e) {                          // the topmost handle under the pointer: later ones are drawn above
    const r = viser().canvas.getBoundingClientRect(), project = rg.projector(r), scale = rg.pixelsPerMetre(r, project);
    let best = null, least = REACH;
    for (const h of state.sketch.handles) {
      const p = onPage(project(h.x, h.y, 0), r);
      if (!shows(h, scale, p)) continue;
      const far = p ? Math.hypot(p[0] - e.clientX, p[1] - e.clientY) : Infinity;
      if (far <= least) { best = h.id; least = far; }
    }
    return best;
  }
  // a handle with little room waits until one zooms in; a corner of an outline also until the hand is near
  function shows(h, scale, p) {
    if (!h.room || h.room * scale > 44) return true;
    return h.shape === "corner" && p && state.pointer && Math.hypot(p[0] - state.pointer[0], p[1] - state.pointer[1]) < NEAR;
  }

  const onPage = (p, r) => p && [p[0] + r.left, p[1] + r.top];

  // ---- to Python: a move only when the last one was answered, the newest then -------------------------------------------
  function move(at) {
    if (state.move && performance.now() - state.move.sent < WAIT) { state.move.next = at; return; }
    state.move = { sent: performance.now(), next: null };
    rg.send({ type: "pointer", kind: "move", ...at });
  }
  handlers.drawn = () => { const next = state.move && state.move.next; state.move = null; if (next) move(next); };

  // ---- the pointer: seen before viser and the camera see it, and kept from them where it is ours ------------------------
  const ours = (e) => rg.ready() && e.target === viser().canvas;
  function down(e) {
    if (!ours(e)) return;
    if (document.activeElement && document.activeElement !== document.body) document.activeElement.blur();
    if (e.button !== 0) return;
    const handle = handleAt(e);
    if (!state.sketch.grab && (!handle || e.shiftKey || e.ctrlKey || e.metaKey)) return;
    const at = place(e);
    e.stopPropagation();
    if (!at) return;
    state.held = true;
    state.pressed = e.pointerId;
    viser().canvas.setPointerCapture(e.pointerId);
    if (state.move) state.move.next = null;
    rg.send({ type: "pointer", kind: "press", ...at, handle });
  }
  function moved(e) {
    if (!rg.ready() || (!state.held && e.target !== viser().canvas)) return;
    state.pointer = [e.clientX, e.clientY];
    if (state.held) e.stopPropagation();
    const hover = state.held ? state.hover : handleAt(e);
    if (hover !== state.hover) { state.hover = hover; cursor(); rg.paint(); }
    if (!state.held && (!state.sketch.grab || e.buttons)) return;
    const at = place(e);
    if (at) move(at);
  }
  function up(e) {
    if (!state.held || e.pointerId !== state.pressed) return;
    state.held = false;
    e.stopPropagation();
    const at = place(e);
    if (state.move) state.move.next = null;
    if (at) rg.send({ type: "pointer", kind: "release", ...at });
  }
  window.addEventListener("pointerdown", down, true);
  window.addEventListener("pointermove", moved, true);
  window.addEventListener("pointerup", up, true);
  window.addEventListener("pointercancel", up, true);
  window.addEventListener("contextmenu", (e) => { if (ours(e) && (state.sketch.grab || e.ctrlKey)) e.preventDefault(); });
  // a button that was clicked keeps no focus: Enter and Space are the map's
  document.addEventListener("click", (e) => {
    const button = e.detail && e.target.closest && e.target.closest("button");
    if (button) setTimeout(() => { if (document.activeElement === button) button.blur(); });
  });

  function cursor() {
    const kind = state.hover ? (state.held ? "grabbing" : "grab") : state.sketch.grab ? "crosshair" : "";
    document.documentElement.dataset.rgHand = kind;
  }

  // ---- what the tool shows ------------------------------------------------------------------------------------------------
  handlers.sketch = (m) => { state.sketch = { ...gone, ...m }; cursor(); banner(); };
  handlers.say = (m) => { state.said = m.text; banner(); };
  const selected = handlers.selected;
  handlers.selected = (m) => { selected(m); state.said = ""; banner(); };

  painters.push((g, r, project) => {
    const scale = rg.pixelsPerMetre(r, project);
    for (const s of state.sketch.strokes) stroke(g, s, project);
    for (const h of [...state.sketch.handles, ...state.sketch.marks]) {
      const p = project(h.x, h.y, 0);
      if (h.chosen || shows(h, scale, onPage(p, r))) mark(g, h, p);
    }
    if (state.sketch.note && state.pointer) {
      const [x, y] = [state.pointer[0] - r.left, state.pointer[1] - r.top];
      g.font = `550 12px ${rg.FONT}`; g.textBaseline = "middle";
      const left = x + 18 + g.measureText(state.sketch.note).width > r.width;
      g.textAlign = left ? "right" : "left";
      rg.write(g, state.sketch.note, left ? x - 16 : x + 16, y + 20, state.sketch.refused ? "#b01515" : "#23262b");
    }
  });
  function stroke(g, s, project) {
    const points = s.points.map((p) => project(p[0], p[1], 0));
    if (points.some((p) => !p)) return;
    const [line, area] = INK[s.ink || "draft"];
    g.beginPath();
    points.forEach((p, n) => (n ? g.lineTo(p[0], p[1]) : g.moveTo(p[0], p[1])));
    if (s.closed) g.closePath();
    if (s.fill) { g.fillStyle = area; g.fill(); }
    g.lineJoin = g.lineCap = "round";
    g.setLineDash([]); g.strokeStyle = "rgba(255,255,255,0.85)"; g.lineWidth = 4.5; g.stroke();
    g.setLineDash(!s.ink || s.ink === "draft" || s.ink === "bad" ? [6, 5] : []);
    g.strokeStyle = line; g.lineWidth = 2.25; g.stroke();
    g.setLineDash([]);
    if (s.text) {
      const n = points.length, x = points.reduce((a, p) => a + p[0], 0) / n, y = points.reduce((a, p) => a + p[1], 0) / n;
      g.textAlign = "center"; g.textBaseline = "middle"; g.font = `600 12px ${rg.FONT}`;
      rg.write(g, s.text, x, y - 12, line);
    }
  }
  function mark(g, h, p) {
    if (!p) return;
    const hot = h.chosen || state.hover === h.id, k = hot ? 1.35 : 1;
    g.beginPath();
    if (h.shape === "side") g.rect(p[0] - 3.5 * k, p[1] - 3.5 * k, 7 * k, 7 * k);
    else if (h.shape === "post" || h.shape === "corner") g.rect(p[0] - 5 * k, p[1] - 5 * k, 10 * k, 10 * k);
    else if (h.shape === "entry" || h.shape === "note") {
      const d = 7 * k;
      g.moveTo(p[0], p[1] - d); g.lineTo(p[0] + d, p[1]); g.lineTo(p[0], p[1] + d); g.lineTo(p[0] - d, p[1]); g.closePath();
    } else g.arc(p[0], p[1], (h.shape === "snap" ? 8 : 5.5) * k, 0, 2 * Math.PI);
    g.lineWidth = 2;
    if (h.shape === "snap") { g.strokeStyle = "#0072b2"; g.stroke(); return; }
    g.fillStyle = hot ? "#ec0078" : h.shape === "side" ? "rgba(255,255,255,0.8)" : "#fff";
    g.strokeStyle = hot ? "#fff" : "#ec0078";
    g.fill(); g.stroke();
  }

  // ---- words above the picture ---------------------------------------------------------------------------------------------
  const bar = document.createElement("div");
  bar.id = "rgviz-tool";
  bar.setAttribute("role", "status");
  function banner() {
    const v = viser();
    if (!v || !v.canvas) return;
    if (!bar.isConnected) v.canvas.parentElement.appendChild(bar);
    const { title, hint } = state.sketch;
    bar.hidden = !title && !state.said;
    bar.replaceChildren();
    if (title) {
      const name = document.createElement("b"), keys = document.createElement("span");
      name.textContent = title; keys.textContent = `${hint} Esc puts it away.`;
      bar.append(name, keys);
    }
    if (state.said) { const said = document.createElement("span"); said.textContent = state.said; bar.append(said); }
  }

  // ---- a question at a place of the map --------------------------------------------------------------------------------------
  const field = document.createElement("input");
  field.id = "rgviz-ask"; field.maxLength = 1000; field.autocomplete = "off";
  function answer(value) {
    if (!state.asked) return;
    const question = state.asked;
    state.asked = 0;                              // taking it away blurs it, which answers again
    field.remove();
    rg.send({ type: "answer", question, value });
  }
  field.addEventListener("keydown", (e) => {
    e.stopPropagation();
    if (e.key === "Enter") answer(field.value);
    if (e.key === "Escape") answer(null);
  });
  field.addEventListener("blur", () => answer(field.value || null));
  handlers.ask = (m) => {
    const v = viser(), r = v.canvas.getBoundingClientRect(), p = rg.projector(r)(m.x, m.y, 0) || [r.width / 2, r.height / 2];
    state.asked = m.question;
    v.canvas.parentElement.appendChild(field);
    field.value = m.value; field.placeholder = m.label; field.setAttribute("aria-label", m.label);
    field.style.left = `${Math.min(Math.max(p[0] - 120, 8), r.width - 256)}px`;
    field.style.top = `${Math.min(Math.max(p[1] + 14, 8), r.height - 48)}px`;
    setTimeout(() => field.focus());
  };

  const style = document.createElement("style");
  style.textContent = `
    [data-rg-hand=crosshair] canvas { cursor: crosshair !important; }
    [data-rg-hand=grab] canvas { cursor: grab !important; }
    [data-rg-hand=grabbing] canvas { cursor: grabbing !important; }
    #rgviz-tool { position: absolute; z-index: 2; top: 10px; left: 12px; right: 12px; width: fit-content; margin: 0 auto; box-sizing: border-box;
      display: flex; gap: .3em .8em; flex-wrap: wrap; padding: .4em .9em; border-radius: 7px; background: var(--paper); color: var(--ink);
      border: 1px solid var(--rule); box-shadow: 0 1px 4px rgba(0,0,0,.14); font: 13px/1.4 ${rg.FONT}; pointer-events: none; }
    #rgviz-tool[hidden] { display: none; }
    #rgviz-tool b { color: var(--brand-ink); font-weight: 650; }
    #rgviz-ask { position: absolute; z-index: 3; width: 240px; box-sizing: border-box; font: 13px ${rg.FONT}; padding: .45em .7em; border-radius: 6px;
      border: 1.5px solid var(--brand); background: var(--paper); color: var(--ink); box-shadow: 0 2px 8px rgba(0,0,0,.2); outline: none; }`;
  document.head.appendChild(style);
  rg.hand = state;
})();
