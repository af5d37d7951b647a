#include <lcmslam/web/message.hpp>

#include <nlohmann/json.hpp>

namespace lcmslam {

WebMessage encode_message(const std::string& channel, const std::string& key, std::string_view header,
                          std::string_view payload) {
  std::string names =
      R"({"channel":)" + nlohmann::json(channel).dump() + R"(,"key":)" + nlohmann::json(key).dump();
  if (header.size() > 2)
    names.append(",").append(header.substr(1));
  else
    names += '}';
  names.resize((names.size() + 3) / 4 * 4, ' ');
  auto message = std::make_shared<std::string>();
  message->reserve(4 + names.size() + payload.size());
  for (int i = 0; i < 4; ++i) message->push_back(static_cast<char>(names.size() >> (8 * i)));
  message->append(names).append(payload);
  return message;
}

WebMessage encode_part(const std::string& stream, const std::string& message, std::size_t at,
                       std::size_t size) {
  const std::string header =
      R"({"at":)" + std::to_string(at) + R"(,"of":)" + std::to_string(message.size()) + "}";
  return encode_message("part", stream, header, std::string_view(message).substr(at, size));
}

}  // namespace lcmslam
