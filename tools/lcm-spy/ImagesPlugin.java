package lcmslam.spy;

import java.awt.event.ActionEvent;
import javax.swing.AbstractAction;
import javax.swing.Action;
import javax.swing.JDesktopPane;
import lcm.spy.ChannelData;
import lcm.spy.SpyPlugin;
import lcmslam.images_t;
import lcmslam.part_t;

/** A double click on a channel of images_t (or of its pieces) shows the images live. */
public class ImagesPlugin implements SpyPlugin {
  static final String PIECES = "_PART";

  @Override
  public boolean canHandle(long fingerprint) {
    return fingerprint == images_t.LCM_FINGERPRINT || fingerprint == part_t.LCM_FINGERPRINT;
  }

  /** lcm-spy asks with nulls for the action's name. */
  @Override
  public Action getAction(final JDesktopPane desktop, final ChannelData data) {
    return new AbstractAction("Images") {
      @Override
      public void actionPerformed(ActionEvent event) {
        String channel = data.name;
        if (channel.endsWith(PIECES)) channel = channel.substring(0, channel.length() - PIECES.length());
        SpyFrame.show(desktop, channel, new ImagesView(channel, channel + PIECES));
      }
    };
  }
}
