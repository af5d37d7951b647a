#include "tools/page/offline_page.hpp"

#include "tools/page/self_contained_page.hpp"

namespace lcmslam {

std::string offline_page(const std::filesystem::path& folder, const Board& board) {
  std::string items;
  for (const auto& message : board.messages()) {
    const auto size = static_cast<std::uint32_t>(message->size());
    for (int i = 0; i < 4; ++i) items.push_back(static_cast<char>(size >> (8 * i)));
    items += *message;
  }
  return self_contained_page(
      folder, "page",
      "<script type=\"application/octet-stream;base64\" id=\"lcmslam-items\">" + base64(items) + "</script>");
}

}  // namespace lcmslam
