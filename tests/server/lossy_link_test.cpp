// A server and five clients over a link that loses, reorders and doubles in both directions, with
// late joins and restarts: every client always holds a map exactly as it was published, and the
// last one once all is quiet.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <queue>
#include <random>

#include "published/map_follower.h"
#include "server/map_publisher.h"

namespace eifmap {
namespace {

using namespace std::chrono_literals;
using std::chrono::milliseconds;
using TimePoint = MapPublisher::TimePoint;

constexpr int kClients = 5;
constexpr double kLoss = 0.2, kDoubled = 0.05;
constexpr milliseconds kStep(5), kActive(10'000), kQuiet(60'000);

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  std::int64_t below(std::int64_t n) {
    return static_cast<std::int64_t>(engine_() % static_cast<std::uint64_t>(n));
  }
  bool chance(double p) { return static_cast<double>(engine_()) < p * 4294967296.0; }
  float number() { return static_cast<float>(below(1000)) / 7; }

 private:
  std::mt19937 engine_;
};

// A map that grows, moves, loses what it had and begins anew.
class RandomMap {
 public:
  explicit RandomMap(unsigned seed) : random_(seed) {}

  map_part_t next() {
    map_part_t update{};
    const bool whole = seq_ == 0 || random_.chance(0.03);
    if (whole && random_.chance(0.5)) {
      ++map_id_;
      keyframes_ = landmarks_ = 0;
    }
    map_epoch_ += whole ? 1 : 0;
    update.camera = "cam0";
    update.server_epoch = 42;
    update.map_id = map_id_;
    update.map_epoch = map_epoch_;
    update.base_seq = whole ? -1 : seq_;
    update.seq = seq_ += whole ? 1 + random_.below(3) : 1;
    update.num_parts = 1;
    ++keyframes_;
    landmarks_ += random_.below(60);
    for (std::int64_t i = random_.below(4) + 1; i > 0; --i) update.keyframes.push_back(keyframe());
    for (std::int64_t i = random_.below(80); i > 0; --i) update.landmarks.push_back(landmark());
    for (std::int64_t i = random_.below(80); i > 0; --i)
      update.observations.push_back(observation());
    for (std::int64_t i = random_.below(10); i > 0; --i) update.removed.push_back(any_landmark());
    update.num_keyframes = static_cast<std::int32_t>(update.keyframes.size());
    update.num_landmarks = static_cast<std::int32_t>(update.landmarks.size());
    update.num_observations = static_cast<std::int32_t>(update.observations.size());
    update.num_removed = static_cast<std::int32_t>(update.removed.size());
    return update;
  }

 private:
  std::int64_t any_landmark() { return random_.below(landmarks_ + 1); }
  keyframe_t keyframe() {
    keyframe_t k{};
    k.id = random_.below(keyframes_);
    for (double& x : k.position) x = random_.number();
    k.quaternion[0] = 1;
    for (float& x : k.covariance) x = random_.number();
    return k;
  }
  landmark_t landmark() {
    landmark_t l{};
    l.id = any_landmark();
    l.anchor = random_.below(keyframes_);
    for (float& x : l.position) x = random_.number();
    for (float& x : l.covariance) x = random_.number();
    l.laplacian_sign = random_.chance(0.5) ? 1 : -1;
    return l;
  }
  observation_t observation() {
    observation_t o{};
    o.keyframe = random_.below(keyframes_);
    o.landmark = any_landmark();
    const bool gone = random_.chance(0.2);
    o.u = gone ? std::numeric_limits<float>::quiet_NaN() : random_.number();
    o.v = gone ? std::numeric_limits<float>::quiet_NaN() : random_.number();
    return o;
  }

  Random random_;
  std::int64_t seq_ = 0, map_id_ = 1, map_epoch_ = 0, keyframes_ = 0, landmarks_ = 0;
};

// Messages on their way, by when they arrive.
template <class Message>
class Link {
 public:
  explicit Link(Random& random) : random_(random) {}
  void send(const Message& message, TimePoint now) {
    if (random_.chance(kLoss)) return;
    for (int copies = random_.chance(kDoubled) ? 2 : 1; copies > 0; --copies)
      on_the_way_.emplace(now + milliseconds(random_.below(60)), message);
  }
  template <class Take>
  void deliver(TimePoint now, Take take) {
    while (!on_the_way_.empty() && on_the_way_.begin()->first <= now) {
      take(on_the_way_.begin()->second);
      on_the_way_.erase(on_the_way_.begin());
    }
  }

 private:
  Random& random_;
  std::multimap<TimePoint, Message> on_the_way_;
};

struct Client {
  Client(Random& random, std::int64_t first_name, TimePoint start)
      : parts(random), requests(random), heard(random), name(first_name), starts(start) {}
  void restart() { follower.emplace(++name); }

