#include "server/command_desk.h"

#include <gtest/gtest.h>

#include <string_view>

#include "command/fake_target.h"

namespace eifmap {
namespace {

using namespace std::chrono_literals;
using TimePoint = CommandDesk::TimePoint;

constexpr std::int64_t kEpoch = 1'700'000'000'000'000, kFirstTicket = 1'000'000'000'000;

std::shared_ptr<const Secret> secret(std::string_view text = "this is the secret") {
  return std::make_shared<const Secret>(std::vector<std::uint8_t>(text.begin(), text.end()));
}

class CommandDeskTest : public testing::Test {
 protected:
  void open(std::shared_ptr<const Secret> of, bool is_local) {
    desk_.emplace("cam0", CommandAccess{kEpoch, std::move(of), is_local, kFirstTicket, begin_},
                  target_);
  }
  void SetUp() override { open(nullptr, true); }

  // As somebody who pinged just now.
  command_t command(std::int16_t code, std::int64_t sender = 5) {
    command_t command{};
    command.utime = 1;
    command.sender = sender;
    command.request_id = ++last_id_;
    command.server_epoch = kEpoch;
    command.ticket = ticket();
    command.camera = "cam0";
    command.command = code;
    return command;
  }
  std::int64_t ticket() const {
    return kFirstTicket +
           std::chrono::duration_cast<std::chrono::microseconds>(now_ - begin_).count();
  }
  static void add(command_t& command, const std::string& key, const std::string& value) {
    command.args.emplace_back();
    command.args.back().key = key;
    command.args.back().value = value;
    command.num_args = static_cast<std::int32_t>(command.args.size());
  }

  reply_t send(const command_t& command) {
    const auto bytes = desk_->answer(encode(command), now_);
    EXPECT_TRUE(bytes);
    if (!bytes) return {};
    const Decoded<reply_t> reply = decode_reply(*bytes);
    EXPECT_TRUE(reply.ok()) << reply.detail;
    EXPECT_EQ(reply.value.sender, command.sender);
    EXPECT_EQ(reply.value.request_id, command.request_id);
    EXPECT_EQ(reply.value.command, command.command);
    EXPECT_EQ(reply.value.server_epoch, kEpoch);
    return reply.value;
  }
  static void expect(const reply_t& reply, std::int8_t result, Reason reason) {
    EXPECT_EQ(result_name(reply.result), result_name(result)) << reply.message;
    EXPECT_EQ(static_cast<Reason>(reply.reason), reason) << reply.message;
    EXPECT_NE(reply.message, "");
  }
  void expect_denied(const command_t& command, Reason reason) {
    const std::size_t before = target_.told.size();
    const auto counted = [&] {
      const auto found = desk_->counts().refused.find(reason);
      return found == desk_->counts().refused.end() ? 0 : found->second;
    };
    const std::int64_t refused = counted();
    expect(send(command), reply_t::RESULT_DENIED, reason);
    EXPECT_EQ(target_.told.size(), before) << "it was done";
    EXPECT_EQ(counted(), refused + 1);
  }

