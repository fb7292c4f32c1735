(() => {
  "use strict";
  const scene = JSON.parse(document.getElementById("scene").textContent);
  const target = document.getElementById("view3d");
  if (!window.Plotly) { return; }
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
  const camera = clone(scene.layout.scene.camera);
  const aspect = clone(scene.layout.scene.aspectratio);
  const options = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["sendChartToCloud", "resetCameraLastSave3d"] };
  const drawn = Plotly.newPlot(target, scene.data, scene.layout, options).then(() => Plotly.relayout(target, colours()));
  dark.addEventListener("change", () => Plotly.relayout(target, colours()));
  // Paper cannot hold a canvas that is drawn anew for it: it shows the view as it opened.
  drawn.then(() => setTimeout(() => {
    const layout = { ...clone(scene.layout), font: { color: "#000" } };
    Plotly.toImage({ data: scene.data, layout }, { format: "png", width: 1100, height: 620 })
      .then((address) => {
        const picture = new Image();
        picture.alt = "3D view of horizons and faults as the page opens";
        picture.src = address;
        document.getElementById("still").append(picture);
      }, () => {});
  }, 500));
  document.getElementById("colouring")?.addEventListener("change", (event) => {
    const chosen = scene.colourings[event.target.value];
    if (scene.meshes.length) {
      Plotly.update(target, { intensity: chosen.values }, { coloraxis: clone(chosen.axis) }, scene.meshes);
    }
  });
  const chosen = document.getElementById("exaggeration");
  const stretched = () => ({ ...aspect, z: (aspect.z / scene.exaggeration) * Number(chosen.value) });
  chosen.addEventListener("change", () => { Plotly.relayout(target, { "scene.aspectratio": stretched() }); });
  document.getElementById("camera").addEventListener("click", () => {
    Plotly.relayout(target, { "scene.camera": clone(camera) });
  });
  const traces = (box) => box.dataset.traces.split(" ").map(Number);
  document.querySelectorAll(".controls fieldset").forEach((fieldset) => {
    const all = fieldset.querySelector("[data-all]");
    const boxes = [...fieldset.querySelectorAll("[data-traces]")];
    fieldset.addEventListener("change", (event) => {
      const changed = event.target === all ? boxes : [event.target];
      changed.forEach((box) => { box.checked = event.target.checked; });
      Plotly.restyle(target, { visible: event.target.checked }, changed.flatMap(traces));
      if (all) {
        const shown = boxes.filter((box) => box.checked).length;
        all.checked = shown === boxes.length;
        all.indeterminate = shown > 0 && shown < boxes.length;
      }
    });
  });
  // A plotly.js camera counts in the units of the aspect ratio from the middle of the box.
  const look = (place, reach) => {
    const size = stretched();
    const center = {};
    ["x", "y", "z"].forEach((key, k) => {
      const [low, high] = ranges[k];
      center[key] = high === low ? 0 : ((place[k] - low) / (high - low) - 0.5) * size[key];
    });
    const far = Math.max(0.15, Math.min(1.2, 3 * reach / Math.abs(ranges[0][1] - ranges[0][0] || 1) * size.x));
    const eye = {};
    for (const key of ["x", "y", "z"]) { eye[key] = center[key] + far * camera.eye[key]; }
    Plotly.relayout(target, { "scene.camera": { center, eye, up: { x: 0, y: 0, z: 1 } } });
    Plotly.restyle(target, { x: [[place[0]]], y: [[place[1]]], z: [[place[2]]], visible: true }, [scene.spot]);
  };
  const back = document.getElementById("back");
  document.querySelectorAll("[data-place]").forEach((button) => {
    button.hidden = false;
    button.addEventListener("click", () => {
      drawn.then(() => look(button.dataset.place.split(" ").map(Number), Number(button.dataset.reach)));
      back.href = `#${button.dataset.finding}`;
      back.hidden = false;
      document.getElementById("view").scrollIntoView();
      back.focus({ preventScroll: true });
    });
  });
})();
