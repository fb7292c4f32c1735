(() => {
  "use strict";
  const scene = JSON.parse(document.getElementById("scene").textContent);
  const target = document.getElementById("view3d");
  if (!window.Plotly) { return; }
  const find = (id) => document.getElementById(id);
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const clone = (value) => JSON.parse(JSON.stringify(value));
  const colours = () => {
    const style = getComputedStyle(document.body);
    const line = style.getPropertyValue("--line");
    const change = { "font.color": style.color };
    for (const axis of ["xaxis", "yaxis", "zaxis"]) {
      change[`scene.${axis}.gridcolor`] = line;
      change[`scene.${axis}.zerolinecolor`] = line;
    }
    return change;
  };
  const ranges = ["xaxis", "yaxis", "zaxis"].map((axis) => clone(scene.layout.scene[axis].range));
  const opening = clone(scene.layout.scene.camera);
  const aspect = clone(scene.layout.scene.aspectratio);
  const unwanted = ["sendChartToCloud", "resetCameraLastSave3d", "resetCameraDefault3d"];
  const options = { responsive: true, displaylogo: false, modeBarButtonsToRemove: unwanted };
  const drawn = Plotly.newPlot(target, scene.data, scene.layout, options).then(() => Plotly.relayout(target, colours()));
  dark.addEventListener("change", () => Plotly.relayout(target, colours()));

  // Paper cannot hold a canvas that is drawn anew for it: it shows a picture, at first of the view as it opened.
  const still = (alt) => {
    const layout = { ...clone(target.layout), font: { color: "#000" }, width: undefined, height: undefined };
    return Plotly.toImage({ data: target.data, layout }, { format: "png", width: 1100, height: 620 })
      .then((address) => {
        const picture = new Image();
        picture.alt = alt;
        picture.src = address;
        find("still").replaceChildren(picture);
      });
  };
  const later = window.requestIdleCallback ?? ((task) => setTimeout(task, 0));
  drawn.then(() => {
    target.dataset.drawn = "yes";
    setTimeout(() => later(() => {
      if (!find("still").childElementCount) { still("3D view of horizons and faults as the page opens").catch(() => {}); }
    }), 2000);
  });
  find("paper").addEventListener("click", () => {
    find("said").textContent = "…";
    still("3D view of horizons and faults").then(() => { find("said").textContent = "The printed page shows this view."; },
      () => { find("said").textContent = "This browser could not make a picture of the view."; });
  });

  // What surfaces are coloured by, and how opaque horizons are.
  const veil = find("veil");
  find("colouring")?.addEventListener("change", (event) => {
    const chosen = scene.colourings[event.target.value];
    const faults = scene.meshes.map((mesh, k) => [mesh, chosen.opacity[k]]).filter(([, value]) => value !== null);
    Plotly.update(target, { intensity: chosen.values }, { coloraxis: clone(chosen.axis) }, scene.meshes).then(() => {
      if (faults.length) { Plotly.restyle(target, { opacity: faults.map((f) => f[1]) }, faults.map((f) => f[0])); }
    });
  });
  veil?.addEventListener("change", () => { Plotly.restyle(target, { opacity: Number(veil.value) / 100 }, scene.veiled); });

  // Where the view is looked at from. A plotly.js camera counts in units of the aspect ratio from the box's middle.
  const camera = () => clone(target.layout.scene.camera);
  const look = (changed) => Plotly.relayout(target, { "scene.camera": changed });
  const chosen = find("exaggeration");
  const stretched = () => ({ ...aspect, z: (aspect.z / scene.exaggeration) * Number(chosen.value) });
  chosen.addEventListener("change", () => { Plotly.relayout(target, { "scene.aspectratio": stretched() }); });
  const far = Math.hypot(opening.eye.x, opening.eye.y, opening.eye.z);
  const sides = { south: [0, -1], east: [1, 0], north: [0, 1], west: [-1, 0] };
  const from = find("look");
  from.addEventListener("change", () => {
    const center = { x: 0, y: 0, z: 0 };
    const side = sides[from.value];
    if (!from.value) { look(clone(opening)); return; }
    // From above, north is up; a sideways view needs no more than a little height.
    const eye = side ? { x: side[0] * far, y: side[1] * far, z: 0.12 * far } : { x: 0, y: -0.001, z: far };
    look({ center, eye, up: { x: 0, y: 0, z: 1 } });
  });
  const moved = (turn, tilt, near) => {
    const now = camera();
    const way = ["x", "y", "z"].map((key) => now.eye[key] - now.center[key]);
    const level = Math.hypot(way[0], way[1]);
    const away = Math.hypot(level, way[2]) * near;
    const round = Math.atan2(way[1], way[0]) + turn * Math.PI / 180;
    const steep = Math.max(-1.5, Math.min(1.5, Math.atan2(way[2], level) + tilt * Math.PI / 180));
    const eye = {
      x: now.center.x + away * Math.cos(steep) * Math.cos(round),
      y: now.center.y + away * Math.cos(steep) * Math.sin(round),
      z: now.center.z + away * Math.sin(steep),
    };
    look({ center: now.center, eye, up: { x: 0, y: 0, z: 1 } });
  };
  document.querySelectorAll(".buttons button").forEach((button) => {
    const { turn, tilt, near } = button.dataset;
    button.addEventListener("click", () => moved(Number(turn ?? 0), Number(tilt ?? 0), Number(near ?? 1)));
  });
  const keys = {
    ArrowLeft: [15, 0, 1], ArrowRight: [-15, 0, 1], ArrowUp: [0, 10, 1], ArrowDown: [0, -10, 1],
    "+": [0, 0, 0.8], "=": [0, 0, 0.8], "-": [0, 0, 1.25],
  };
  target.addEventListener("keydown", (event) => {
    if (event.target !== target || !keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) { return; }
    event.preventDefault();
    moved(...keys[event.key]);
  });
  find("camera").addEventListener("click", () => { from.value = ""; look(clone(opening)); });

  // Surfaces on and off.
  const traces = (box) => box.dataset.traces.split(" ").map(Number);
  document.querySelectorAll(".controls fieldset").forEach((fieldset) => {
    const all = fieldset.querySelector("[data-all]");
    const boxes = [...fieldset.querySelectorAll("[data-traces]")];
    const tally = () => {
      if (!all) { return; }
      const shown = boxes.filter((box) => box.checked).length;
      all.checked = shown === boxes.length;
      all.indeterminate = shown > 0 && shown < boxes.length;
    };
    tally();
    fieldset.addEventListener("change", (event) => {
      const changed = event.target === all ? boxes : [event.target];
      changed.forEach((box) => { box.checked = event.target.checked; });
      Plotly.restyle(target, { visible: event.target.checked }, changed.flatMap(traces));
      tally();
    });
  });

  // Places of the text, shown in the view.
  const show = (place, reach) => {
    const size = stretched();
    const center = {};
    ["x", "y", "z"].forEach((key, k) => {
      const [low, high] = ranges[k];
      center[key] = high === low ? 0 : ((place[k] - low) / (high - low) - 0.5) * size[key];
    });
    const away = Math.max(0.15, Math.min(1.2, 3 * reach / Math.abs(ranges[0][1] - ranges[0][0] || 1) * size.x));
    const eye = {};
    for (const key of ["x", "y", "z"]) { eye[key] = center[key] + away * opening.eye[key]; }
    look({ center, eye, up: { x: 0, y: 0, z: 1 } });
    Plotly.restyle(target, { x: [[place[0]]], y: [[place[1]]], z: [[place[2]]], visible: true }, [scene.spot]);
  };
  const back = find("back");
  document.querySelectorAll("[data-place]").forEach((button) => {
    button.hidden = false;
    button.addEventListener("click", () => {
      drawn.then(() => show(button.dataset.place.split(" ").map(Number), Number(button.dataset.reach)));
      back.href = `#${button.dataset.finding}`;
      back.hidden = false;
      find("view").scrollIntoView();
      back.focus({ preventScroll: true });
    });
  });
})();