  Link<std::vector<std::uint8_t>> parts, requests;
  Link<std::pair<std::int64_t, std::int64_t>> heard;  // seq and digest, of statuses
  std::int64_t name;
  TimePoint starts;
  std::optional<MapFollower> follower;
};

struct Totals {
  std::int64_t parts = 0, again = 0, requests = 0, restarts = 0;
  milliseconds longest_quiet{};
};

void run(unsigned seed, Totals& totals) {
  Random random(seed);
  RandomMap map(seed + 1000);
  MapPublisher::Options options;
  options.max_part_bytes = 1400;
  options.bytes_per_s = 500'000;
  options.max_kept_bytes = seed % 3 == 0 ? 30'000 : 1u << 20;
  MapPublisher server(options);
  std::map<std::int64_t, std::int64_t> digests;  // by seq
  const TimePoint start{1h};
  std::vector<Client> clients;
  for (int i = 0; i < kClients; ++i)
    clients.emplace_back(random, 1000 * (i + 1),
                         start + (i < 2 ? milliseconds(0) : milliseconds(random.below(12'000))));
  TimePoint next_update = start, next_status = start;
  const auto all_right = [&] {
    return std::all_of(clients.begin(), clients.end(), [&](const Client& c) {
      return c.follower && !c.follower->is_stale() && c.follower->map().seq() == server.map().seq();
    });
  };
  TimePoint now = start;
  for (; now < start + kActive + kQuiet; now += kStep) {
    if (now > start + kActive + 2s && all_right()) break;
    if (now < start + kActive && now >= next_update) {
      server.publish(map.next(), "eifmap.cam0.map");
      digests[server.map().seq()] = server.map().digest();
      next_update += milliseconds(50 + random.below(200));
    }
    server.send_due(now, [&](const std::string&, const std::vector<std::uint8_t>& bytes) {
      ++totals.parts;
      for (Client& client : clients) client.parts.send(bytes, now);
    });
    if (now >= next_status) {
      next_status += 1s;
      for (Client& client : clients)
        client.heard.send({server.map().seq(), server.map().digest()}, now);
    }
    for (Client& client : clients) {
      if (now < client.starts) continue;
      if (!client.follower) client.restart();
      if (now < start + kActive && random.chance(0.0005)) {
        client.restart();
        ++totals.restarts;
      }
      client.parts.deliver(now, [&](const std::vector<std::uint8_t>& bytes) {
        const auto part = decode_map_part(bytes);
        ASSERT_TRUE(part.ok()) << part.detail;
        if (client.follower->take(part.value, now) != MapFollower::Outcome::kApplied) return;
        const PublishedMap& copy = client.follower->map();
        ASSERT_TRUE(digests.contains(copy.seq()));
        ASSERT_EQ(copy.digest(), digests.at(copy.seq())) << "seed " << seed;
      });
      client.heard.deliver(now, [&](const auto& heard) {
        client.follower->hear("cam0", 42, heard.first, now, heard.second);
      });
      if (const auto request = client.follower->ask(now, 0)) {
        client.requests.send(encode(*request), now);
        ++totals.requests;
      }
      client.requests.deliver(now, [&](const std::vector<std::uint8_t>& bytes) {
        const auto request = decode_map_request(bytes);
        ASSERT_TRUE(request.ok()) << request.detail;
        server.answer(request.value, now);
      });
    }
    if (::testing::Test::HasFatalFailure()) return;
  }
  for (const Client& client : clients) {
    ASSERT_TRUE(client.follower);
    EXPECT_EQ(client.follower->map().digest(), server.map().digest()) << "seed " << seed;
    EXPECT_EQ(encode(client.follower->map().whole()), encode(server.map().whole()));
    EXPECT_EQ(client.follower->counts().wrong_digests, 0);
  }
  totals.again += server.counts().parts_again;
  totals.longest_quiet = std::max(
      totals.longest_quiet, std::chrono::duration_cast<milliseconds>(now - (start + kActive)));
}

TEST(LossyLink, EveryClientEndsWithThePublishedMap) {
  constexpr unsigned kSeeds = 200;
  Totals totals;
  for (unsigned seed = 0; seed < kSeeds && !HasFatalFailure(); ++seed) run(seed, totals);
  EXPECT_GT(totals.again, 100 * kSeeds) << "there was something to repair";
  EXPECT_GT(totals.restarts, kSeeds / 2);
  EXPECT_LT(totals.longest_quiet, 20s);
  std::printf(
      "%u seeds: %ld parts, %ld of them again, %ld requests, %ld restarts; right after %ld ms of "
      "quiet at most\n",
      kSeeds, static_cast<long>(totals.parts), static_cast<long>(totals.again),
      static_cast<long>(totals.requests), static_cast<long>(totals.restarts),
      static_cast<long>(totals.longest_quiet.count()));
}

}  // namespace
}  // namespace eifmap
