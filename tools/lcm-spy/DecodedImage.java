package lcmslam.spy;

import java.awt.image.BufferedImage;
import java.awt.image.WritableRaster;
import java.io.ByteArrayInputStream;
import java.io.IOException;
import java.util.zip.DataFormatException;
import java.util.zip.Inflater;
import javax.imageio.ImageIO;
import lcmslam.image_t;
import lcmslam.images_t;

/** A picture of an image of images_t. */
class DecodedImage {
  private static final int BIG_ENDIAN_GRAY16 = 357;
  private static final long LARGEST = 100_000_000; // pixels

  final BufferedImage picture;
  final String caption;

  private DecodedImage(BufferedImage picture, String caption) {
    this.picture = picture;
    this.caption = caption;
  }

  /** Null for types that are not shown. */
  static DecodedImage decode(short type, image_t image) throws IOException {
    boolean jpeg = image.pixelformat == image_t.PIXEL_FORMAT_MJPEG;
    if (jpeg && (type == images_t.LEFT || type == images_t.RIGHT)) return colour(image);
    if (image.width <= 0 || image.height <= 0 || (long) image.width * image.height > LARGEST)
      throw new IOException("an image of " + image.width + " x " + image.height + " pixels");
    if (type == images_t.DEPTH_MM_ZIPPED) return depth(image, unzip(image.data, 2 * pixels(image)));
    if (type == images_t.DEPTH_MM) return depth(image, image.data);
    if (type == images_t.AMPLITUDE_ZIPPED) return amplitude(image, unzip(image.data, pixels(image)));
    return null;
  }

  private static int pixels(image_t image) {
    return image.width * image.height;
  }

  private static DecodedImage colour(image_t image) throws IOException {
    BufferedImage picture = ImageIO.read(new ByteArrayInputStream(image.data));
    if (picture == null) throw new IOException("the colour image is no JPEG");
    return new DecodedImage(picture, picture.getWidth() + " x " + picture.getHeight());
  }

  /** 16 bit, mm; near is bright, unknown is black. */
  private static DecodedImage depth(image_t image, byte[] bytes) throws IOException {
    if (bytes.length < 2 * pixels(image)) throw new IOException("the depth image is too short");
    int low = image.pixelformat == BIG_ENDIAN_GRAY16 ? 1 : 0;
    int[] depth = new int[pixels(image)];
    int farthest = 1;
    for (int i = 0; i < depth.length; ++i) {
      depth[i] = (bytes[2 * i + low] & 0xff) | (bytes[2 * i + 1 - low] & 0xff) << 8;
      farthest = Math.max(farthest, depth[i]);
    }
    int[] grey = new int[depth.length];
    for (int i = 0; i < grey.length; ++i)
      grey[i] = depth[i] == 0 ? 0 : 255 - (int) (215L * depth[i] / farthest);
    String caption =
        String.format("depth %d x %d, to %.1f m", image.width, image.height, farthest / 1000.0);
    return new DecodedImage(greyPicture(image, grey), caption);
  }

  private static DecodedImage amplitude(image_t image, byte[] bytes) throws IOException {
    if (bytes.length < pixels(image)) throw new IOException("the amplitude image is too short");
    int brightest = 1;
    for (byte b : bytes) brightest = Math.max(brightest, b & 0xff);
    int[] grey = new int[pixels(image)];
    for (int i = 0; i < grey.length; ++i) grey[i] = 255 * (bytes[i] & 0xff) / brightest;
    return new DecodedImage(greyPicture(image, grey), "amplitude");
  }

  private static BufferedImage greyPicture(image_t image, int[] grey) {
    BufferedImage picture =
        new BufferedImage(image.width, image.height, BufferedImage.TYPE_BYTE_GRAY);
    WritableRaster raster = picture.getRaster();
    raster.setSamples(0, 0, image.width, image.height, 0, grey);
    return picture;
  }

  private static byte[] unzip(byte[] zipped, int size) throws IOException {
    byte[] bytes = new byte[size];
    Inflater inflater = new Inflater();
    try {
      inflater.setInput(zipped);
      int at = 0;
      while (at < size) {
        int n = inflater.inflate(bytes, at, size - at);
        if (n == 0) throw new IOException("a zipped image is too short");
        at += n;
      }
    } catch (DataFormatException error) {
      throw new IOException("a zipped image does not unzip: " + error.getMessage());
    } finally {
      inflater.end();
    }
    return bytes;
  }
}
