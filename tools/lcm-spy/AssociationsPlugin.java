package lcmslam.spy;

import java.awt.event.ActionEvent;
import javax.swing.AbstractAction;
import javax.swing.Action;
import javax.swing.JDesktopPane;
import lcm.spy.ChannelData;
import lcm.spy.SpyPlugin;
import lcmslam.associations_t;

/** A double click on FASTSLAM_ASSOCIATIONS shows the camera's image with what became of each feature. */
public class AssociationsPlugin implements SpyPlugin {
  @Override
  public boolean canHandle(long fingerprint) {
    return fingerprint == associations_t.LCM_FINGERPRINT;
  }

  /** lcm-spy asks with nulls for the action's name. */
  @Override
  public Action getAction(final JDesktopPane desktop, final ChannelData data) {
    return new AbstractAction("Features and landmarks") {
      @Override
      public void actionPerformed(ActionEvent event) {
        SpyFrame.show(desktop, data.name, new AssociationsView("CAMERA", data.name));
      }
    };
  }
}
