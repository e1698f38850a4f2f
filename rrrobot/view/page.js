// Every page: Meshcat's viewer in its pane, its lens widened where the page is narrow.
try {
  var viewer = new MeshCat.Viewer(document.getElementById("meshcat-pane"));
} catch (error) {
  document.getElementById("caption").textContent = "This page needs WebGL: " + error;
  throw error;
}
viewer.gui.width = 220;
viewer.gui.__folders["Scene"].close();

var page = {
  LENS: {{lens}},  // field of view [deg], and the width in heights that is sure to be seen
  steps: [],  // what else is done before each picture
  still: false,

  size() {
    const pane = document.getElementById("meshcat-pane");
    MeshCat.Viewer.prototype.set_3d_pane_size.call(viewer, pane.offsetWidth, pane.offsetHeight);
  },
  // A narrow page sees as much from side to side as a wide one, and more above and below.
  lens() {
    const camera = viewer.camera, [angle, wide] = page.LENS;
    if (!camera.isPerspectiveCamera) return;
    const more = Math.max(1, wide / camera.aspect);
    const half = Math.atan(Math.tan(angle * Math.PI / 360) * more) * 360 / Math.PI;
    if (Math.abs(camera.fov - half) < 1e-6) return;
    camera.fov = half;
    camera.updateProjectionMatrix();
    viewer.set_dirty();
  },
  draw() {
    page.lens();
    for (const step of page.steps) step();
  },
  // Without what only a hand needs, for a picture.
  hold(still) {
    if (still == page.still) return;
    page.still = still;
    const panel = viewer.gui.domElement.style;
    if (still) page.panel = panel.display;
    panel.display = still ? "none" : page.panel;
    document.body.classList.toggle("still", still);
    page.size();
    page.draw();
    viewer.render();
  },
};
viewer.set_3d_pane_size = page.size;
new ResizeObserver(page.size).observe(document.getElementById("meshcat-pane"));
(function always() { page.draw(); requestAnimationFrame(always); })();
