#pragma once
// Somebody on the bus who does not belong to the graph: sends its own messages again, older and under another
// name, or what is hardly a message.

#include <lcm/lcm-cpp.hpp>
#include <map>
#include <string>
#include <vector>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/runtime/inputs.hpp>
#include <lcmslam/runtime/publisher.hpp>

namespace lcmslam {

class Stranger {
 public:
  Stranger(lcm::LCM& lcm, std::uint64_t seed) : lcm_(lcm), random_(seed, 77) {}

  /// A message of the graph; the first one of each channel and every hundredth is kept.
  template <class M>
  void listen(Inputs& inputs, const std::string& channel) {
    inputs.subscribe<M>(channel, 1000, [this, channel](const M& m) { keep(channel, encode_message(m)); });
  }

  /// Real messages, those that were kept, of a sender of its own.
  void pretend();
  /// The same with some bytes changed.
  void babble();

 private:
  struct Kept {
    std::int64_t heard = 0;
    std::vector<std::uint8_t> bytes;
  };
  void keep(const std::string& channel, std::vector<std::uint8_t> bytes);
  void send(const std::string& channel, const std::vector<std::uint8_t>& bytes);

  lcm::LCM& lcm_;
  Random random_;
  std::map<std::string, Kept> kept_;
};

}  // namespace lcmslam
