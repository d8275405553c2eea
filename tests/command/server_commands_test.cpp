// Commands to a server as a whole, over a bus, with cameras that are none.
#include "server/server_commands.h"

#include <gtest/gtest.h>

#include "client/command_caller.h"
#include "client/memory_bus.h"
#include "command/fake_target.h"

namespace eifmap {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

// As a mapping thread would do it, but at once.
ServerCommands::Camera camera_of(const std::string& name, test::FakeTarget& target) {
  return {name, [&target](const ServerCommands::Action& action) {
            std::packaged_task<CommandOutcome()> task([&] { return action(target); });
            auto outcome = task.get_future();
            task();
            return outcome;
          }};
}

class ServerCommandsTest : public testing::Test {
 protected:
  void open(std::vector<ServerCommands::Camera> cameras) {
    commands_.emplace(
        CommandAccess{42, nullptr, true, 1000, Clock::now()}, network_.sender(),
        [cameras] { return cameras; },
        [this](const CommandDesk::Counts& counts) { done_ = counts.done; });
  }

  reply_t call(std::int16_t command, std::vector<diagnostic_t> args = {}) {
    CommandCaller caller({std::string(kNoCamera), command, std::move(args)}, nullptr, 20s,
                         Clock::now());
    std::size_t seen = network_.messages().size();
    while (!caller.is_over()) {
      caller.tick(Clock::now(), [this](const std::string& channel, const auto& bytes) {
        EXPECT_EQ(channel, "eifmap.server.command");
        commands_->receive(bytes);
      });
      for (const auto& messages = network_.messages(); seen < messages.size(); ++seen) {
        EXPECT_EQ(messages[seen].channel, "eifmap.server.reply");
        caller.take(messages[seen].bytes, Clock::now());
      }
    }
    EXPECT_EQ(caller.state(), CommandCaller::State::kAnswered);
    return caller.state() == CommandCaller::State::kAnswered ? caller.reply() : reply_t{};
  }
  static std::string value(const reply_t& reply, const std::string& key) {
    for (const diagnostic_t& entry : reply.values)
      if (entry.key == key) return entry.value;
    return "";
  }

  test::Recorder network_;
  test::FakeTarget front_, back_;
  std::atomic<std::int64_t> done_ = 0;
  std::optional<ServerCommands> commands_;  // last: its thread uses the others
};

TEST_F(ServerCommandsTest, AreDoneToAll) {
  open({camera_of("front", front_), camera_of("back", back_)});
  const reply_t reply = call(command_t::CMD_PAUSE);
  EXPECT_EQ(reply.result, reply_t::RESULT_OK);
  EXPECT_EQ(reply.message, "front: pause is done; back: pause is done");
  EXPECT_EQ(value(reply, "front.times"), "1");
  EXPECT_EQ(front_.told, std::vector<std::string>{"pause"});
  EXPECT_EQ(back_.told, std::vector<std::string>{"pause"});
  EXPECT_EQ(value(call(command_t::CMD_PING), "cameras"), "front back");
  EXPECT_EQ(done_, 1);
}

TEST_F(ServerCommandsTest, OfOneAreAsOfThatOne) {
  open({camera_of("front", front_)});
  const reply_t reply = call(command_t::CMD_RESET);
  EXPECT_EQ(reply.message, "reset is done");
  EXPECT_EQ(value(reply, "times"), "1");
}

TEST_F(ServerCommandsTest, OfNoneHaveNothingToBeDoneTo) {
  open({});
  const reply_t reply = call(command_t::CMD_PAUSE);
  EXPECT_EQ(reply.result, reply_t::RESULT_ERROR);
  EXPECT_EQ(static_cast<Reason>(reply.reason), Reason::kNoMap);
  EXPECT_EQ(value(call(command_t::CMD_PING), "cameras"), "");
}

TEST_F(ServerCommandsTest, WhatOneRefusesIsSaid) {
  open({camera_of("front", front_), camera_of("back", back_)});
  const reply_t reply = call(command_t::CMD_SAVE);
  EXPECT_EQ(reply.result, reply_t::RESULT_UNSUPPORTED);
  EXPECT_EQ(static_cast<Reason>(reply.reason), Reason::kUnsupported);
  EXPECT_EQ(static_cast<Reason>(call(command_t::CMD_SNAPSHOT).reason), Reason::kNoMap);
}

TEST_F(ServerCommandsTest, AScaleIsOfOneMap) {
  diagnostic_t scale;
  scale.key = "metres_per_unit";
  scale.value = "2";
  open({camera_of("front", front_), camera_of("back", back_)});
  EXPECT_EQ(static_cast<Reason>(call(command_t::CMD_SET_SCALE, {scale}).reason),
            Reason::kBadArguments);
  EXPECT_TRUE(front_.told.empty());
  open({camera_of("front", front_)});
  EXPECT_EQ(call(command_t::CMD_SET_SCALE, {scale}).result, reply_t::RESULT_OK);
}

TEST_F(ServerCommandsTest, ShutdownLeavesTimeForTheReply) {
  open({camera_of("front", front_)});
  EXPECT_FALSE(commands_->told_to_stop());
  EXPECT_EQ(call(command_t::CMD_SHUTDOWN).result, reply_t::RESULT_OK);
  EXPECT_TRUE(front_.told.empty());
  EXPECT_EQ(call(command_t::CMD_PING).result, reply_t::RESULT_OK) << "it lingers";
  for (int i = 0; i < 10000 && !commands_->told_to_stop(); ++i) std::this_thread::sleep_for(1ms);
  EXPECT_TRUE(commands_->told_to_stop());
}

TEST_F(ServerCommandsTest, ACameraThatEndsIsSaid) {
  open({{"front", [](const ServerCommands::Action&) {
           return std::promise<CommandOutcome>().get_future();  // broken
         }}});
  EXPECT_EQ(static_cast<Reason>(call(command_t::CMD_PAUSE).reason), Reason::kInternalError);
}

}  // namespace
}  // namespace eifmap
