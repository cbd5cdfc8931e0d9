// Names for a screen reader that the theme leaves out: of the search dialog, and of the switches behind its buttons.
document.querySelector(".md-search")?.setAttribute("aria-label", "Search");
for (const each of document.querySelectorAll("input.md-toggle")) {
  each.setAttribute("aria-label", each.dataset.mdToggle ?? each.id);
}
