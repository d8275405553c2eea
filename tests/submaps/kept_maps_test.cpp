#include "map/kept_maps.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "support/map_scene.h"

namespace eifmap::test {
namespace {

KeptMap kept(std::int64_t map_id, int keyframes) {
  const SyntheticStream world;
  return {map_id, LiveMap(make_scene(world, keyframes), synthetic_camera()), 0, {}};
}

TEST(KeptMaps, ThatWithTheFewestKeyframesGoes) {
  KeptMaps maps(2);
  EXPECT_FALSE(maps.keep(kept(1, 3)));
  EXPECT_FALSE(maps.keep(kept(2, 2)));
  EXPECT_EQ(maps.keep(kept(3, 4))->map_id, 2);
  EXPECT_EQ(maps.keep(kept(4, 2))->map_id, 4);
  EXPECT_EQ(maps.keep(kept(5, 3))->map_id, 1) << "of two as small the one that was left first";
  EXPECT_EQ(maps.size(), 2);
  EXPECT_EQ(maps.views().size(), 2u);
  EXPECT_EQ(maps.take(3).map_id, 3);
  EXPECT_EQ(maps.find(3), nullptr);
  EXPECT_THROW(maps.take(3), std::out_of_range);
}

TEST(KeptMaps, NoneIsKeptWhereNoneMayBe) {
  KeptMaps maps(0);
  EXPECT_EQ(maps.keep(kept(1, 3))->map_id, 1);
  EXPECT_EQ(maps.next_to_try(), nullptr);
}

TEST(KeptMaps, AreTriedInTurn) {
  KeptMaps maps(8);
  for (const int id : {1, 2, 3}) maps.keep(kept(id, 2));
  std::vector<std::int64_t> tried;
  for (int i = 0; i < 4; ++i) tried.push_back(maps.next_to_try()->map_id);
  EXPECT_EQ(tried, (std::vector<std::int64_t>{1, 2, 3, 1}));
}

}  // namespace
}  // namespace eifmap::test
