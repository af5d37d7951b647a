package lcmslam.spy;

import java.awt.event.ActionEvent;
import javax.swing.AbstractAction;
import javax.swing.Action;
import javax.swing.JDesktopPane;
import lcm.spy.ChannelData;
import lcm.spy.SpyPlugin;
import lcmslam.pose_estimate_t;

/**
 * A double click on a channel of poses shows the paths of both mappers from above. They are recorded from
 * the first such click on, for all windows.
 */
public class PathsPlugin implements SpyPlugin {
  private final PathRecorder recorder = new PathRecorder();

  @Override
  public boolean canHandle(long fingerprint) {
    return fingerprint == pose_estimate_t.LCM_FINGERPRINT;
  }

  /** lcm-spy asks with nulls for the action's name. */
  @Override
  public Action getAction(final JDesktopPane desktop, final ChannelData data) {
    return new AbstractAction("Paths from above") {
      @Override
      public void actionPerformed(ActionEvent event) {
        recorder.follow("FASTSLAM_POSE");
        recorder.follow("ICP_POSE");
        recorder.follow(data.name);
        SpyFrame.show(desktop, "Paths from above", new PathsView(recorder));
      }
    };
  }
}