  test::FakeTarget target_;
  std::optional<CommandDesk> desk_;
  const TimePoint begin_ = TimePoint(1h);
  TimePoint now_ = begin_ + 10s;
  std::int64_t last_id_ = 0;
};

TEST_F(CommandDeskTest, DoesAndSays) {
  const reply_t reply = send(command(command_t::CMD_PAUSE));
  expect(reply, reply_t::RESULT_OK, Reason::kNone);
  EXPECT_EQ(reply.message, "pause is done");
  EXPECT_EQ(reply.values.at(0).key, "times");
  EXPECT_EQ(reply.camera, "cam0");
  EXPECT_EQ(reply.ticket, ticket());
  EXPECT_EQ(reply.map_id, 2);
  EXPECT_EQ(reply.map_epoch, 1);
  EXPECT_EQ(reply.map_seq, 7);
  EXPECT_EQ(reply.mac_size, 0);
  EXPECT_EQ(target_.told, std::vector<std::string>{"pause"});
  EXPECT_EQ(desk_->counts().done, 1);
  EXPECT_EQ(desk_->counts().last, "pause: pause is done");
}

TEST_F(CommandDeskTest, TheSameRequestIsDoneOnce) {
  const command_t reset = command(command_t::CMD_RESET);
  const auto first = desk_->answer(encode(reset), now_);
  for (int i = 0; i < 100; ++i) {
    now_ += 30s;  // long after its ticket, too
    EXPECT_EQ(desk_->answer(encode(reset), now_), first);
  }
  EXPECT_EQ(target_.told, std::vector<std::string>{"reset"});
  EXPECT_EQ(desk_->counts().repeated, 100);
  send(command(command_t::CMD_RESET));
  EXPECT_EQ(target_.told.size(), 2u) << "another request is another reset";
}

TEST_F(CommandDeskTest, PingTellsWhatACommandMustName) {
  command_t ping = command(command_t::CMD_PING);
  ping.server_epoch = ping.ticket = 0;
  const reply_t reply = send(ping);
  expect(reply, reply_t::RESULT_OK, Reason::kNone);
  command_t pause = command(command_t::CMD_PAUSE);
  pause.server_epoch = reply.server_epoch;
  pause.ticket = reply.ticket;
  expect(send(pause), reply_t::RESULT_OK, Reason::kNone);
  EXPECT_EQ(desk_->counts().pings, 1);
  EXPECT_EQ(desk_->counts().done, 1);
}

TEST_F(CommandDeskTest, AnotherRunsCommandIsRefused) {
  for (const std::int64_t epoch : {kEpoch - 1, kEpoch + 1, std::int64_t{0}}) {
    command_t reset = command(command_t::CMD_RESET);
    reset.server_epoch = epoch;
    expect_denied(reset, Reason::kOtherRun);
  }
  command_t ping = command(command_t::CMD_PING);
  ping.server_epoch = kEpoch - 1;
  expect_denied(ping, Reason::kOtherRun);
}

TEST_F(CommandDeskTest, AnOldTicketIsRefused) {
  command_t reset = command(command_t::CMD_RESET);
  now_ += 60s;
  expect(send(reset), reply_t::RESULT_OK, Reason::kNone);
  reset = command(command_t::CMD_RESET);
  now_ += 60s + 1us;
  expect_denied(reset, Reason::kTooOld);
  for (const std::int64_t bad : {ticket() + 1, kFirstTicket - 1, std::int64_t{0}}) {
    reset = command(command_t::CMD_RESET);
    reset.ticket = bad;
    expect_denied(reset, Reason::kTooOld);
  }
}

TEST_F(CommandDeskTest, WhatCameTooLateIsRefused) {
  const command_t pause = command(command_t::CMD_PAUSE), resume = command(command_t::CMD_RESUME);
  send(resume);
  expect_denied(pause, Reason::kTooOld);
}

TEST_F(CommandDeskTest, WhatIsForgottenIsNotDoneAgain) {
  const command_t first = command(command_t::CMD_RESET);
  send(first);
  for (std::size_t i = 0; i < RequestMemory::kMostRequests; ++i) {
    now_ += 1us;
    send(command(command_t::CMD_PAUSE, 100 + static_cast<std::int64_t>(i)));
  }
  expect_denied(first, Reason::kTooOld);
  EXPECT_EQ(target_.told.size(), RequestMemory::kMostRequests + 1);
}

TEST_F(CommandDeskTest, WithoutASecretOnlyWhereTheNetworkEndsHere) {
  open(nullptr, false);
  expect_denied(command(command_t::CMD_PING), Reason::kSecretWanted);
  command_t reset = command(command_t::CMD_RESET);
  expect_denied(reset, Reason::kSecretWanted);
  sign(reset, *secret());
  expect_denied(reset, Reason::kSecretWanted);
}

TEST_F(CommandDeskTest, WithASecretOnlyWhoSignsWithIt) {
  for (const bool is_local : {false, true}) {
    open(secret(), is_local);
    command_t reset = command(command_t::CMD_RESET);
    expect_denied(reset, Reason::kNotSigned);
    sign(reset, *secret("this is no secret"));
    expect_denied(reset, Reason::kBadSignature);
    sign(reset, *secret());
    command_t changed = reset;
    changed.command = command_t::CMD_SHUTDOWN;
    expect_denied(changed, Reason::kBadSignature);
    const reply_t reply = send(reset);
    expect(reply, reply_t::RESULT_OK, Reason::kNone);
    EXPECT_TRUE(is_signed_by(reply, *secret()));
    EXPECT_FALSE(is_signed_by(reply, *secret("this is no secret")));
  }
}

TEST_F(CommandDeskTest, NothingIsSignedForStrangers) {
  open(secret(), true);
  command_t reset = command(command_t::CMD_RESET);
  EXPECT_EQ(send(reset).mac_size, 0);
  sign(reset, *secret("this is no secret"));
  EXPECT_EQ(send(reset).mac_size, 0);
  reset.server_epoch = 1;
  sign(reset, *secret());
  EXPECT_EQ(send(reset).mac_size, 32) << "a refusal of who has the secret is signed";
}

TEST_F(CommandDeskTest, BadArgumentsAreAnErrorThatIsSaid) {
  const auto scale = [this](const std::string& value, const std::string& sigma) {
    command_t command = this->command(command_t::CMD_SET_SCALE);
    if (!value.empty()) add(command, "metres_per_unit", value);
    if (!sigma.empty()) add(command, "sigma", sigma);
    return send(command);
  };
  expect(scale("2.5", "0.01"), reply_t::RESULT_OK, Reason::kNone);
  expect(scale("2.5", ""), reply_t::RESULT_OK, Reason::kNone);
  EXPECT_EQ(target_.told,
            (std::vector<std::string>{"scale 2.500000 0.010000", "scale 2.500000 0.001000"}));
  for (const char* bad : {"", "two", "0", "-1", "nan", "inf", "1e7", "1e-7"})
    expect(scale(bad, ""), reply_t::RESULT_ERROR, Reason::kBadArguments);
  for (const char* bad : {"0", "-1", "nan", "1"})
    expect(scale("2.5", bad), reply_t::RESULT_ERROR, Reason::kBadArguments);
  command_t pause = command(command_t::CMD_PAUSE);
  add(pause, "name", "x");
  expect(send(pause), reply_t::RESULT_ERROR, Reason::kBadArguments);
  command_t localize = command(command_t::CMD_LOCALIZE_ONLY);
  add(localize, "mode", "maybe");
  expect(send(localize), reply_t::RESULT_ERROR, Reason::kBadArguments);
  EXPECT_EQ(target_.told.size(), 2u);
}

TEST_F(CommandDeskTest, WhatNobodyDoesIsUnsupported) {
  for (const std::int16_t code :
       {command_t::CMD_SAVE, command_t::CMD_LOAD, command_t::CMD_CHECKPOINT, command_t::CMD_UNDO,
        command_t::CMD_LOCALIZE_ONLY}) {
    command_t stored = command(code);
    if (code == command_t::CMD_LOAD) add(stored, "name", "x");
    if (code == command_t::CMD_LOCALIZE_ONLY) add(stored, "mode", "on");
    expect(send(stored), reply_t::RESULT_UNSUPPORTED, Reason::kUnsupported);
  }
  expect(send(command(77)), reply_t::RESULT_UNSUPPORTED, Reason::kUnknownCommand);
}

TEST_F(CommandDeskTest, WhatFailsIsSaid) {
  const reply_t thrown = send(command(command_t::CMD_MAP));
  expect(thrown, reply_t::RESULT_ERROR, Reason::kInternalError);
  EXPECT_NE(thrown.message.find("no maps here"), std::string::npos);
  expect(send(command(command_t::CMD_SNAPSHOT)), reply_t::RESULT_ERROR, Reason::kNoMap);
  EXPECT_EQ(desk_->counts().refused.at(Reason::kNoMap), 1);
}

TEST_F(CommandDeskTest, WhatCannotBeReadHasNobodyToBeTold) {
  auto bytes = encode(command(command_t::CMD_RESET));
  bytes.pop_back();
  EXPECT_FALSE(desk_->answer(bytes, now_));
  command_t other = command(command_t::CMD_RESET);
  other.camera = "cam1";
  EXPECT_FALSE(desk_->answer(encode(other), now_));
  EXPECT_EQ(desk_->counts().refused.at(Reason::kMalformedMessage), 2);
  EXPECT_TRUE(target_.told.empty());
}

TEST(RandomTicket, HasRoomToGrow) {
  for (int i = 0; i < 1000; ++i) {
    const std::int64_t ticket = random_ticket();
    EXPECT_GT(ticket, 0);
    EXPECT_LE(ticket, std::int64_t{1} << 62);
  }
  EXPECT_NE(random_ticket(), random_ticket());
}

}  // namespace
}  // namespace eifmap
