#include "server/map_publisher.h"

#include <gtest/gtest.h>

#include <set>

#include "messages/samples.h"
#include "published/map_follower.h"

namespace eifmap {
namespace {

using namespace std::chrono_literals;
using TimePoint = MapPublisher::TimePoint;

const TimePoint kStart{1h};
const std::string kChannel = "eifmap.cam0.map";

map_part_t update(std::int64_t seq, bool whole, int landmarks = 20, bool of_same = false) {
  MapUpdate sample = samples::map_update(1, landmarks, seq - 1, of_same ? 0 : 100 * seq);
  sample.seq = seq;
  sample.base_seq = whole ? -1 : seq - 1;
  return to_message(sample, {42, "cam0"}, 7);
}

map_request_t request(std::int64_t have_seq, std::vector<missing_part_t> missing = {}) {
  map_request_t r{};
  r.camera = "cam0";
  r.requester = 1;
  r.server_epoch = 42;
  r.have_seq = have_seq;
  r.missing = std::move(missing);
  r.num_missing = static_cast<std::int32_t>(r.missing.size());
  return r;
}

missing_part_t missing(std::int64_t seq, std::int32_t part = kAllParts, bool whole = false) {
  missing_part_t m;
  m.seq = seq;
  m.part = part;
  m.whole = whole ? 1 : 0;
  return m;
}

MapPublisher::Options small_parts() {
  MapPublisher::Options options;
  options.max_part_bytes = 700;
  options.bytes_per_s = 1'000'000'000;
  return options;
}

// What leaves from `now` on, decoded.
std::vector<map_part_t> sent(MapPublisher& publisher, TimePoint now = kStart) {
  std::vector<map_part_t> parts;
  const auto take = [&](const std::string& channel, const std::vector<std::uint8_t>& bytes) {
    EXPECT_EQ(channel, kChannel);
    const auto part = decode_map_part(bytes);
    EXPECT_TRUE(part.ok()) << part.detail;
    parts.push_back(part.value);
  };
  for (auto next = publisher.send_due(now, take); next; next = publisher.send_due(*next, take)) {
  }
  return parts;
}

TEST(MapPublisher, RefusesWhatDoesNotFollowOn) {
  MapPublisher publisher(small_parts());
  EXPECT_THROW(publisher.publish(update(1, false), kChannel), std::invalid_argument);
  publisher.publish(update(5, true), kChannel);
  EXPECT_THROW(publisher.publish(update(5, true), kChannel), std::invalid_argument);
  EXPECT_THROW(publisher.publish(update(7, false), kChannel), std::invalid_argument);
  publisher.publish(update(6, false), kChannel);
  publisher.publish(update(9, true), kChannel);
  EXPECT_EQ(publisher.map().seq(), 9);
}

TEST(MapPublisher, SendsAgainJustWhatIsMissing) {
  MapPublisher publisher(small_parts());
  publisher.publish(update(1, true), kChannel);
  publisher.publish(update(2, false), kChannel);
  const std::size_t all = sent(publisher).size();
  ASSERT_GE(all, 6u);
  publisher.answer(request(1, {missing(2, 1), missing(3)}), kStart + 1s);
  const auto again = sent(publisher, kStart + 1s);
  ASSERT_EQ(again.size(), 1u);
  EXPECT_EQ(again[0].seq, 2);
  EXPECT_EQ(again[0].part, 1);
  publisher.answer(request(1), kStart + 2s);
  for (const map_part_t& part : sent(publisher, kStart + 2s)) EXPECT_EQ(part.seq, 2);
}

TEST(MapPublisher, SeveralWhoAskAreServedByOneSend) {
  MapPublisher publisher(small_parts());
  publisher.publish(update(1, true), kChannel);
  publisher.answer(request(-1), kStart) /* while it waits */;
  const std::size_t parts = sent(publisher).size();
  publisher.answer(request(-1), kStart + 10ms) /* it has just left */;
  EXPECT_TRUE(sent(publisher, kStart + 10ms).empty());
  for (int i = 0; i < 5; ++i) publisher.answer(request(-1), kStart + 1s);
  EXPECT_EQ(sent(publisher, kStart + 1s).size(), parts);
  EXPECT_EQ(publisher.counts().parts_again, static_cast<std::int64_t>(parts));
}

TEST(MapPublisher, ALateClientGetsTheMapThatTheOthersHold) {
  for (const std::size_t kept : {std::size_t{1}, std::size_t{20'000}, std::size_t{1} << 30}) {
    MapPublisher::Options options = small_parts();
    options.max_kept_bytes = kept;
    MapPublisher publisher(options);
    for (std::int64_t seq = 1; seq <= 60; ++seq) publisher.publish(update(seq, seq == 1), kChannel);
    sent(publisher);
    MapFollower late(1);
    late.hear("cam0", 42, 60, kStart);
    publisher.answer(*late.ask(kStart + 1s, 0), kStart + 1s);
    for (const map_part_t& part : sent(publisher, kStart + 1s)) late.take(part, kStart + 1s);
    EXPECT_FALSE(late.is_stale()) << kept;
    EXPECT_EQ(encode(late.map().whole()), encode(publisher.map().whole()));
  }
}

TEST(MapPublisher, AnswersWithTheWholeMapWhereStepsAreForgottenOrOfAnotherRun) {
  MapPublisher::Options options = small_parts();
  options.max_kept_bytes = 10'000;
  MapPublisher publisher(options);
  for (std::int64_t seq = 1; seq <= 30; ++seq) publisher.publish(update(seq, seq == 1), kChannel);
  sent(publisher);
  map_request_t of_another_run = request(29, {missing(30)});
  of_another_run.server_epoch = 41;
  TimePoint now = kStart;
  for (const map_request_t& r : {request(2, {missing(3, 0)}), request(2), of_another_run}) {
    publisher.answer(r, now += 1s);
    std::set<std::int64_t> wholes;
    for (const map_part_t& part : sent(publisher, now))
      if (part.base_seq == -1) wholes.insert(part.seq);
    EXPECT_EQ(wholes.size(), 1u);
  }
  EXPECT_EQ(publisher.counts().whole_maps, 1) << "put together once";
}

// A map at its bound changes for ever: what is kept of its past is no more than what it is.
TEST(MapPublisher, KeepsNoMoreOfThePastThanIsOfUse) {
  MapPublisher::Options options = small_parts();
  options.small_map_bytes = 20'000;
  MapPublisher publisher(options);
  const auto most = [&] {
    return std::max<std::size_t>(20'000, 2 * publisher.map().whole_bytes());
  };
  for (std::int64_t seq = 1; seq <= 300; ++seq) {
    publisher.publish(update(seq, seq == 1, 300, true), kChannel);
    EXPECT_LE(publisher.kept_bytes(), most());
  }
  EXPECT_GT(2 * publisher.map().whole_bytes(), 20'000u);
  EXPECT_GT(publisher.kept_bytes(), most() / 2);
  const std::size_t whole = publisher.map().whole_bytes();
  EXPECT_NEAR(static_cast<double>(encode(publisher.map().whole()).size()),
              static_cast<double>(whole), 200);
}

TEST(MapPublisher, ANewMapPutsAnEndToWhatWaitsOfTheOld) {
  MapPublisher::Options options = small_parts();
  options.bytes_per_s = 1;
  MapPublisher publisher(options);
  publisher.publish(update(1, true, 2000), kChannel);
  publisher.send_due(kStart, [](const auto&, const auto&) {});
  publisher.publish(update(2, true, 1), kChannel);
  EXPECT_GT(publisher.counts().parts_dropped, 10);
  publisher.answer(request(1, {missing(1)}), kStart + 1h);
  publisher.send_due(kStart + 10h, [](const auto&, const std::vector<std::uint8_t>& bytes) {
    EXPECT_EQ(decode_map_part(bytes).value.seq, 2);
  });
}

TEST(MapPublisher, HasNothingToSayBeforeThereIsAMap) {
  MapPublisher publisher(small_parts());
  publisher.answer(request(-1), kStart);
  EXPECT_TRUE(sent(publisher).empty());
}

}  // namespace
}  // namespace eifmap
