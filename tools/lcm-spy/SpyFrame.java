package lcmslam.spy;

import java.awt.Window;
import javax.swing.JComponent;
import javax.swing.JDesktopPane;
import javax.swing.JFrame;
import javax.swing.SwingUtilities;

/** The window that lcm-spy has opened for a plug-in, or a new one. */
final class SpyFrame {
  private SpyFrame() {}

  static void show(JDesktopPane desktop, String title, JComponent content) {
    Window window = desktop == null ? null : SwingUtilities.getWindowAncestor(desktop);
    JFrame frame = window instanceof JFrame ? (JFrame) window : new JFrame();
    frame.setTitle(title);
    frame.setContentPane(content);
    frame.setDefaultCloseOperation(JFrame.DISPOSE_ON_CLOSE);
    frame.pack();
    frame.setVisible(true);
  }
}
