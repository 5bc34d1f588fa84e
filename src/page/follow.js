// Follows a part while it is edited. Only pages that a server makes again hold this; they ask that server and nobody else.

const ASK_AFTER = 400; // milliseconds
const KEPT = `kept for ${location.pathname}`;
const KEPT_VALUES = ["filter", "color", "axis", "cut"], KEPT_CHECKS = ["sharp", "wire", "flip"];

// What a person has chosen, for the page that comes next. The camera is kept in the part's own unit: the box may change.
function keep() {
  const groups = document.querySelectorAll("#groups input");
  const kept = {
    values: KEPT_VALUES.map((id) => $(id).value),
    checks: KEPT_CHECKS.map((id) => $(id).checked),
    faces: told.faces.filter((_, f) => !shown[f]).map((face) => face.name),
    groups: told.groups.filter((_, g) => !groups[g].checked).map((group) => group.name),
    theme: document.documentElement.dataset.theme,
    scroll: document.querySelector("aside").scrollTop,
  };
  if (scene && told.triangle_count) {
    kept.camera = { yaw: camera.yaw, pitch: camera.pitch, target: mesh.told(camera.target), reach: camera.reach * mesh.unit };
  }
  sessionStorage.setItem(KEPT, JSON.stringify(kept));
}

function restore() {
  const text = sessionStorage.getItem(KEPT);
  if (!text) return;
  sessionStorage.removeItem(KEPT);
  const kept = JSON.parse(text);
  KEPT_VALUES.forEach((id, i) => { $(id).value = kept.values[i]; });
  KEPT_CHECKS.forEach((id, i) => { $(id).checked = kept.checks[i]; });
  told.faces.forEach((face, f) => { shown[f] = !kept.faces.includes(face.name); });
  listFaces();
  const groups = document.querySelectorAll("#groups input");
  told.groups.forEach((group, g) => { groups[g].checked = !kept.groups.includes(group.name); });
  theme(kept.theme === "dark");
  if (scene) {
    if (kept.camera && told.triangle_count) {
      const { yaw, pitch, target, reach } = kept.camera;
      Object.assign(camera, { yaw, pitch, target: mesh.drawn(target), reach: reach / mesh.unit });
    }
    state.sharp = $("sharp").checked;
    state.wire = $("wire").checked;
    cut();
    colorBy($("color").value);
    look();
  }
  document.querySelector("aside").scrollTop = kept.scroll;
}

const banner = make("pre");
banner.id = "following";
banner.setAttribute("role", "status");
banner.style.cssText = "position: absolute; left: 8px; right: 8px; top: 44px; margin: 0 auto; width: fit-content; max-width: calc(100% - 16px); max-height: 60%; overflow: auto; padding: 8px 12px; white-space: pre-wrap; background: var(--panel); border: 1px solid var(--line); border-radius: 6px;";
$("stage").append(banner);

function tell(text, bad) {
  banner.hidden = !text;
  if (banner.textContent !== text) banner.textContent = text;
  banner.style.borderColor = bad ? "var(--bad)" : "var(--line)";
}
tell("", false);

async function follow() {
  try {
    const answer = await fetch("state", { cache: "no-store" });
    if (!answer.ok) throw new Error(answer.statusText);
    const { version, meshing, trouble } = await answer.json();
    if (version !== VERSION) {
      // Where nothing can be kept the page begins anew.
      try { keep(); } catch (e) { console.warn(e); }
      location.reload();
      return;
    }
    const help = trouble?.help && `help: ${trouble.help}`, picture = VERSION > 0 && "The picture is of the last mesh that could be made.";
    if (trouble) tell([trouble.what, trouble.source, help, picture].filter(Boolean).join("\n"), true);
    else tell(meshing ? "meshing" : "", false);
  } catch (e) {
    tell(`Nobody answers (${e.message}): the command that serves this page has ended. The picture is of its last mesh.`, true);
  }
  setTimeout(follow, ASK_AFTER);
}
started.then(restore).catch((e) => console.warn(e)).then(follow);
