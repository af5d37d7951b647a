#include "tools/study/report/study_page.hpp"

#include "tools/page/self_contained_page.hpp"

namespace lcmslam {

std::string study_page(nlohmann::json report, const std::filesystem::path& out,
                       const std::filesystem::path& page) {
  for (auto& experiment : report["experiments"]) {
    if (!experiment.contains("pictures")) continue;
    for (auto& picture : experiment["pictures"]) {
      const std::filesystem::path file = picture["file"].get<std::string>();
      picture["data"] = (file.extension() == ".png" ? "data:image/png;base64," : "data:image/jpeg;base64,") +
                        base64(read_page_file(out / file));
    }
  }
  std::string json = report.dump();
  // '<' stands in texts alone; a text that ended the script would end the page.
  for (std::size_t at = json.find('<'); at != std::string::npos; at = json.find('<', at))
    json.replace(at, 1, "\\u003c");
  return self_contained_page(page, "report",
                             "<script type=\"application/json\" id=\"lcmslam-report\">" + json + "</script>");
}

}  // namespace lcmslam
