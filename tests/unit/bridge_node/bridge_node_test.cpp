// The node without a broker: a link of the test's own takes what it gives.

#include "procs/bridge/bridge_node.hpp"

#include <gmock/gmock.h>
#include <chrono>
#include <thread>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/pose_estimate_t.hpp>
#include <lcmslam/status_t.hpp>
#include "tests/unit/messages/samples.hpp"
#include "tests/unit/runtime/capturing_publisher.hpp"

namespace lcmslam {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

struct NoLink : bridge::BrokerLink {
  std::string state() const override { return "a test"; }
};

class BridgeNodeTest : public ::testing::Test {
 protected:
  void make(BridgeSettings settings = {}, const std::vector<std::string>& receive = {"COMMAND"}) {
    settings.robot = "dora";
    settings.receive = receive;
    node_ = std::make_unique<BridgeNode>(settings, publisher_, [this](const BridgeEnds& ends) {
      ends_.emplace(ends);
      return std::make_unique<NoLink>();
    });
    node_->connect(inputs_);
    ends_->outbox.connected();
    ends_->outbox.broker_keeps(0);
  }
  template <class M>
  void deliver(const std::string& channel, const M& message) {
    const auto bytes = encode_message(message);
    ASSERT_TRUE(inputs_.deliver(channel, bytes.data(), bytes.size()));
  }
  std::vector<bridge::Outgoing> take_all() {
    std::vector<bridge::Outgoing> all;
    while (const auto out = ends_->next(std::chrono::steady_clock::now())) {
      all.push_back(*out);
      ends_->outbox.acknowledged(out->ticket, std::chrono::steady_clock::now());
    }
    return all;
  }
  static pose_estimate_t pose(std::int64_t seq) {
    pose_estimate_t message{};
    message.utime = seq;
    message.seq = seq;
    message.sender = 7;
    return message;
  }

  struct BusPublisher : testing::CapturingPublisher {
    std::chrono::microseconds pace() const override { return pace_; }
    std::chrono::microseconds pace_{0};
  };
  BusPublisher publisher_;
  Inputs inputs_;
  std::optional<BridgeEnds> ends_;
  std::unique_ptr<BridgeNode> node_;
};

TEST_F(BridgeNodeTest, WhatIsThinnedOutIsNumberedAnew) {
  make();
  for (int seq = 100; seq < 110; ++seq) deliver("ICP_POSE", pose(seq));
  auto out = take_all();
  ASSERT_THAT(out, SizeIs(1));
  const auto first = decode_message<pose_estimate_t>(out[0].bytes->data(), out[0].bytes->size());
  EXPECT_EQ(first.utime, 109) << "the newest";
  EXPECT_EQ(first.seq, 0);
  EXPECT_EQ(first.sender, 7);
}

TEST_F(BridgeNodeTest, AKeyframeGoesInPiecesThatAreKept) {
  make();
  keyframe_t keyframe{};
  keyframe.sender = 1;
  keyframe.frame = "map/2";
  keyframe.id = 3;
  keyframe.n_tiles = 1;
  keyframe.n_values = 6000;
  keyframe.position.resize(6000);
  keyframe.colour.resize(6000, 7);
  keyframe.normal.resize(6000);
  deliver("ICP_KEYFRAME", keyframe);
  const auto out = take_all();
  EXPECT_THAT(out, SizeIs(4));
  PartAssembler assembler;
  std::optional<PartAssembler::Whole> whole;
  for (const auto& piece : out) {
    EXPECT_TRUE(piece.kept);
    EXPECT_THAT(piece.name, HasSubstr("ICP_KEYFRAME_PART/0000000000000001/map_2/3/0/"));
    EXPECT_LT(piece.bytes->size(), 8200U);
    whole = assembler.add(decode_message<part_t>(piece.bytes->data(), piece.bytes->size()));
  }
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->channel, "ICP_KEYFRAME");
  EXPECT_EQ(whole->bytes, encode_message(keyframe));
}

