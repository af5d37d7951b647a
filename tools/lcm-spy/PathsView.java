package lcmslam.spy;

import java.awt.BasicStroke;
import java.awt.Color;
import java.awt.Dimension;
import java.awt.Graphics;
import java.awt.Graphics2D;
import java.awt.RenderingHints;
import java.awt.geom.Ellipse2D;
import java.awt.geom.Line2D;
import java.awt.geom.Path2D;
import java.util.Map;
import javax.swing.JPanel;
import javax.swing.Timer;

/** Paths from above: x (forward) to the right, y (left) upwards, in metres; all of them fit in. */
class PathsView extends JPanel {
  private static final Color[] COLOURS = {
    new Color(0xd9, 0x5f, 0x02), new Color(0x1f, 0x5f, 0xb4), new Color(0x2c, 0x8c, 0x3c)
  };
  private static final String[] STATES = {"initialising", "tracking", "degraded", "lost", "relocalised"};
  private static final int MARGIN = 40; // pixels
  private static final int PERIOD = 100; // ms

  private final PathRecorder recorder;
  private final Timer timer = new Timer(PERIOD, event -> repaint());

  // Of the map's origin, pixels, and pixels a metre.
  private double left;
  private double bottom;
  private double scale;

  PathsView(PathRecorder recorder) {
    this.recorder = recorder;
    setBackground(Color.WHITE);
    setPreferredSize(new Dimension(640, 560));
  }

  @Override
  public void addNotify() {
    super.addNotify();
    timer.start();
  }

  @Override
  public void removeNotify() {
    timer.stop();
    super.removeNotify();
  }

  @Override
  protected void paintComponent(Graphics graphics) {
    super.paintComponent(graphics);
    Graphics2D g = (Graphics2D) graphics;
    g.setRenderingHint(RenderingHints.KEY_ANTIALIASING, RenderingHints.VALUE_ANTIALIAS_ON);
    synchronized (recorder) {
      fit(recorder.paths());
      drawGrid(g);
      int i = 0;
      for (Map.Entry<String, PosePath> entry : recorder.paths().entrySet()) {
        g.setColor(COLOURS[i % COLOURS.length]);
        draw(g, entry.getValue());
        g.drawString(legend(entry.getKey(), entry.getValue()), 10, 18 * ++i);
      }
    }
  }

  private void fit(Map<String, PosePath> paths) {
    double[] box = {-0.5, -0.5, 0.5, 0.5}; // m: least x, y, largest x, y
    for (PosePath path : paths.values()) path.extend(box);
    double width = (getWidth() - 2 * MARGIN) / (box[2] - box[0]);
    double height = (getHeight() - 2 * MARGIN) / (box[3] - box[1]);
    scale = Math.max(Math.min(width, height), 1e-4);
    left = getWidth() / 2.0 - scale * (box[0] + box[2]) / 2;
    bottom = getHeight() / 2.0 + scale * (box[1] + box[3]) / 2;
  }

  /** A line every metre (or 10, 100 ...), at least 25 pixels apart. */
  private void drawGrid(Graphics2D g) {
    double step = 1;
    while (step * scale < 25) step *= 10;
    g.setColor(new Color(0xe4, 0xe4, 0xe4));
    for (double x = Math.ceil(-left / scale / step) * step; left + scale * x < getWidth(); x += step)
      g.draw(new Line2D.Double(left + scale * x, 0, left + scale * x, getHeight()));
    for (double y = Math.floor(bottom / scale / step) * step; bottom - scale * y < getHeight(); y -= step)
      g.draw(new Line2D.Double(0, bottom - scale * y, getWidth(), bottom - scale * y));
    g.setColor(Color.GRAY);
    g.drawString(String.format("grid %.0f m", step), 10, getHeight() - 8);
  }

  private void draw(Graphics2D g, PosePath path) {
    if (path.size() == 0) return;
    Path2D line = new Path2D.Double();
    line.moveTo(left + scale * path.x(0), bottom - scale * path.y(0));
    for (int k = 1; k < path.size(); ++k) line.lineTo(left + scale * path.x(k), bottom - scale * path.y(k));
    g.setStroke(new BasicStroke(1.6f));
    g.draw(line);
    int last = path.size() - 1;
    g.fill(new Ellipse2D.Double(left + scale * path.x(last) - 4, bottom - scale * path.y(last) - 4, 8, 8));
  }

  private static String legend(String channel, PosePath path) {
    if (path.size() == 0) return channel + ": nothing yet";
    int last = path.size() - 1;
    String state = path.status() >= 0 && path.status() < STATES.length ? STATES[path.status()] : "?";
    return String.format(
        "%s: %d poses, %s, at (%.2f, %.2f) m", channel, path.size(), state, path.x(last), path.y(last));
  }
}
