// What is looked at: buttons of our own HTML, strength of layers, light and dark, the sheet of keys.
"use strict";
(() => {
  const rg = window.rg, { handlers, viser } = rg;
  const LARGEST_FILE = 32 * 2 ** 20;              // bytes; rgcore/scans/backdrop.py says the same

  // ---- buttons: data-do says what, data-arg to what; Python decides whether it may be --------------------------------
  const press = (e) => rg.send({ type: "press", do: e.dataset.do, arg: e.dataset.arg || "" });
  document.addEventListener("click", (e) => {
    const button = e.target.closest && e.target.closest("button[data-do], a[data-do]");   // a link goes where it leads, too
    if (button) { press(button); button.blur(); }   // keys are for the map again
  });
  document.addEventListener("change", (e) => {
    const { do: what, arg } = e.target.dataset || {};
    if (what === "layer") rg.send({ type: "press", do: what, arg: `${arg} ${e.target.checked ? 1 : 0}` });
    if (what === "strength") rg.send({ type: "press", do: what, arg: `${arg} ${e.target.value}` });
    if (what) e.target.blur();
  });
  document.addEventListener("input", (e) => {
    const { do: what, arg } = e.target.dataset || {};
    if (what === "strength") fade(arg, Number(e.target.value) / 100);
  });

  handlers.reveal = (m, tries = 10) => {              // what the panel has just got, where it would be below its edge
    const found = document.querySelector(m.what);
    if (found) found.scrollIntoView({ block: "nearest" });
    else if (tries) setTimeout(() => handlers.reveal(m, tries - 1), 25);
  };

  document.addEventListener("change", (e) => {         // seen before viser sends a file that would not be taken
    const file = e.target.type === "file" && e.target.files[0];
    if (!file || file.size <= LARGEST_FILE) return;
    e.stopPropagation();
    e.target.value = "";
    rg.send({ type: "press", do: "plan-too-large", arg: file.name.slice(0, 100) });
  }, true);

  // ---- strength of layers: blended by the graphics card, so that it holds for every kind of material ------------------
  const strength = new Map();                     // by name of the layer's node; absent = full
  const CUSTOM = 5, CONSTANT_ALPHA = 213, ONE_MINUS = 214, NORMAL = 1, SRC_ALPHA = 204, ONE_MINUS_SRC_ALPHA = 205;
  function fade(name, value) {
    if (name === "/labels") { rg.state.labelStrength = value; rg.paint(); return; }
    strength.set(name, value);
    apply(name, value);
    if (value >= 1) strength.delete(name);
    viser().requestRender();
  }
  function apply(name, value) {
    const node = viser().nodeRefFromName[name];
    if (!node) return;
    node.traverse((o) => {
      for (const m of Array.isArray(o.material) ? o.material : o.material ? [o.material] : []) {
        if (m.userData.rgStrength === value || (value >= 1 && m.userData.rgStrength === undefined)) continue;
        if (m.map) {                                // a picture: what is clear in it stays clear
          Object.assign(m, { transparent: true, opacity: value });
          m.userData.rgStrength = value;
          continue;
        }
        if (m.userData.rgOpaque === undefined) m.userData.rgOpaque = [m.transparent, m.blending, m.blendSrc, m.blendDst];
        m.userData.rgStrength = value;
        if (value >= 1) [m.transparent, m.blending, m.blendSrc, m.blendDst] = m.userData.rgOpaque;
        else Object.assign(m, { transparent: true, blending: CUSTOM, blendSrc: CONSTANT_ALPHA, blendDst: ONE_MINUS, blendAlpha: value });
        m.needsUpdate = true;
      }
    });
  }
  rg.beforeRender.push(() => { for (const [name, value] of strength) apply(name, value); });

  // ---- light and dark ------------------------------------------------------------------------------------------------
  handlers.dark = (m) => {
    document.documentElement.classList.toggle("rg-dark", m.on);
    viser().canvas.classList.add("rg-picture");
    rg.paint();
  };

  // ---- pins: numbered places of a list, as large at every zoom; small ones where nothing is to be decided ----------------
  let pins = [];
  handlers.pins = (m) => { pins = m.pins; };
  rg.painters.push((g, _r, project) => {
    g.textAlign = "center"; g.textBaseline = "middle"; g.font = `650 11px ${rg.FONT}`;
    for (const pin of [...pins].reverse()) {        // the first of the list lies on top
      const p = project(pin.x, pin.y, 0);
      if (!p) continue;
      const [x, y] = p, high = pin.big ? 22 : 0, r = pin.big ? 9.5 : 4.5;
      g.beginPath(); g.arc(x, y - high, r, pin.big ? 0.78 * Math.PI : 0, pin.big ? 2.22 * Math.PI : 2 * Math.PI);
      if (pin.big) g.lineTo(x, y);                // the tip stands on the place, the head beside what is written there
      g.closePath();
      g.fillStyle = pin.color; g.strokeStyle = "#ffffff"; g.lineWidth = 1.5; g.fill(); g.stroke();
      if (pin.big) { g.fillStyle = "#ffffff"; g.fillText(pin.text, x, y - high + 0.5); }
    }
  });

  // ---- the sheet of all commands ---------------------------------------------------------------------------------------
  const close = () => { const s = document.getElementById("rg-sheet"); if (s) s.remove(); return Boolean(s); };
  handlers["cheat-sheet"] = (m) => {
    if (close()) return;
    const sheet = document.createElement("div"), inner = document.createElement("div"), columns = document.createElement("div");
    sheet.id = "rg-sheet";
    columns.innerHTML = m.html;                     // of the table of commands; nothing in it came from a person
    inner.append(columns);
    sheet.append(inner);
    sheet.addEventListener("click", (e) => { if (e.target === sheet) close(); });
    document.body.append(sheet);
  };
  const typing = (e) => e.target instanceof HTMLInputElement || e.target instanceof HTMLTextAreaElement || e.target.isContentEditable;
  window.addEventListener("keydown", (e) => {
    if (e.key === "?" && !typing(e) && !e.ctrlKey && !e.metaKey) { rg.send({ type: "press", do: "command", arg: "help" }); e.preventDefault(); }
    if (e.key === "Escape" && close()) { e.stopPropagation(); e.preventDefault(); }
  }, true);
})();