TEST_F(BridgeNodeTest, AKeyframeThatIsToldAgainAsItWasDoesNotGoAgain) {
  make();
  keyframe_t keyframe{};
  keyframe.sender = 1;
  keyframe.frame = "map";
  keyframe.n_tiles = 1;
  keyframe.map_revision = 5;
  deliver("ICP_KEYFRAME", keyframe);
  EXPECT_THAT(take_all(), SizeIs(1));
  keyframe.seq = 7;
  keyframe.T_map_camera.trans[0] = 2;  // ICP_GRAPH tells that
  deliver("ICP_KEYFRAME", keyframe);
  EXPECT_THAT(take_all(), SizeIs(0));
  keyframe.map_revision = 6;
  deliver("ICP_KEYFRAME", keyframe);
  EXPECT_THAT(take_all(), SizeIs(1));
  ends_->outbox.forget("ICP_KEYFRAME", "");
  take_all();
  deliver("ICP_KEYFRAME", keyframe);
  EXPECT_THAT(take_all(), SizeIs(1)) << "it is there again";
}

// Ten minutes without a link, then the graph is told whole: what it has given up meanwhile goes from the
// broker.
TEST_F(BridgeNodeTest, KeyframesThatWentWhileThereWasNoLinkAreForgotten) {
  BridgeSettings settings;
  settings.send = {"ICP_KEYFRAME", "ICP_GRAPH"};
  make(settings);
  const auto graph_of = [](const std::vector<std::int32_t>& ids) {
    graph_t graph{};
    graph.frame = "map";
    graph.sender = 1;
    for (const std::int32_t id : ids) {
      graph_node_t node{};
      node.keyframe = id;
      node.T_map_camera.quat[0] = 1;
      graph.nodes.push_back(node);
    }
    graph.n_nodes = static_cast<std::int32_t>(graph.nodes.size());
    return graph;
  };
  for (const std::int32_t id : {1, 2}) {
    keyframe_t keyframe{};
    keyframe.sender = 1;
    keyframe.frame = "map";
    keyframe.id = id;
    keyframe.n_tiles = 1;
    keyframe.map_revision = id;
    deliver("ICP_KEYFRAME", keyframe);
  }
  deliver("ICP_GRAPH", graph_of({1, 2}));
  node_->work();
  take_all();
  ends_->outbox.disconnected();
  deliver("ICP_GRAPH", graph_of({1}));
  node_->work();
  ends_->outbox.connected();
  ends_->outbox.broker_keeps(ends_->outbox.mark());
  node_->work();
  std::vector<std::string> cleared;
  for (const auto& out : take_all())
    if (out.bytes->empty()) cleared.push_back(out.name);
  EXPECT_THAT(cleared, ElementsAre(HasSubstr("ICP_KEYFRAME/0000000000000001/map/2/")));
}

// The mapper lives on, and its map is told in the other form than before.
class BridgeSnapshots : public BridgeNodeTest {
 protected:
  void SetUp() override {
    BridgeSettings settings;
    settings.send = {"ICP_GRAPH"};
    make(settings);
  }
  /// Names of what goes for a graph that is told whole, as after each new connection.
  std::vector<std::string> tell_whole(std::size_t nodes) {
    graph_t graph{};
    graph.frame = "map";
    graph.sender = 1;
    graph.nodes.resize(nodes);
    for (std::size_t i = 0; i < nodes; ++i) {
      graph.nodes[i].keyframe = static_cast<std::int32_t>(i);
      graph.nodes[i].T_map_camera.quat[0] = 1;
    }
    graph.n_nodes = static_cast<std::int32_t>(nodes);
    ends_->outbox.disconnected();
    ends_->outbox.connected();
    ends_->outbox.broker_keeps(ends_->outbox.mark());
    deliver("ICP_GRAPH", graph);
    node_->work();
    std::vector<std::string> names;
    for (const auto& out : take_all()) names.push_back(out.name + (out.bytes->empty() ? " cleared" : ""));
    return names;
  }
  const std::string whole_ = "ICP_GRAPH/0000000000000001/map",
                    piece_ = "ICP_GRAPH_PART/0000000000000001/map/";
};

TEST_F(BridgeSnapshots, PiecesThatAFormerRunLeftAreNoneBeforeTheMapIsToldWhole) {
  EXPECT_THAT(tell_whole(1), ElementsAre(piece_ + "0 cleared", whole_));
  EXPECT_THAT(tell_whole(2), ElementsAre(whole_)) << "once is enough";
  EXPECT_THAT(tell_whole(150), ElementsAre(whole_ + " cleared", piece_ + "1", piece_ + "0"));
  EXPECT_THAT(tell_whole(2), ElementsAre(piece_ + "1 cleared", piece_ + "0 cleared", whole_));
}

