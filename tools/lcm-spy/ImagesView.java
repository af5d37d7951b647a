package lcmslam.spy;

import java.awt.Dimension;
import java.awt.Graphics;
import java.awt.Window;
import java.awt.image.BufferedImage;
import java.io.IOException;
import java.util.ArrayList;
import java.util.List;
import java.util.regex.Pattern;
import javax.swing.JPanel;
import javax.swing.SwingUtilities;
import lcm.lcm.LCM;
import lcm.lcm.LCMDataInputStream;
import lcm.lcm.LCMSubscriber;
import lcmslam.images_t;
import lcmslam.part_t;

/** The images of a channel's newest message side by side, as large as the window allows. */
class ImagesView extends JPanel implements LCMSubscriber {
  private static final int HEIGHT = 380; // pixels, at first

  private final String channel; // as regular expressions
  private final String pieces;
  private final PieceCollector collector = new PieceCollector();
  private List<DecodedImage> shown = new ArrayList<>();
  private boolean fitted = false;

  ImagesView(String channel, String pieces) {
    this.channel = Pattern.quote(channel);
    this.pieces = Pattern.quote(pieces);
    setPreferredSize(new Dimension(640, HEIGHT));
  }

  @Override
  public void addNotify() {
    super.addNotify();
    LCM.getSingleton().subscribe(channel, this);
    LCM.getSingleton().subscribe(pieces, this);
  }

  @Override
  public void removeNotify() {
    LCM.getSingleton().unsubscribe(channel, this);
    LCM.getSingleton().unsubscribe(pieces, this);
    super.removeNotify();
  }

  /** On LCM's thread. What does not decode is left out: the main window counts it. */
  @Override
  public void messageReceived(LCM lcm, String name, LCMDataInputStream in) {
    try {
      images_t message = null;
      if (Pattern.matches(pieces, name)) {
        byte[] whole = collector.add(new part_t(in));
        if (whole != null) message = new images_t(whole);
      } else {
        message = new images_t(in);
      }
      if (message != null) show(message);
    } catch (IOException | RuntimeException | OutOfMemoryError error) {
      System.err.println(name + ": " + error);
    }
  }

  private void show(images_t message) throws IOException {
    final List<DecodedImage> images = new ArrayList<>();
    for (int i = 0; i < message.n_images; ++i) {
      DecodedImage image = DecodedImage.decode(message.image_types[i], message.images[i]);
      if (image != null) images.add(image);
    }
    SwingUtilities.invokeLater(
        () -> {
          shown = images;
          fitWindow();
          repaint();
        });
  }

  /** Makes the window as wide as the first images need. */
  private void fitWindow() {
    Window window = SwingUtilities.getWindowAncestor(this);
    if (fitted || shown.isEmpty() || window == null) return;
    fitted = true;
    setPreferredSize(new Dimension((int) ((HEIGHT - 20) * ratio()), HEIGHT));
    window.pack();
  }

  /** Of width to height, of all images side by side. */
  private double ratio() {
    double ratio = 0;
    for (DecodedImage i : shown) ratio += (double) i.picture.getWidth() / i.picture.getHeight();
    return ratio;
  }

  @Override
  protected void paintComponent(Graphics graphics) {
    super.paintComponent(graphics);
    int line = graphics.getFontMetrics().getHeight();
    if (shown.isEmpty()) {
      graphics.drawString("waits for images", 10, line);
      return;
    }
    int height = (int) Math.max(1, Math.min(getHeight() - line, getWidth() / ratio()));
    int x = 0;
    for (DecodedImage image : shown) {
      BufferedImage picture = image.picture;
      int width = Math.max(1, height * picture.getWidth() / picture.getHeight());
      paintImage(graphics, picture, x, width, height);
      graphics.drawString(image.caption, x + 4, height + line - 4);
      x += width;
    }
  }

  /** At column x and the window's upper edge. */
  protected void paintImage(Graphics graphics, BufferedImage picture, int x, int width, int height) {
    graphics.drawImage(picture, x, 0, width, height, null);
  }
}
