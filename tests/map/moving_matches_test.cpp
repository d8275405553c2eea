#include "map/moving_matches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "features/front_end.h"
#include "mapper.h"
#include "sequence/recorded_sequence.h"
#include "support/feature_world.h"

namespace eifmap::test {
namespace {

const Rigid3 kKeyframe, kFrame(Eigen::Quaterniond::Identity(), {0.3, 0, 0});

struct Pair {
  Map map{synthetic_camera(), {}};
  ObservedFrame observed;
  Tracking tracking;
  int on_the_thing = 0;  // matches
};

// A keyframe and a frame beside it. What is seen in the left of the image has moved by as many
// pixels as `moved` says of the k-th match; the rest is mapped.
template <class Moved>
Pair make_pair_of_views(Moved moved) {
  Pair pair;
  const SyntheticStream world;
  pair.map.add_keyframe(observe(world.view(0, kKeyframe), synthetic_camera(), MapSign::kMinus, 2),
                        kKeyframe);
  pair.observed = observe(world.view(1, kFrame), synthetic_camera(), MapSign::kMinus, 2);
  pair.tracking.reason = Reason::kNone;
  pair.tracking.world_from_camera = kFrame;
  FramePair& matches = pair.tracking.pair;
  const ObservedFrame& first = pair.map.keyframe(0).observed();
  matches.p = match_omega_p(first, pair.observed, {});
  matches.m = match_omega_m(first, pair.observed, {});
  int k = 0;
  for (const auto* all : {&matches.p, &matches.m})
    for (const Match& match : *all) {
      Eigen::Vector2d& x = pair.observed.x[match.b];
      if (x.x() > -0.25) {
        const Eigen::Vector2d& seen = first.x[match.a];
        const double depth = kFrame.translation.x() / (seen.x() - x.x());
        pair.map.promote(pair.map.add_track({0, match.a}), depth * seen.homogeneous(),
                         Eigen::Matrix3d::Identity());
        continue;
      }
      x += synthetic_camera().radians_per_pixel() * moved(k++);
      ++pair.on_the_thing;
    }
  return pair;
}

int count(const Pair& pair) {
  return count_moving_matches(pair.map, pair.observed, pair.tracking);
}

TEST(MovingMatches, NoneWhereNothingMoves) {
  const Pair pair = make_pair_of_views([](int) { return Eigen::Vector2d(0, 0); });
  ASSERT_GT(pair.on_the_thing, 30);
  EXPECT_EQ(count(pair), 0);
}

TEST(MovingMatches, AllOfAThingThatMoves) {
  const Pair pair = make_pair_of_views([](int) { return Eigen::Vector2d(5, 15); });
  EXPECT_GT(count(pair), pair.on_the_thing * 8 / 10);
  EXPECT_LE(count(pair), pair.on_the_thing);
}

// The camera goes right, the thing faster: it would have to be beyond infinity.
TEST(MovingMatches, AlsoAheadOfTheCamera) {
  const Pair pair = make_pair_of_views([](int) { return Eigen::Vector2d(80, 0); });
  EXPECT_GT(count(pair), pair.on_the_thing * 8 / 10);
}

TEST(MovingMatches, WrongMatchesDoNotGoTogether) {
  Random random(3);
  const Pair pair = make_pair_of_views(
      [&](int) { return Eigen::Vector2d(random.uniform(-200, 200), random.uniform(-200, 200)); });
  EXPECT_LE(count(pair), 2);
}

TEST(MovingMatches, NoneWithoutAPose) {
  Pair pair = make_pair_of_views([](int) { return Eigen::Vector2d(5, 15); });
  pair.tracking.reason = Reason::kTooFewInliers;
  EXPECT_EQ(count(pair), 0);
}

// Rooms in which nothing moves, where the recordings are there.
class MovingMatchesRecorded : public testing::TestWithParam<const char*> {};

TEST_P(MovingMatchesRecorded, NearNone) {
  const char* shared = std::getenv("EIFMAP_SHARED");
  const std::filesystem::path folder =
      std::filesystem::path(shared ? shared : EIFMAP_SHARED_DEFAULT) / "data" / GetParam();
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << "no " << folder;
  const RecordedSequence::Opened opened = RecordedSequence::open(folder);
  ASSERT_TRUE(opened.sequence) << opened.problem;
  const RecordedSequence& sequence = *opened.sequence;
  Mapper mapper(sequence.camera(), {});
  FeatureExtractor extractor;
  for (int i = 0; i < std::min(sequence.size(), 200); ++i)
    mapper.process(extract_frame(extractor, sequence.load_gray(i).image, sequence.camera(),
                                 {sequence.time_us(i), 1, i, "cam0"}));
  const MapperStatistics& s = mapper.statistics();
  EXPECT_GT(s.tracked, 50);
  EXPECT_LT(s.moving_matches, s.tracked);
}

INSTANTIATE_TEST_SUITE_P(Folders, MovingMatchesRecorded, testing::Values("kitchen", "living_room"),
                         [](const auto& case_) { return std::string(case_.param); });

}  // namespace
}  // namespace eifmap::test
