#include "bus/outbox.h"

#include <gtest/gtest.h>

namespace eifmap {
namespace {

using namespace std::chrono_literals;
using TimePoint = Outbox::TimePoint;

constexpr int kRate = 5'000'000;
constexpr std::size_t kPart = 32'000;

TEST(Outbox, KeepsThePaceAndTheOrder) {
  Outbox outbox(kRate);
  constexpr int kParts = 200;
  for (int i = 0; i < kParts; ++i) outbox.push(std::to_string(i), std::vector<std::uint8_t>(kPart));
  const TimePoint begin = TimePoint() + 1h;
  TimePoint now = begin;
  int sent = 0;
  std::size_t bytes = 0;
  for (int calls = 0;; ++calls) {
    ASSERT_LT(calls, 10 * kParts) << "it must come to an end";
    const auto next = outbox.send_due(now, [&](const std::string& channel, const auto& part) {
      EXPECT_EQ(channel, std::to_string(sent++));
      bytes += part.size();
    });
    const double allowed = kRate * std::chrono::duration<double>(now - begin).count() +
                           Outbox::kBurstBytes + static_cast<double>(kPart);
    EXPECT_LE(static_cast<double>(bytes), allowed + 1);
    if (!next) break;
    EXPECT_GT(*next, now) << "the caller must be able to sleep";
    now = *next;
  }
  EXPECT_EQ(sent, kParts);
  const double seconds = std::chrono::duration<double>(now - begin).count();
  EXPECT_NEAR(seconds, kParts * static_cast<double>(kPart) / kRate, 0.05);
}

TEST(Outbox, NothingWaitsWhenThereIsTime) {
  Outbox outbox(kRate);
  int sent = 0;
  TimePoint now = TimePoint() + 1h;
  for (int i = 0; i < 10; ++i, now += 1s) {
    outbox.push("map", std::vector<std::uint8_t>(kPart));
    EXPECT_FALSE(outbox.send_due(now, [&](const auto&, const auto&) { ++sent; }));
    EXPECT_EQ(sent, i + 1);
  }
}

TEST(Outbox, DropsWhatWaitsAndSaysHowMuch) {
  Outbox outbox(kRate);
  for (int i = 0; i < 20; ++i) outbox.push("map", std::vector<std::uint8_t>(kPart));
  const TimePoint now = TimePoint() + 1h;
  int sent = 0;
  EXPECT_TRUE(outbox.send_due(now, [&](const auto&, const auto&) { ++sent; }));
  EXPECT_EQ(outbox.drop_all(), 20 - sent);
  EXPECT_FALSE(outbox.send_due(now + 1h, [&](const auto&, const auto&) { ADD_FAILURE(); }));
}

}  // namespace
}  // namespace eifmap
