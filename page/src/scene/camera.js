/**
 * The camera: turns about the skin, and knows the view that shows all of it.
 */

import * as THREE from "three";

const FIELD = 26; // degrees; narrow, so that a millimetre is about as long in front as behind
const HOME_TILT = [0.42, 0.78]; // rad from looking straight down, on a tall and on a wide screen
const STEEPEST = Math.PI - 0.02;
const NARROW = 480; // px; in a narrower picture the skin reaches over the words in its corner,
const FOOT = 38; // px, but not where these are
const NEAREST = 0.15;
const FARTHEST = 8;

export class OrbitCamera {
  constructor() {
    this.camera = new THREE.PerspectiveCamera(FIELD, 1, 0.001, 10);
    this.target = new THREE.Vector3();
    this.axis = new THREE.Vector3(0, 0, 1);
    this.ahead = new THREE.Vector3(0, 1, 0);
    this.aside = new THREE.Vector3(1, 0, 0);
    this.upright = false;
    this.homeDistance = 1;
    this.margins = { left: 0.03, right: 0.03, top: 0.03, bottom: 0.055 };
    this.points = [];
    this.moved = false;
    this.width = 1;
    this.height = 1;
    this.yaw = 0;
    this.tilt = HOME_TILT[0];
    this.distance = 1;
  }

  /**
   * What the home view shows.
   *
   * @param {THREE.Vector3[]} points all that has to be in it
   * @param {THREE.Vector3} normal outer side of the skin as a whole; short where it closes around
   */
  setSubject(points, normal) {
    this.points = points;
    const closed = normal.length() < 0.35;
    const facing = normal.clone().normalize();
    this.upright = closed && Math.abs(facing.z) < 0.9;
    if (this.upright) {
      // A skin around a limb: upright, seen from where most of it is
      this.axis.set(0, 0, 1);
      this.ahead.copy(facing).projectOnPlane(this.axis).normalize().negate();
    } else {
      this.axis.copy(facing.lengthSq() > 0 ? facing : new THREE.Vector3(0, 0, 1));
      const up = Math.abs(this.axis.z) > 0.8 ? [0, 1, 0] : [0, 0, 1];
      this.ahead.set(...up).projectOnPlane(this.axis).normalize();
    }
    this.aside.crossVectors(this.ahead, this.axis);
    if (!this.moved) this.home();
  }

  resize(width, height) {
    this.width = width;
    this.height = height;
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (!this.moved) this.home();
    else this.apply();
  }

  /** The view of all, again. */
  home() {
    this.moved = false;
    this.yaw = 0;
    this.tilt = this.upright ? 1.15 : clamp(0.3 + (0.27 * this.width) / this.height, ...HOME_TILT);
    if (this.points.length > 0) this.#fit();
    this.homeDistance = this.distance;
    this.apply();
  }

  orbit(dx, dy) {
    this.moved = true;
    this.yaw -= dx;
    this.tilt = clamp(this.tilt - dy, 0, STEEPEST);
    this.apply();
  }

  /** @param {number} factor above 1: nearer */
  zoom(factor) {
    this.moved = true;
    const { homeDistance } = this;
    this.distance = clamp(this.distance / factor, NEAREST * homeDistance, FARTHEST * homeDistance);
    this.apply();
  }

  /** Moves the picture by so many CSS pixels. */
  pan(dx, dy) {
    this.moved = true;
    const step = this.pixel(this.distance);
    const { elements } = this.camera.matrixWorld;
    for (const [i, d] of [[0, -dx], [4, dy]]) {
      this.target.x += elements[i] * d * step;
      this.target.y += elements[i + 1] * d * step;
      this.target.z += elements[i + 2] * d * step;
    }
    this.apply();
  }

  /** Direction from the skin to the camera, of length 1. */
  out() {
    return this.camera.position.clone().sub(this.target).normalize();
  }

  /** Whether the third axis is the one that leads out of the skin, or up along it. */
  get zUp() {
    return this.axis.z > 0.9;
  }

  /**
   * A place that is seen at a pixel, in the plane through the target that faces the camera.
   *
   * @param {number} x CSS px
   * @param {number} y
   * @returns {THREE.Vector3} m
   */
  at(x, y) {
    const { camera, target } = this;
    const deep = target.clone().project(camera).z;
    return new THREE.Vector3((2 * x) / this.width - 1, 1 - (2 * y) / this.height, deep).unproject(camera);
  }

  /** How many metres a CSS pixel is at a distance. */
  pixel(distance) {
    return (2 * distance * Math.tan((FIELD * Math.PI) / 360)) / this.height;
  }

  apply() {
    const { camera, target, axis, tilt, yaw, distance } = this;
    const out = new THREE.Vector3()
      .addScaledVector(this.ahead, -Math.cos(yaw))
      .addScaledVector(this.aside, Math.sin(yaw));
    camera.up.set(0, 0, 0);
    camera.up.addScaledVector(axis, Math.sin(tilt)).addScaledVector(out, -Math.cos(tilt));
    camera.position
      .copy(target)
      .addScaledVector(axis, Math.cos(tilt) * distance)
      .addScaledVector(out, Math.sin(tilt) * distance);
    camera.near = distance / 50;
    camera.far = distance * 10;
    camera.lookAt(target);
    camera.updateMatrixWorld();
    camera.updateProjectionMatrix();
  }

  /** Nearest place from which all points are inside the margins. */
  #fit() {
    const { points } = this;
    const foot = this.width < NARROW ? FOOT / this.height : 0;
    const margins = { ...this.margins, bottom: Math.max(this.margins.bottom, foot) };
    const box = new THREE.Box3().setFromPoints(points);
    box.getCenter(this.target);
    this.distance = 2.5 * box.getSize(new THREE.Vector3()).length();
    const at = new THREE.Vector3();
    const wide = 2 - 2 * (margins.left + margins.right);
    const tall = 2 - 2 * (margins.top + margins.bottom);
    for (let step = 0; step < 12; step += 1) {
      this.apply();
      const seen = new THREE.Box2();
      for (const point of points) {
        at.copy(point).project(this.camera);
        seen.expandByPoint(at);
      }
      const size = seen.getSize(new THREE.Vector2());
      const middle = seen.getCenter(new THREE.Vector2());
      const px = ((middle.x - (margins.left - margins.right)) * this.width) / 2;
      const py = ((middle.y - (margins.bottom - margins.top)) * this.height) / 2;
      this.pan(-px, py);
      this.distance *= Math.max(size.x / wide, size.y / tall);
    }
    this.moved = false;
    this.apply();
  }
}

function clamp(value, low, high) {
  return Math.max(low, Math.min(value, high));
}
