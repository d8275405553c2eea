#include "map/audit.h"

#include <gtest/gtest.h>

#include "mapper.h"
#include "simulation/feature_world.h"
#include "support/map_scene.h"

namespace eifmap::test {
namespace {

TEST(Audit, ARealRunUsesEachMeasurementOnce) {
  for (const bool promote : {false, true})
    for (const char* motion : {"sideways", "loop"}) {
      const FeatureWorld world({.motion = motion, .num_frames = 90, .features = 500, .seed = 3});
      MapperOptions options;
      options.landmark.promote_omega_p = promote;
      options.edge.max_spent_ratio = 1;  // as scarce as it gets
      options.edge.min_measurements = 20;
      Mapper mapper(world.camera(), options);
      for (int i = 0; i < world.num_frames(); ++i) mapper.process(world.frame(i).frame);
      EXPECT_GT(mapper.statistics().edges, 10);
      EXPECT_GT(mapper.statistics().keyframes, 15);
      for (const std::string& problem : mapper.audit()) ADD_FAILURE() << motion << ": " << problem;
    }
}

TEST(Audit, FindsWhatIsUsedTwice) {
  const SyntheticStream world;
  Map map = make_scene(world, 3);
  EXPECT_TRUE(audit(map).empty());
  map.spend({0, 1, {{4, 5, 0}}});
  EXPECT_TRUE(audit(map).empty());
  map.spend({1, 2, {{5, 9, 0}}});  // keypoint 5 of keyframe 1 again
  EXPECT_EQ(audit(map).size(), 1u);
  map.add_track({0, 4});  // and one of a feature's
  EXPECT_EQ(audit(map).size(), 2u);
  // That no edge has used; a map lets nobody write to it.
  const_cast<Keyframe&>(map.keyframe(2)).spent[3] = 1;
  EXPECT_EQ(audit(map).size(), 3u);
}

TEST(Audit, FindsAnIndexOfPlacesThatDoesNotFollow) {
  const SyntheticStream world;
  Map map = make_scene(world, 15);
  map.remove_keyframe(3);
  EXPECT_TRUE(audit(map).empty());
  const Map copy = map;
  const_cast<PlaceIndex&>(map.places()).remove(5);
  EXPECT_EQ(audit(map).size(), 2u);  // that one, and how many there are
  EXPECT_TRUE(audit(copy).empty());
  const_cast<PlaceIndex&>(map.places()).add(3, world.frame(3));
  EXPECT_EQ(audit(map).size(), 2u);
}

}  // namespace
}  // namespace eifmap::test
