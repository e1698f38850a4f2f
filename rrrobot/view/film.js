// A film: its clock and its controls, what can be shown or hidden, names at their places.
for (const command of [
{{commands}}
]) viewer.handle_command_bytearray(Uint8Array.from(atob(command), c => c.charCodeAt(0)));
viewer.gui.hide();

(function () {
  const film = {{film}}, by = id => document.getElementById(id), animator = viewer.animator;
  const find = path => viewer.scene_tree.find(path.split("/").filter(Boolean)).object;
  const seconds = t => t.toFixed(film.digits), moves = animator.duration > 0;
  let last = 0;
  page.LENS[1] = film.width;

  // The clock. Meshcat's is of the film; ours is of the motion.
  const now = () => moves ? animator.actions[0].time : 0;
  const seek = t => { animator.seek(t); last = now(); };
  const pause = () => animator.pause();
  const play = () => { if (!film.loop && now() >= animator.duration) seek(0); animator.play(); };
  const toggle = () => animator.playing ? pause() : play();
  page.steps.push(() => {
    const t = now();
    if (animator.playing && !film.loop && t < last) { pause(); animator.seek(animator.duration); }
    last = now();
    const time = film.start + last * film.speed, share = moves ? last / animator.duration : 0;
    by("play").classList.toggle("on", animator.playing);
    by("at").value = share;
    by("clock").textContent = `${seconds(time)} / ${seconds(film.end)} s`;
    by("now").textContent = page.still && moves ? `t = ${seconds(time)} s` : "";
    by("cursor").style.left = `${100 * share}%`;
  });
  by("bar").hidden = !moves;
  by("play").onclick = toggle;
  by("at").oninput = e => { pause(); seek(e.target.value * animator.duration); };
  by("curves").onclick = e => seek(e.offsetX / by("curves").offsetWidth * animator.duration);
  document.addEventListener("keydown", e => {
    if (e.target.matches?.("select, summary, [type=checkbox]") || e.ctrlKey || e.metaKey) return;
    const step = { ArrowLeft: -1, ArrowRight: 1 }[e.key];
    if (e.key == " " && e.target != by("play")) toggle();
    else if (step) { pause(); seek(now() + step / 10 / film.speed); }
    else return;
    if (e.target != by("play")) e.preventDefault();
  });

  // Its speed, in simulated seconds per second.
  const speeds = [0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10].filter(s => s != film.speed);
  for (const s of [...speeds, film.speed].sort((a, b) => a - b))
    by("speed").add(new Option(`${s}×`, s, s == film.speed, s == film.speed));
  by("speed").onchange = e => { animator.mixer.timeScale = e.target.value / film.speed; };

  // What can be shown or hidden.
  const show = {
    nodes: (layer, on) => layer.nodes.forEach(path => { find(path).visible = on; }),
    swap: (layer, on) => {
      layer.nodes.forEach(path => { find(path).visible = on; });
      layer.others.forEach(path => { find(path).visible = !on; });
    },
    element: (layer, on) => { by(layer.element).hidden = !on; page.size(); },
    tree: (_, on) => { viewer.gui[on ? "show" : "hide"](); viewer.gui[on ? "open" : "close"](); },
  };
  for (const layer of film.layers) {
    const words = [];
    for (const [colour, text] of layer.legend) {
      const span = document.createElement("span"), mark = document.createElement("i");
      mark.style.background = colour;
      span.append(mark, text);
      by("legend").append(span);
      words.push(span);
    }
    const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: layer.on });
    const set = () => {
      show[layer.kind](layer, box.checked);
      words.forEach(span => { span.hidden = !box.checked; });
      viewer.set_dirty();
    };
    box.onchange = set;
    box.id = `show-${layer.name}`;
    const label = document.createElement("label");
    label.append(box, " ", layer.words);
    by("layers").append(label);
    set();
  }

  // Names, each at a place that moves with a node.
  for (const { node, at, words, colour } of film.names) {
    const span = document.createElement("span"), place = new MeshCat.THREE.Vector3();
    span.textContent = words;
    span.style.borderColor = colour;
    by("names").append(span);
    page.steps.push(() => {
      if (by("names").hidden) return;
      const object = find(node), box = by("names");
      object.updateWorldMatrix(true, false);
      place.set(...at).applyMatrix4(object.matrixWorld).project(viewer.camera);
      const [x, y] = [(1 + place.x) / 2 * box.offsetWidth, (1 - place.y) / 2 * box.offsetHeight];
      span.style.transform = `translate(${x + 8}px, ${y - 9}px)`;
      span.hidden = Math.abs(place.z) > 1;
    });
  }
  page.draw();
})();
