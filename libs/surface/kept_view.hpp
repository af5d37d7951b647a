#pragma once
// The images of a fused keyframe, compressed, until the graph bends and they are fused elsewhere.

#include <lcmslam/imaging/io/encoded_frame.hpp>
#include <lcmslam/surface/surface_view.hpp>

namespace lcmslam {

class KeptView {
 public:
  explicit KeptView(const SurfaceImage& image);

  /// Depth, amplitude and what is seen as they were, bit by bit; colours as JPEG keeps them.
  SurfaceImage unpacked() const;
  std::size_t memory_bytes() const;

 private:
  std::vector<std::uint8_t> depth_;         // packed, of the size of seen_
  EncodedImage amplitude_, colour_, seen_;  // amplitude without bytes: there is none
  Eigen::Isometry3d T_camera_depth_;
};

}  // namespace lcmslam