TEST_F(BridgeSnapshots, AWholeMapThatAFormerRunLeftIsNoMoreBeforeThePiecesCome) {
  EXPECT_THAT(tell_whole(150), ElementsAre(whole_ + " cleared", piece_ + "1", piece_ + "0"));
}

TEST_F(BridgeNodeTest, AnOperatorWhoMissesSomethingAsksTheBrokerAndNotTheRobot) {
  BridgeSettings settings;
  settings.side = bridge::Side::operating;
  settings.send = {"COMMAND"};
  make(settings);
  command_t order{};
  order.name = "resend";
  deliver("COMMAND", order);
  deliver("COMMAND", order);
  EXPECT_THAT(take_all(), SizeIs(0));
  EXPECT_EQ(ends_->recalls(), 1) << "once in a while";
  order.name = "smooth";
  deliver("COMMAND", order);
  EXPECT_THAT(take_all(), SizeIs(1));
}

TEST_F(BridgeNodeTest, KeyframesThatComeTheNewestFirstAreNotTakenForLost) {
  BridgeSettings settings;
  settings.side = bridge::Side::operating;
  settings.send = {"COMMAND"};
  make(settings, {"ICP_KEYFRAME"});
  for (const std::int64_t seq : {8, 3, 5}) {
    keyframe_t keyframe{};
    keyframe.seq = seq;
    keyframe.sender = 4;
    const auto bytes = encode_message(keyframe);
    ends_->take("ICP_KEYFRAME", bytes.data(), bytes.size(), true);
  }
  node_->work();
  std::vector<std::int64_t> numbers;
  for (const keyframe_t& keyframe : publisher_.on<keyframe_t>("ICP_KEYFRAME"))
    numbers.push_back(keyframe.seq);
  EXPECT_THAT(numbers, ElementsAre(0, 1, 2));
}

// The broker gives all that it keeps at once; receive buffers on the bus hold some forty tiles.
TEST_F(BridgeNodeTest, AWholeMapGoesOnTheBusAsFastAsThatTakesIt) {
  publisher_.pace_ = std::chrono::milliseconds(1);
  BridgeSettings settings;
  settings.side = bridge::Side::operating;
  settings.send = {"COMMAND"};
  make(settings, {"STATUS"});
  constexpr std::size_t messages = 200;
  status_t tile{};
  tile.detail.assign(50'000, 'x');
  const auto bytes = encode_message(tile);
  std::thread link([&] {
    for (std::size_t i = 0; i < messages; ++i) ends_->take("STATUS", bytes.data(), bytes.size(), true);
  });
  const auto begin = std::chrono::steady_clock::now();
  const auto elapsed = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  while (publisher_.all.size() < messages && elapsed() < 20) {
    node_->work();
    EXPECT_LE(static_cast<double>(publisher_.all.size()), 3 + 1000 * elapsed() * 60 / 50);
  }
  link.join();
  EXPECT_EQ(publisher_.all.size(), messages);
  EXPECT_THAT(node_->report().values, ::testing::Contains(std::make_pair(std::string("inbox_drops"), 0.0)));
}

TEST_F(BridgeNodeTest, TheLinkWaitsForTheBusAndNotForItsEnd) {
  publisher_.pace_ = std::chrono::hours(1);
  BridgeSettings settings;
  settings.side = bridge::Side::operating;
  settings.send = {"COMMAND"};
  make(settings, {"STATUS"});
  status_t tile{};
  tile.detail.assign(1'100'000, 'x');
  const auto bytes = encode_message(tile);
  const auto take = [&] { ends_->take("STATUS", bytes.data(), bytes.size(), true); };
  const auto begin = std::chrono::steady_clock::now();
  take(), take(), take();
  EXPECT_GT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(900)) << "the inbox is full";
  node_->finish();
  const auto end = std::chrono::steady_clock::now();
  for (int i = 0; i < 100; ++i) take();
  EXPECT_LT(std::chrono::steady_clock::now() - end, std::chrono::seconds(10));
}

