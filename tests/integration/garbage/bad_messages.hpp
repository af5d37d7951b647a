#pragma once
// Garbage of many kinds, made from a valid message and a seed.

#include <vector>

#include <lcmslam/geometry/random.hpp>
#include "tests/integration/support/bus.hpp"

namespace lcmslam::integration {

/// None of these can be taken for a valid message: random bytes of 0 to 70000, a right fingerprint before
/// a random body, truncated and extended messages, wrong fingerprints, negative and huge array lengths.
std::vector<Bytes> impossible_messages(const Bytes& valid, Random& random);

/// Right in their form, with absurd values: NaN, infinities, huge numbers, random bits, clocks at the
/// ends of their range. Some may be accepted; none may do harm.
std::vector<Bytes> absurd_messages(const Bytes& valid, Random& random);

/// images_t with a bad image: JPEG and zlib bytes that are garbage, truncated or missing, absurd sizes,
/// unknown formats, no images at all. A consumer that knows its calibration must refuse every one.
std::vector<Bytes> bad_images(const Bytes& valid, Random& random);

}  // namespace lcmslam::integration
