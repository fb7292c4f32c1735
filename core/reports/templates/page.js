(() => {
  "use strict";
  // On paper everything is open; afterwards it is as it was.
  const opened = [];
  addEventListener("beforeprint", () => {
    document.querySelectorAll("details:not(.brief):not([open])").forEach((d) => { d.open = true; opened.push(d); });
  });
  addEventListener("afterprint", () => { opened.splice(0).forEach((d) => { d.open = false; }); });
  // One map of several at a time; without this script, and on paper, all of them.
  document.querySelectorAll("[data-choices]").forEach((choices) => {
    const boxes = [...choices.querySelectorAll("input")];
    const show = () => boxes.forEach((box) => { document.getElementById(box.value).hidden = !box.checked; });
    if (!boxes.some((box) => box.checked)) { boxes[0].checked = true; }
    choices.addEventListener("change", show);
    choices.hidden = false;
    show();
  });
})();
