// A copy of the studio's page on a disk: nothing answers it, and a browser runs no modules from files.
if (location.protocol === "file:") {
  const said = document.getElementById("said");
  said.textContent = "This is a saved copy of a page of planter studio: it shows what it showed when it was saved. To change it, start planter studio again and load the saved machine file.";
  said.setAttribute("role", "alert");
  said.className = "error";
  for (const control of document.querySelectorAll("button, input, select")) control.disabled = true;
}
