// Any text as a question to the map: what is read is written and read again as the same.

#include <cstdlib>

#include <lcmslam/map_query/question.hpp>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcmslam;
  Question question;
  try {
    question = parse_question(std::string(reinterpret_cast<const char*>(data), size));
  } catch (const std::invalid_argument& error) {
    if (std::string(error.what()).empty()) std::abort();
    return 0;
  }
  const std::string once = to_json(question);
  // A yaw beyond pi comes back within it, and quaternions get shorter by a last digit: from then on nothing
  // changes much.
  if (parse_question(once).what.index() != question.what.index()) std::abort();
  return 0;
}
