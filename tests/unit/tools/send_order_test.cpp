#include "tools/send/order.hpp"

#include <gmock/gmock.h>

#include <lcmslam/runtime/confirmation.hpp>
#include <lcmslam/runtime/options.hpp>

namespace lcmslam {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr std::int64_t ours = 4711;

status_t status(const std::string& process, std::int64_t sender) {
  status_t s{};
  s.process = process;
  s.sender = sender;
  s.state = status_t::RUNNING;
  return s;
}

/// The same process after it has received our message.
status_t having_heard(status_t s, const std::string& channel = "COMMAND") {
  input_status_t input{};
  input.channel = channel;
  input.sender = ours;
  input.received = 1;
  s.inputs.push_back(input);
  return s;
}

status_t with(status_t s, const std::string& name, double value) {
  value_t v;
  v.name = name;
  v.value = value;
  s.values.push_back(v);
  return s;
}

status_t with_smoothed(status_t s, std::int64_t poses) {
  output_status_t output{};
  output.channel = "FASTSLAM_SMOOTHED";
  output.sent = poses;
  s.outputs.push_back(output);
  return s;
}

Order::Answer only_answer(const Order& order) {
  const auto answers = order.answers(30);
  EXPECT_THAT(answers, SizeIs(1));
  return answers.empty() ? Order::Answer{} : answers.front();
}

TEST(SendOrder, NobodyIsNamedTogetherWithThoseThatAreThere) {
  Order order("save", {}, ours);
  EXPECT_EQ(order.nobody(), "no process sends STATUS");
  order.hear(status("icp", 1));
  EXPECT_EQ(order.nobody(), "map-server is not there; there are icp");
  order.hear(status("map-server", 2));
  EXPECT_EQ(order.nobody(), "");
  EXPECT_TRUE(order.complete());
}

TEST(SendOrder, WhoIsAboutToEndIsNotThere) {
  Order order("save", {}, ours);
  order.hear(status("map-server", 2));
  status_t leaving = status("map-server", 2);
  leaving.state = status_t::STOPPING;
  order.hear(leaving);
  EXPECT_NE(order.nobody(), "");
}

TEST(SendOrder, ResetIsOneCommandThatConfirmsAllThatHearIt) {
  Order order("reset", {}, ours);
  order.hear(status("icp", -7));
  order.hear(status("camera", 3));
  EXPECT_FALSE(order.complete());
  order.hear(status("fastslam", 5));
  EXPECT_TRUE(order.complete());
  EXPECT_TRUE(order.concerns_all()) << "so that the others are waited for, too";
  EXPECT_FALSE(Order("reset", {"icp"}, ours).concerns_all());
  EXPECT_FALSE(Order("save", {}, ours).concerns_all());
  const auto commands = order.commands();
  ASSERT_THAT(commands, SizeIs(1));
  EXPECT_EQ(commands[0].target, "");
  EXPECT_EQ(commands[0].n, 3);
  EXPECT_TRUE(is_confirmed(commands[0], "icp", -7));
  EXPECT_TRUE(is_confirmed(commands[0], "fastslam", 5));
  EXPECT_TRUE(is_confirmed(commands[0], "camera", 3)) << "or it would be counted as refused there";
}

TEST(SendOrder, OneProcessAloneIsConfirmedAlone) {
  Order order("stop", {"icp"}, ours);
  order.hear(status("icp", 1));
  order.hear(status("fastslam", 2));
  const auto commands = order.commands();
  ASSERT_THAT(commands, SizeIs(1));
  EXPECT_EQ(commands[0].target, "icp");
  EXPECT_THAT(commands[0].keys, ElementsAre("icp"));
  EXPECT_THAT(commands[0].values, ElementsAre("1"));
}

TEST(SendOrder, WhatNeedsNoConfirmationHasNone) {
  Order order("save", {}, ours);
  order.hear(status("map-server", 1));
  EXPECT_THAT(order.commands().at(0).keys, SizeIs(0));
  EXPECT_EQ(order.commands().at(0).target, "map-server");
}

TEST(SendOrder, OnlyAStatusThatCountsOurCommandIsAnAnswer) {
  Order order("reset", {"icp"}, ours);
  order.hear(status("icp", 1));
  order.sent();
  order.hear(status("icp", 1));
  EXPECT_FALSE(order.all_answered());
  EXPECT_EQ(only_answer(order).text, "does not answer (30 s)");
  status_t of_others = having_heard(status("icp", 1));
  of_others.inputs[0].sender = ours + 1;
  order.hear(of_others);
  EXPECT_FALSE(order.all_answered());
  order.hear(having_heard(status("icp", 2)));  // has begun since: does not know of it
  EXPECT_FALSE(order.all_answered());
  order.hear(having_heard(status("icp", 1)));
  EXPECT_TRUE(order.all_answered());
  EXPECT_TRUE(only_answer(order).good);
}

TEST(SendOrder, RefusedIsNotDone) {
  Order order("reset", {"icp"}, ours);
  order.hear(with(status("icp", 1), "commands_refused", 2));
  order.sent();
  order.hear(having_heard(with(status("icp", 1), "commands_refused", 3)));
  EXPECT_FALSE(only_answer(order).good);
  EXPECT_EQ(only_answer(order).text, "refused it");
}

TEST(SendOrder, StoppedIsWhoSaysSo) {
  Order order("stop", {"icp"}, ours);
  order.hear(status("icp", 1));
  order.sent();
  status_t stops = having_heard(status("icp", 1));
  order.hear(stops);
  EXPECT_FALSE(order.all_answered());
  stops.state = status_t::STOPPING;
  order.hear(stops);
  EXPECT_TRUE(only_answer(order).good);
}

TEST(SendOrder, FailedAtTheStopIsSaid) {
  Order order("stop", {"map-server"}, ours);
  order.hear(status("map-server", 1));
  order.sent();
  status_t failed = having_heard(status("map-server", 1));
  failed.state = status_t::FAILED;
  failed.detail = "maps are not saved: disk full";
  order.hear(failed);
  EXPECT_FALSE(only_answer(order).good);
  EXPECT_THAT(only_answer(order).text, HasSubstr("disk full"));
}

struct Saving {
  double saved_before, saved, unsaved, landmarks;
  bool answered, good;
  const char* text;
};

class SendSave : public ::testing::TestWithParam<Saving> {};

TEST_P(SendSave, IsAnsweredByTheServersCounters) {
  const Saving& p = GetParam();
  Order order("save", {}, ours);
  order.hear(with(status("map-server", 1), "saved", p.saved_before));
  order.sent();
  status_t now = with(having_heard(status("map-server", 1)), "saved", p.saved);
  now = with(with(now, "unsaved", p.unsaved), "landmarks", p.landmarks);
  now.detail = "maps are not saved: no room";
  order.hear(now);
  EXPECT_EQ(order.all_answered(), p.answered);
  EXPECT_EQ(only_answer(order).good, p.good);
  EXPECT_THAT(only_answer(order).text, HasSubstr(p.text));
}

INSTANTIATE_TEST_SUITE_P(Cases, SendSave,
                         ::testing::Values(Saving{2, 3, 1, 9, true, true, "the maps are saved"},
                                           Saving{2, 2, 0, 9, true, true, "nothing has changed"},
                                           Saving{0, 0, 0, 0, true, false, "no map yet"},
                                           Saving{2, 2, 5, 9, false, false,
                                                  "nothing came of it: maps are not saved: no room"}));

TEST(SendOrder, SmoothedIsAPathThatWasSent) {
  Order order("smooth", {}, ours);
  order.hear(with_smoothed(status("fastslam", 1), 40));
  order.sent();
  order.hear(with_smoothed(having_heard(status("fastslam", 1)), 40));
  EXPECT_FALSE(order.all_answered());
  order.hear(with_smoothed(having_heard(status("fastslam", 1)), 65));
  EXPECT_TRUE(only_answer(order).good);
  EXPECT_THAT(only_answer(order).text, HasSubstr("25 poses"));
}

TEST(SendOrder, ExportIsARequestAndItsReplyTheAnswer) {
  Order order("export", {}, ours);
  order.hear(status("map-server", 1));
  ASSERT_TRUE(order.is_request());
  const map_request_t request = order.request("evening", "ply");
  EXPECT_EQ(request.kind, map_request_t::EXPORT);
  EXPECT_EQ(request.argument, "evening");
  EXPECT_EQ(request.format, "ply");
  order.sent();
  map_reply_t reply{};
  reply.sender = 1;
  reply.request_id = request.request_id + 1;  // somebody else's
  order.hear(reply);
  EXPECT_FALSE(order.all_answered());
  reply.request_id = request.request_id;
  reply.status = 1;
  reply.message = "folder '../x' is none";
  order.hear(reply);
  EXPECT_FALSE(only_answer(order).good);
  EXPECT_EQ(only_answer(order).text, "folder '../x' is none");
}

TEST(SendOrder, OfThoseAskedWhoIsNotThereIsSaid) {
  Order order("reset", {"icp", "fastslam"}, ours);
  order.hear(status("icp", 1));
  order.sent();
  order.hear(having_heard(status("icp", 1)));
  const auto answers = order.answers(30);
  ASSERT_THAT(answers, SizeIs(2));
  EXPECT_TRUE(answers[0].good);
  EXPECT_EQ(answers[1].process, "fastslam");
  EXPECT_FALSE(answers[1].good);
}

TEST(SendOrder, WhoDoesNothingAtAWordIsNoTarget) {
  try {
    Order("smooth", {"icp"}, ours);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("icp does nothing at 'smooth'"), HasSubstr("fastslam does")));
  }
  EXPECT_THROW(Order("jump", {}, ours), std::invalid_argument);
}

}  // namespace
}  // namespace lcmslam
