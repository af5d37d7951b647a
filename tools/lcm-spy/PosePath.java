package lcmslam.spy;

import java.util.Arrays;
import lcmslam.pose_estimate_t;

/** Where a robot was, seen from above. */
class PosePath {
  private static final int MOST = 100_000; // poses; then every second one is forgotten
  private static final double FARTHEST = 1e6; // m

  private float[] x = new float[256];
  private float[] y = new float[256];
  private int size = 0;
  private long utime = Long.MIN_VALUE;
  private int status = 0;

  void add(pose_estimate_t pose) {
    if (pose.utime < utime) size = 0; // a log that starts again
    utime = pose.utime;
    status = pose.status;
    double px = pose.T_map_robot.trans[0];
    double py = pose.T_map_robot.trans[1];
    if (!(Math.abs(px) < FARTHEST && Math.abs(py) < FARTHEST)) return; // nor NaN
    if (size == MOST) thin();
    if (size == x.length) {
      x = Arrays.copyOf(x, 2 * size);
      y = Arrays.copyOf(y, 2 * size);
    }
    x[size] = (float) px;
    y[size] = (float) py;
    ++size;
  }

  private void thin() {
    size /= 2;
    for (int k = 0; k < size; ++k) {
      x[k] = x[2 * k];
      y[k] = y[2 * k];
    }
  }

  /** Widens a box (least x, y, largest x, y) to hold the path. */
  void extend(double[] box) {
    for (int k = 0; k < size; ++k) {
      box[0] = Math.min(box[0], x[k]);
      box[1] = Math.min(box[1], y[k]);
      box[2] = Math.max(box[2], x[k]);
      box[3] = Math.max(box[3], y[k]);
    }
  }

  int size() {
    return size;
  }

  double x(int k) {
    return x[k];
  }

  double y(int k) {
    return y[k];
  }

  int status() {
    return status;
  }
}