TEST_F(BridgeNodeTest, NobodyOutsideMakesTheMappersTellAll) {
  make();
  command_t order{};
  order.name = "resend";
  const auto bytes = encode_message(order);
  ends_->take("COMMAND", bytes.data(), bytes.size(), false);
  node_->work();
  EXPECT_THAT(publisher_.on<command_t>("COMMAND"), SizeIs(1)) << "the bridge's own, at its beginning";
  EXPECT_EQ(node_->report().refused, 1);
}

TEST_F(BridgeNodeTest, APictureGoesSmallAndWithoutDepth) {
  make();
  Random random(1);
  images_t images = to_message(testing::some_frame(random, 640, 480));
  set_origin(images, {50, 7});
  deliver("CAMERA", images);
  deliver("CAMERA", images);
  const auto out = take_all();
  ASSERT_THAT(out, SizeIs(1)) << "one each two seconds";
  const auto picture = decode_message<images_t>(out[0].bytes->data(), out[0].bytes->size());
  ASSERT_GE(picture.n_images, 1);
  EXPECT_EQ(picture.images[0].width, 320);
  for (int i = 1; i < picture.n_images; ++i) EXPECT_EQ(picture.images[static_cast<std::size_t>(i)].size, 0);
  EXPECT_LT(out[0].bytes->size(), 60'000U);
  EXPECT_EQ(origin(picture).sender, 7);
}

TEST_F(BridgeNodeTest, AsksTheMappersForTheirMapsAtTheBeginning) {
  make();
  node_->work();
  node_->work();
  const auto commands = publisher_.on<command_t>("COMMAND");
  ASSERT_THAT(commands, SizeIs(1));
  EXPECT_EQ(commands[0].name, "resend");
  EXPECT_EQ(commands[0].target, "");
}

TEST_F(BridgeNodeTest, OrdersFromOutsideGoOnTheBusAsTheyAre) {
  make();
  command_t command{};
  command.name = "smooth";
  command.seq = 12;
  command.sender = 99;
  const auto bytes = encode_message(command);
  ends_->take("COMMAND", bytes.data(), bytes.size(), false);
  ends_->take("CAMERA", bytes.data(), bytes.size(), false);
  node_->work();
  const auto commands = publisher_.on<command_t>("COMMAND");
  ASSERT_THAT(commands, SizeIs(2)) << "resend, and this one";
  EXPECT_EQ(commands[0].seq, 12);
  EXPECT_EQ(commands[0].sender, 99);
  const NodeReport report = node_->report();
  EXPECT_THAT(report.values, ::testing::Contains(std::make_pair(std::string("refused"), 1.0)));
  EXPECT_EQ(report.refused, 1) << "STATUS tells it soon";
}

TEST_F(BridgeNodeTest, TheLastWordOfABurstReachesTheBus) {
  make();
  command_t command{};
  command.name = "smooth";
  for (command.seq = 1; command.seq <= 30; ++command.seq) {
    const auto bytes = encode_message(command);
    ends_->take("COMMAND", bytes.data(), bytes.size(), false);
  }
  const auto last = [&] {
    node_->work();
    const auto commands = publisher_.on<command_t>("COMMAND");
    return commands.empty() ? 0 : commands.back().seq;
  };
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(5);
  while (last() != 30 && std::chrono::steady_clock::now() < until) std::this_thread::yield();
  EXPECT_EQ(last(), 30);
}

TEST_F(BridgeNodeTest, WrongSettingsAreSaid) {
  BridgeSettings settings;
  settings.host = "broker.example";
  EXPECT_THROW(make(settings), std::invalid_argument);
  settings.insecure = true;
  EXPECT_NO_THROW(make(settings));
  EXPECT_THROW(BridgeNode::read(ConfigNode::parse("{send: [A@x]}")), ConfigError);
  EXPECT_THROW(BridgeNode::read(ConfigNode::parse("{side: middle}")), ConfigError);
  EXPECT_THROW(BridgeNode::read(ConfigNode::parse("{send: [A@5, B], receive: [C, A]}")), ConfigError)
      << "two bridges would send it to each other for ever";
  EXPECT_NO_THROW(BridgeNode::read(ConfigNode::parse("{send: [A@5, B], receive: [C, D]}")));
}

}  // namespace
}  // namespace lcmslam
