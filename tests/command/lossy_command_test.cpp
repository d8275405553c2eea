// A caller and a desk over a link that loses, doubles and delays both ways, in simulated time.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <string_view>

#include "client/command_caller.h"
#include "command/fake_target.h"
#include "server/command_desk.h"

namespace eifmap {
namespace {

using namespace std::chrono_literals;
using TimePoint = CommandCaller::TimePoint;
using State = CommandCaller::State;
using Wire = std::vector<std::uint8_t>;

struct Fate {
  double lose = 0, twice = 0;
  std::chrono::milliseconds most_delay = 1ms;
};

// Messages on their way, by when they arrive.
class Link {
 public:
  Link(Fate fate, unsigned seed) : fate_(fate), random_(seed) {}

  void send(const Wire& bytes, TimePoint now) {
    const int copies = chance(fate_.lose) ? 0 : chance(fate_.twice) ? 2 : 1;
    for (int i = 0; i < copies; ++i) {
      const auto delay = static_cast<long>(random_() % (1000 * fate_.most_delay.count()));
      on_the_way_.emplace(now + std::chrono::microseconds(delay), bytes);
    }
  }
  std::optional<Wire> arrived(TimePoint now) {
    if (on_the_way_.empty() || on_the_way_.begin()->first > now) return {};
    return on_the_way_.extract(on_the_way_.begin()).mapped();
  }

 private:
  bool chance(double p) { return std::uniform_real_distribution<>()(random_) < p; }

