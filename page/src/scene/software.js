/**
 * Whether the picture is drawn by the processor: then smooth edges by many samples per pixel, and
 * more pixels than CSS asks for, would cost most of the time. Lines, borders and text are smooth
 * without either.
 */

/** @returns {boolean} */
export function drawnBySoftware() {
  const probe = document.createElement("canvas").getContext("webgl2");
  if (!probe) return false;
  const about = probe.getExtension("WEBGL_debug_renderer_info");
  const name = probe.getParameter(about ? about.UNMASKED_RENDERER_WEBGL : probe.RENDERER);
  probe.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(String(name));
}
