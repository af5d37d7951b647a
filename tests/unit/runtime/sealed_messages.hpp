#pragma once
// What tests of seals share.

#include <lcmslam/runtime/seal.hpp>

namespace lcmslam {

inline BusKey key_of(std::uint8_t byte) {
  BusKey key;
  key.fill(byte);
  return key;
}

inline BusMessage sealed(Sealer& sealer, const std::string& channel, std::vector<std::uint8_t> bytes,
                         WallTime at) {
  sealer.seal(channel, bytes, at);
  return {channel, bytes};
}

}  // namespace lcmslam
