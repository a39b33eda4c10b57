// The camera: at first the left one of the pair, exactly; from there it turns around a point of the relief.
import { MathUtils, PerspectiveCamera, Vector3 } from 'three';

const kSteepest = MathUtils.degToRad(85);

export class OrbitCamera {
  // photo: the left camera, {focal_px, cx, cy, width, height}; depth: of the point that it turns around, on
  // the camera's axis.
  constructor(photo, depth) {
    this.photo = photo;
    this.depth = depth;
    this.camera = new PerspectiveCamera();
    this.camera.rotation.order = 'YXZ';
    this.reset();
  }

  reset() {
    this.target = new Vector3(0, 0, -this.depth);
    this.distance = this.depth;
    this.yaw = 0;
    this.pitch = 0;
    this.sway = 0; // of the wiggle, on top of yaw
  }

  isPhotograph() {
    return this.yaw === 0 && this.pitch === 0 && this.sway === 0 && this.distance === this.depth &&
      this.target.x === 0 && this.target.y === 0 && this.target.z === -this.depth;
  }

  // The photograph as large as it fits into width x height px of the screen, in its middle. The principal point
  // need not be the photograph's middle: the view is moved by as much, which tilts nothing.
  fit(width, height) {
    const { photo } = this;
    this.scale = Math.min(width / photo.width, height / photo.height);
    this.camera.aspect = width / height;
    this.camera.fov = MathUtils.radToDeg(2 * Math.atan(height / this.scale / 2 / photo.focal_px));
    const x = (photo.width / 2 - photo.cx) * this.scale;
    const y = (photo.height / 2 - photo.cy) * this.scale;
    this.camera.setViewOffset(width, height, x, y, width, height);
  }

  turn(yaw, pitch) {
    this.yaw += yaw;
    this.pitch = MathUtils.clamp(this.pitch + pitch, -kSteepest, kSteepest);
  }

  // By px of the screen: what is seen moves with the finger.
  pan(x, y) {
    const size = this.distance / (this.photo.focal_px * this.scale);
    this.target.add(new Vector3(-x * size, y * size, 0).applyEuler(this.camera.rotation));
  }

  // Above 1: nearer.
  zoom(factor) {
    this.distance = MathUtils.clamp(this.distance / factor, this.depth / 100, this.depth * 30);
  }

  // sphere: what must lie between the near and the far plane.
  update(sphere) {
    const { camera, distance, pitch } = this;
    const yaw = this.yaw + this.sway;
    camera.rotation.set(-pitch, yaw, 0);
    camera.position
      .set(Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch), Math.cos(yaw) * Math.cos(pitch))
      .multiplyScalar(distance)
      .add(this.target);
    const away = camera.position.distanceTo(sphere.center);
    camera.far = away + sphere.radius;
    camera.near = Math.max(away - sphere.radius, camera.far / 5000);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
  }
}
