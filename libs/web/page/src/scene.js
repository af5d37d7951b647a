// All that is drawn in the map.
import { Box3, Vector3 } from "three";
import { onTheme } from "./theme.js";
import { keepCovered } from "./views/cover.js";
import { GraphView } from "./views/graph.js";
import { GridView } from "./views/grid.js";
import { GroundView } from "./views/ground.js";
import { KeyframePoses } from "./views/keyframe_poses.js";
import { LandmarksView } from "./views/landmarks.js";
import { MeshView } from "./views/mesh.js";
import { ObjectsView } from "./views/objects.js";
import { ParticlesView } from "./views/particles.js";
import { PathsView } from "./views/paths.js";
import { PlanesView } from "./views/planes.js";
import { PointsView } from "./views/points.js";
import { RobotView } from "./views/robot.js";

export function makeScene({ stage, board, switches, view, labels }) {
  const poses = new KeyframePoses(stage);
  const views = {
    mesh: new MeshView(stage, board, switches),
    points: new PointsView(stage, board, switches, poses),
    landmarks: new LandmarksView(stage, board, switches, onTheme),
    particles: new ParticlesView(stage, board, switches, onTheme),
    paths: new PathsView(stage, board, switches, onTheme),
    graph: new GraphView(stage, board, switches, poses, onTheme),
    robot: new RobotView(stage, board, switches, view, onTheme),
    ground: new GroundView(stage, switches, onTheme),
    grid: new GridView(stage, board, switches, onTheme),
    planes: new PlanesView(stage, board, switches, labels, onTheme),
    objects: new ObjectsView(stage, board, switches, labels, onTheme),
  };
  keepCovered(stage, board, switches, views);
  let seen = false;
  stage.afterFrame = () => {
    if (seen || (views.points.drawn === 0 && views.mesh.triangles === 0)) return;
    seen = true;
    performance.mark("lcmslam-first-map"); // read by tests/page
  };
  view.extent = () => extent(views);
  setInterval(() => document.hidden || view.keepAll(), 1000);
  return views;
}

/** Where there is something to see, and its middle. */
function extent({ points, mesh, landmarks, paths, robot }) {
  const places = [points, mesh, landmarks, paths].flatMap((view) => view.centres());
  if (robot.pose) places.push(robot.pose.position.clone());
  return { centre: new Box3().setFromPoints(places.length > 0 ? places : [new Vector3()]).getCenter(new Vector3()), places };
}
