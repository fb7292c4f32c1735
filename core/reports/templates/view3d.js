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
  const aspect = clone(scene.layout.scene.aspectratio);
  const camera = clone(scene.layout.scene.camera);
  const options = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["sendChartToCloud", "resetCameraLastSave3d"] };
  Plotly.newPlot(target, scene.data, scene.layout, options).then(() => Plotly.relayout(target, colours()));
  dark.addEventListener("change", () => Plotly.relayout(target, colours()));
  document.getElementById("colouring").addEventListener("change", (event) => {
    const chosen = scene.colourings[event.target.value];
    if (scene.meshes.length) {
      Plotly.update(target, { intensity: chosen.values }, { coloraxis: clone(chosen.axis) }, scene.meshes);
    }
  });
  document.getElementById("exaggeration").addEventListener("change", (event) => {
    const z = (aspect.z / scene.exaggeration) * Number(event.target.value);
    Plotly.relayout(target, { "scene.aspectratio": { ...aspect, z } });
  });
  document.getElementById("camera").addEventListener("click", () => {
    Plotly.relayout(target, { "scene.camera": clone(camera) });
  });
  document.querySelectorAll("[data-traces]").forEach((box) => {
    box.addEventListener("change", () => {
      Plotly.restyle(target, { visible: box.checked }, box.dataset.traces.split(" ").map(Number));
    });
  });
})();
