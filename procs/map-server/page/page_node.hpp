#pragma once
// The map server with its live page (docs/LIVE_PAGE.md). Batch and tests use the map server alone: they open
// no port.

#include <memory>

#include <lcmslam/web/web_server.hpp>
#include "procs/map-server/page/operator_actions.hpp"
#include "procs/map-server/page/page_feed.hpp"

namespace lcmslam {

class PageNode : public Node {
 public:
  /// Where the port is taken the map server goes on without a page and says so.
  PageNode(const ConfigNode& config, Publisher& publisher);

  void connect(Inputs& inputs) override;
  std::optional<Duration> work() override;
  void command(const command_t& command) override { maps_.command(command); }
  void overhear(const command_t& command) override { maps_.overhear(command); }
  void finish() override;
  NodeReport report() const override;

  /// Where the page is: "http://127.0.0.1:8642/"; empty where none is served.
  std::string address() const { return server_ ? server_->address() : ""; }

 private:
  void serve();

  MapServerSettings settings_;
  MapServerNode maps_;
  Board board_;
  PageFeed feed_;
  PageDesk desk_;
  OperatorActions operator_;
  std::string failure_;                // why there is no page
  std::unique_ptr<WebServer> server_;  // null: no page
};

}  // namespace lcmslam
