package lcmslam.spy;

import java.io.ByteArrayOutputStream;
import java.io.IOException;
import lcmslam.part_t;

/** Puts the pieces of the newest message together; they come in order from one sender. */
class PieceCollector {
  private long sender = 0;
  private long message = -1;
  private int next = 0;
  private final ByteArrayOutputStream bytes = new ByteArrayOutputStream();

  /** The whole message when this was its last piece, else null. */
  byte[] add(part_t part) throws IOException {
    if (part.part == 0) {
      sender = part.sender;
      message = part.message;
      next = 0;
      bytes.reset();
    }
    if (part.sender != sender || part.message != message || part.part != next) return null;
    bytes.write(part.data);
    ++next;
    if (next < part.n_parts) return null;
    if (bytes.size() != part.total_size) throw new IOException("pieces do not add up");
    return bytes.toByteArray();
  }
}
