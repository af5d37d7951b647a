#pragma once
// A log on the page's board, moment by moment. What the log has of the mappers is shown as it was; of a log
// with raw data alone the graph makes it meanwhile.

#include <lcmslam/configuration/config.hpp>
#include "procs/map-server/page/page_desk.hpp"
#include "procs/map-server/page/page_feed.hpp"
#include "tools/batch/batch_graph.hpp"
#include "tools/log/message_reader.hpp"

namespace lcmslam {

class LogPage {
 public:
  /// `config` of the processes that make what the log lacks. Throws std::runtime_error when the file is no
  /// log, or has nothing that a page could show.
  LogPage(const std::string& file, const ConfigNode& config, Board& board);
  ~LogPage();

  /// What the page may ask for.
  void offer(PageDesk& desk);
  /// Shows what is due. `now` s, of a clock that goes on; to be called often.
  void play(double now);

 private:
  class Silent;  // publishes nothing
  void begin();
  void deliver(const LogEventView& event);
  void show_time();
  nlohmann::json control(const nlohmann::json& request);

  std::string file_;
  const ConfigNode& config_;
  Board& board_;
  Utime first_ = 0, last_ = 0;
  bool computes_ = false;  // the log has raw data alone

  std::unique_ptr<MessageReader> reader_;
  std::unique_ptr<Silent> publisher_;
  std::unique_ptr<MapServerNode> maps_;
  std::unique_ptr<PageFeed> feed_;
  std::unique_ptr<Inputs> inputs_;
  std::unique_ptr<BatchGraph> graph_;

  bool playing_ = true, over_ = false;
  bool seeking_ = false;  // somebody asked for due_, which may take more than one turn
  double speed_ = 1;
  Utime shown_ = 0;       // log time up to which all was delivered
  double due_ = 0;        // log time, us, up to which all is to be shown now
  double then_ = -1;      // s, when play() was called last
  double next_told_ = 0;  // s
};

}  // namespace lcmslam
