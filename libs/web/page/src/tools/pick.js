// What stands under a pixel: surface, points or a landmark; without any the ground.
import { pointOnPlane, rayAt } from "../gestures.js";

const beside = 6; // px beside the pixel that still count

export class Picker {
  /**
   * @param views {mesh, points, landmarks} each with pick()
   * @param {() => number} reach how far away the map goes, m: pixels near the horizon mean nothing
   */
  constructor(stage, views, reach) {
    Object.assign(this, { stage, views, reach });
  }

  /** @returns {{place: Vector3, what: string, landmark?: number}|null} */
  at(event) {
    const { stage, views } = this;
    const ray = rayAt(event, stage.canvas, stage.camera);
    const cone = (beside / stage.canvas.clientHeight) * ((stage.camera.fov * Math.PI) / 180);
    const landmark = views.landmarks.pick(ray, cone);
    const solid = [views.mesh.pick(ray), views.points.pick(ray, cone)].filter(Boolean).sort((a, b) => a.distance - b.distance)[0];
    if (landmark && (!solid || landmark.distance < solid.distance + 0.1)) return { ...landmark, what: `landmark ${landmark.landmark}` };
    if (solid) return { place: solid.place, what: "surface" };
    return this.ground(event);
  }

  /** Where the pixel meets the ground, at height z. */
  ground(event, z = 0) {
    const place = pointOnPlane(rayAt(event, this.stage.canvas, this.stage.camera), z);
    return place && place.distanceTo(this.stage.camera.position) < Math.max(60, this.reach()) ? { place, what: "ground" } : null;
  }
}