  Fate fate_;
  std::mt19937 random_;
  std::multimap<TimePoint, Wire> on_the_way_;
};

Secret secret(std::string_view text = "this is the secret") {
  return Secret({text.begin(), text.end()});
}

struct Server {
  explicit Server(std::int64_t epoch, bool has_secret, const std::string& camera = "cam0")
      : desk(camera,
             {epoch, has_secret ? std::make_shared<const Secret>(secret()) : nullptr, true,
              1'000'000, TimePoint{}},
             target) {}
  test::FakeTarget target;
  CommandDesk desk;
};

struct Outcome {
  State state;
  std::optional<reply_t> reply;
  std::chrono::milliseconds took;
  int sent, untrusted;
};

class LossyCommand : public testing::Test {
 protected:
  Outcome call(std::vector<Server*> servers, std::int16_t command, Fate fate, unsigned seed,
               const Secret* of = nullptr, std::chrono::milliseconds timeout = 5s) {
    const TimePoint start = now_;
    Link there(fate, 2 * seed), back(fate, 2 * seed + 1);
    CommandCaller caller({"cam0", command, {}}, of, timeout, now_);
    for (; !caller.is_over(); now_ += 1ms) {
      caller.tick(now_, [&](const std::string& channel, const Wire& bytes) {
        EXPECT_EQ(channel, "eifmap.cam0.command");
        there.send(bytes, now_);
      });
      while (const auto bytes = there.arrived(now_))
        for (Server* server : servers)
          if (const auto reply = server->desk.answer(*bytes, now_)) back.send(*reply, now_);
      while (const auto bytes = back.arrived(now_)) caller.take(*bytes, now_);
    }
    // What still is on its way arrives after all.
    for (const TimePoint end = now_ + 10s; now_ < end; now_ += 10ms)
      while (const auto bytes = there.arrived(now_))
        for (Server* server : servers) server->desk.answer(*bytes, now_);
    const bool answered = caller.state() == State::kAnswered;
    return {caller.state(), answered ? std::optional(caller.reply()) : std::nullopt,
            std::chrono::duration_cast<std::chrono::milliseconds>(now_ - 10s - start),
            caller.sent(), caller.untrusted()};
  }
  TimePoint now_ = TimePoint(1h);
};

TEST_F(LossyCommand, IsDoneOnceAndAnswered) {
  const Secret key = secret();
  for (const bool is_signed : {false, true}) {
    Server server(42, is_signed);
    int answered = 0, again = 0;
    std::vector<long> took;
    for (unsigned seed = 0; seed < 100; ++seed) {
      const Outcome outcome = call({&server}, command_t::CMD_RESET, {0.2, 0.2, 300ms}, seed,
                                   is_signed ? &key : nullptr);
      const auto resets = std::count(server.target.told.begin(), server.target.told.end(), "reset");
      server.target.told.clear();
      EXPECT_LE(resets, 1) << "seed " << seed;
      if (outcome.state != State::kAnswered) continue;
      ++answered;
      again += outcome.sent > 2;
      took.push_back(outcome.took.count());
      EXPECT_EQ(outcome.reply->result, reply_t::RESULT_OK) << outcome.reply->message;
      EXPECT_EQ(resets, 1) << "seed " << seed;
    }
    EXPECT_EQ(answered, 100);
    EXPECT_GT(again, 50) << "else this shows little";
    EXPECT_GT(server.desk.counts().repeated, 20) << "else this shows little";
    std::sort(took.begin(), took.end());
    std::cout << "answered after " << took[50] << " ms in the median, " << took.back()
              << " ms at most\n";
  }
}

TEST_F(LossyCommand, NobodyIsThere) {
  const Outcome outcome = call({}, command_t::CMD_PAUSE, {}, 1);
  EXPECT_EQ(outcome.state, State::kNoReply);
  EXPECT_GE(outcome.took, 5s);
  EXPECT_GE(outcome.sent, 6);
  EXPECT_LE(outcome.sent, 12) << "with growing pauses";
}

TEST_F(LossyCommand, TwoServersAreNotBothMeant) {
  Server one(42, false), other(43, false);
  EXPECT_EQ(call({&one, &other}, command_t::CMD_SHUTDOWN, {}, 1).state, State::kSeveral);
  EXPECT_TRUE(one.target.told == std::vector<std::string>{"ping"});
  EXPECT_TRUE(other.target.told == std::vector<std::string>{"ping"});
}

TEST_F(LossyCommand, AnotherServersRefusalIsNoAnswer) {
  const Secret key = secret();
  Server one(42, true);
  CommandAccess access{41, std::make_shared<const Secret>(secret("this is another one")), true,
                       1'000'000, TimePoint{}};
  Server other(41, false);
  CommandDesk stranger("cam0", access, other.target);
  // It answers first.
  CommandCaller caller({"cam0", command_t::CMD_PAUSE, {}}, &key, 5s, now_);
  for (; !caller.is_over(); now_ += 1ms)
    caller.tick(now_, [&](const std::string&, const Wire& bytes) {
      caller.take(*stranger.answer(bytes, now_), now_);
      caller.take(*one.desk.answer(bytes, now_), now_);
    });
  ASSERT_EQ(caller.state(), State::kAnswered);
  EXPECT_EQ(caller.reply().result, reply_t::RESULT_OK) << caller.reply().message;
  EXPECT_EQ(caller.reply().server_epoch, 42);
}

TEST_F(LossyCommand, AWrongSecretIsRefusedAtOnce) {
  Server server(42, true);
  const Secret wrong = secret("this is not the secret");
  Outcome outcome = call({&server}, command_t::CMD_PAUSE, {}, 1, &wrong);
  ASSERT_EQ(outcome.state, State::kAnswered);
  EXPECT_EQ(outcome.reply->result, reply_t::RESULT_DENIED);
  EXPECT_EQ(static_cast<Reason>(outcome.reply->reason), Reason::kBadSignature);
  EXPECT_LT(outcome.took, 500ms);
  outcome = call({&server}, command_t::CMD_PAUSE, {}, 1);
  EXPECT_EQ(static_cast<Reason>(outcome.reply->reason), Reason::kNotSigned);
  EXPECT_TRUE(server.target.told.empty());
}

// Somebody who has no secret says that he is the server.
TEST_F(LossyCommand, AnUnsignedAnswerIsNotBelieved) {
  Server server(42, false);
  const Secret key = secret();
  const Outcome outcome = call({&server}, command_t::CMD_PAUSE, {}, 1, &key);
  EXPECT_EQ(outcome.state, State::kNoReply);
  EXPECT_GT(outcome.untrusted, 0);
}

TEST_F(LossyCommand, AfterARestartItIsNotDone) {
  Server before(42, false), after(43, false);
  CommandCaller caller({"cam0", command_t::CMD_RESET, {}}, nullptr, 5s, now_);
  for (; !caller.is_over(); now_ += 1ms)
    caller.tick(now_, [&](const std::string&, const Wire& bytes) {
      Server& server = caller.state() == State::kPinging ? before : after;
      caller.take(*server.desk.answer(bytes, now_), now_);
    });
  ASSERT_EQ(caller.state(), State::kAnswered);
  EXPECT_EQ(static_cast<Reason>(caller.reply().reason), Reason::kOtherRun);
  EXPECT_TRUE(after.target.told.empty());
}

TEST_F(LossyCommand, RepliesToOthersArePassedOver) {
  Server server(42, false);
  CommandCaller caller({"cam0", command_t::CMD_PAUSE, {}}, nullptr, 1s, now_);
  for (; !caller.is_over(); now_ += 1ms)
    caller.tick(now_, [&](const std::string&, const Wire& bytes) {
      Decoded<reply_t> reply = decode_reply(*server.desk.answer(bytes, now_));
      ++reply.value.sender;
      caller.take(encode(reply.value), now_);
      caller.take({}, now_);
    });
  EXPECT_EQ(caller.state(), State::kNoReply);
}

}  // namespace
}  // namespace eifmap
