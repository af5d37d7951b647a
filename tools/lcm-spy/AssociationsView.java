package lcmslam.spy;

import java.awt.Color;
import java.awt.Graphics;
import java.awt.Graphics2D;
import java.awt.RenderingHints;
import java.awt.image.BufferedImage;
import java.io.IOException;
import java.util.regex.Pattern;
import javax.swing.SwingUtilities;
import lcm.lcm.LCM;
import lcm.lcm.LCMDataInputStream;
import lcm.lcm.LCMSubscriber;
import lcmslam.association_t;
import lcmslam.associations_t;

/**
 * The newest images with the newest associations drawn on the colour image: they may be a frame older. Pixels
 * are those of the ideal camera: towards the corners a lens with distortion moves them off by some pixels.
 */
class AssociationsView extends ImagesView {
  private static final String[] NAMES = {"accepted", "unused", "rejected", "new"}; // by outcome
  private static final Color[] COLOURS = {
    new Color(0x30, 0xd0, 0x40), new Color(0xa0, 0xd0, 0xa0), new Color(0xff, 0x40, 0x30), new Color(0x40, 0xa0, 0xff)
  };

  private final String channel; // as a regular expression
  private final LCMSubscriber listener = this::received;
  private associations_t newest = null;

  AssociationsView(String images, String associations) {
    super(images, images + ImagesPlugin.PIECES);
    channel = Pattern.quote(associations);
  }

  @Override
  public void addNotify() {
    super.addNotify();
    LCM.getSingleton().subscribe(channel, listener);
  }

  @Override
  public void removeNotify() {
    LCM.getSingleton().unsubscribe(channel, listener);
    super.removeNotify();
  }

  private void received(LCM lcm, String name, LCMDataInputStream in) {
    try {
      final associations_t message = new associations_t(in);
      SwingUtilities.invokeLater(() -> show(message));
    } catch (IOException | RuntimeException | OutOfMemoryError error) {
      System.err.println(name + ": " + error);
    }
  }

  void show(associations_t message) {
    newest = message;
    repaint();
  }

  @Override
  protected void paintImage(Graphics graphics, BufferedImage picture, int x, int width, int height) {
    super.paintImage(graphics, picture, x, width, height);
    if (x > 0 || newest == null || newest.width <= 0 || newest.height <= 0) return; // only on the first
    Graphics2D g = (Graphics2D) graphics;
    g.setRenderingHint(RenderingHints.KEY_ANTIALIASING, RenderingHints.VALUE_ANTIALIAS_ON);
    int[] counts = new int[NAMES.length];
    for (association_t a : newest.associations) {
      if (a.outcome < 0 || a.outcome >= NAMES.length) continue;
      int column = Math.round(a.x * width / newest.width);
      int row = Math.round(a.y * height / newest.height);
      int radius = a.outcome == association_t.REJECTED ? 6 : 3; // its new landmark lies inside
      g.setColor(COLOURS[a.outcome]);
      g.drawOval(column - radius, row - radius, 2 * radius, 2 * radius);
      ++counts[a.outcome];
    }
    int line = g.getFontMetrics().getHeight();
    g.setColor(new Color(0, 0, 0, 180));
    g.fillRect(0, 0, 110, line * NAMES.length + 8);
    for (int k = 0; k < NAMES.length; ++k) {
      g.setColor(COLOURS[k]);
      g.drawString(counts[k] + " " + NAMES[k], 8, line * (k + 1));
    }
  }
}
