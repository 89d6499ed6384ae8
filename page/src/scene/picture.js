/**
 * The canvas and what draws on it: its size, its pixels, and what happens when the graphics fail.
 */

import * as THREE from "three";
import { drawnBySoftware } from "./software.js";

const SORRY = "This browser shows no WebGL 2 pictures. The contacts are in the table, the rest works.";

export class Picture {
  /**
   * @param {HTMLElement} container that the canvas fills
   * @param {() => void} changed is told when the picture has another size, or is empty
   */
  constructor(container, changed) {
    this.container = container;
    this.changed = changed;
    this.software = drawnBySoftware();
    this.width = 1;
    this.height = 1;
    this.ratio = 1;
    this.background = "#000000";
    this.renderer = this.#renderer();
    this.canvas = this.renderer?.domElement ?? document.createElement("canvas");
    this.#mount();
  }

  /** Null where there is no WebGL: the page goes on without a picture and says so. */
  #renderer() {
    try {
      const renderer = new THREE.WebGLRenderer({ antialias: !this.software });
      renderer.outputColorSpace = THREE.LinearSRGBColorSpace; // colours as they are
      return renderer;
    } catch (error) {
      const words = document.createElement("p");
      words.textContent = SORRY;
      words.title = error.message;
      words.style.padding = "1rem";
      this.container.append(words);
      return null;
    }
  }

  #mount() {
    const { canvas } = this;
    canvas.dataset.testid = "skin-canvas";
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", "The skin; its contacts are in the table beside it");
    Object.assign(canvas.style, { display: "block", touchAction: "none", outlineOffset: "-3px" });
    this.container.append(canvas);
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => {
      this.setBackground(this.background); // the one thing that does not come back by itself
      this.#fill();
    });
    this.observer = new ResizeObserver(() => this.#fill());
    this.observer.observe(this.container);
  }

  #fill() {
    this.width = Math.max(1, this.container.clientWidth);
    this.height = Math.max(1, this.container.clientHeight);
    this.ratio = Math.min(this.software ? 1 : 2, window.devicePixelRatio || 1);
    this.renderer?.setPixelRatio(this.ratio);
    this.renderer?.setSize(this.width, this.height);
    this.changed();
  }

  /** @param {string} colour of CSS */
  setBackground(colour) {
    this.background = colour;
    this.renderer?.setClearColor(colour);
  }

  render(root, camera) {
    this.renderer?.render(root, camera);
  }

  /** Colour at a CSS pixel, sRGB 0..255, right after it was drawn. */
  colourAt(x, y) {
    const gl = this.renderer.getContext();
    const bytes = new Uint8Array(4);
    const row = gl.drawingBufferHeight - 1 - Math.floor(y * this.ratio);
    gl.readPixels(Math.floor(x * this.ratio), row, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    return [...bytes.subarray(0, 3)];
  }
}
