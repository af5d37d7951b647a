#pragma once
// Pictures for a link that is slower than a camera.

#include <lcmslam/imaging/io/encoded_frame.hpp>

namespace lcmslam::bridge {

/// The colour image alone, at most `width` pixels wide, as a JPEG of this quality; one without a colour image
/// stays without. Throws CodecError.
EncodedFrame smaller_picture(const EncodedFrame& frame, int width, int quality);

}  // namespace lcmslam::bridge
