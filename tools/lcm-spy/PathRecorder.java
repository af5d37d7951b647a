package lcmslam.spy;

import java.io.IOException;
import java.util.LinkedHashMap;
import java.util.Map;
import java.util.regex.Pattern;
import lcm.lcm.LCM;
import lcm.lcm.LCMDataInputStream;
import lcm.lcm.LCMSubscriber;
import lcmslam.pose_estimate_t;

/** Paths of channels of pose_estimate_t. Guarded by itself: LCM's thread writes, Swing's reads. */
class PathRecorder implements LCMSubscriber {
  private final Map<String, PosePath> paths = new LinkedHashMap<>();

  void follow(String channel) {
    synchronized (this) {
      if (paths.containsKey(channel)) return;
      paths.put(channel, new PosePath());
    }
    // Outside of our lock: LCM holds its own while it calls messageReceived.
    LCM.getSingleton().subscribe(Pattern.quote(channel), this);
  }

  /** By channel; hold this object's lock while using them. */
  Map<String, PosePath> paths() {
    return paths;
  }

  @Override
  public void messageReceived(LCM lcm, String channel, LCMDataInputStream in) {
    try {
      pose_estimate_t pose = new pose_estimate_t(in);
      synchronized (this) {
        paths.get(channel).add(pose);
      }
    } catch (IOException | RuntimeException | OutOfMemoryError error) {
      System.err.println(channel + ": " + error);
    }
  }
}
