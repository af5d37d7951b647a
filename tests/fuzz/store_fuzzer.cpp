// Blobs of a map file, as they are and with a right checksum around any content: refused with BlobError, or
// read; what was read can be written and read again.

#include <algorithm>
#include <cstdlib>

#include <lcmslam/map_store/file/store_codecs.hpp>

namespace lcmslam {
namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

/// The content, in the blob that a writer would have made of it.
Blob sealed(BlobKind kind, bool packed, const Blob& content) {
  BlobWriter writer;
  std::copy(content.begin(), content.end(), writer.grow(content.size()));
  return writer.seal(kind, packed);
}

void read(const Blob& blob, BlobKind kind) {
  switch (kind) {
    case BlobKind::pose:
      encode_pose(decode_pose(blob));
      return;
    case BlobKind::edge:
      decode_edge(encode_edge(decode_edge(blob)));
      return;
    case BlobKind::landmark:
      require(decode_landmark(encode_landmark(decode_landmark(blob))).id == decode_landmark(blob).id);
      return;
    case BlobKind::trajectory:
      require(decode_trajectory(encode_trajectory(decode_trajectory(blob))).size() ==
              decode_trajectory(blob).size());
      return;
    case BlobKind::cloud: {
      const ColouredCloud cloud = decode_cloud(blob);
      require(cloud.colours.size() == cloud.size());
      require(decode_cloud(encode_cloud(cloud)).colours == cloud.colours);
      return;
    }
    case BlobKind::features:
      require(decode_features(encode_features(decode_features(blob))).features.size() ==
              decode_features(blob).features.size());
      return;
    case BlobKind::calibration:
      decode_bytes(blob);
      return;
    case BlobKind::covariance:
      decode_covariance(encode_covariance(decode_covariance(blob)));
      return;
    case BlobKind::images:
      require(decode_images(encode_images(decode_images(blob))).frame.depth.bytes ==
              decode_images(blob).frame.depth.bytes);
      return;
  }
}

}  // namespace
}  // namespace lcmslam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcmslam;
  if (size == 0) return 0;
  const auto kind = static_cast<BlobKind>(1 + data[0] % 9);
  const bool packed = kind == BlobKind::cloud || kind == BlobKind::features || kind == BlobKind::trajectory;
  const Blob bytes(data + 1, data + size);
  for (const Blob& blob : {bytes, sealed(kind, packed, bytes)}) try {
      read(blob, kind);
    } catch (const BlobError&) {
    }
  return 0;
}
