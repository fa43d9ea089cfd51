"use strict";
{
// A picture is shown large when it is clicked; what is folded opens for print.
for (const image of document.querySelectorAll("figure img, .card img"))
  image.addEventListener("click", () => {
    const dialog = document.createElement("dialog");
    dialog.append(image.cloneNode());
    dialog.addEventListener("click", () => dialog.close());
    dialog.addEventListener("close", () => dialog.remove());
    document.body.append(dialog);
    dialog.showModal();
  });
const print = matchMedia("print");
const fold = () => document.querySelectorAll(".fold").forEach(one => { one.open = print.matches; });
print.addEventListener("change", fold);
fold();
}
